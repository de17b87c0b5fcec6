// SPDX-License-Identifier: BSD-3-Clause
/** What a host and a navigator plugin share: the 3-D forms of MRPT's navigation vocabulary.
 *
 *  A host derives its vehicle from RobotInterface3D, then
 *
 *    NavigatorFactory::loadModule("slalom-tracker");                  // or a path to the .so
 *    auto navigator = NavigatorFactory::named("TrackerNavigatorFactory")->create(robot);
 *    navigator->loadConfigFile(config);                               // strict: throws on mistakes
 *    navigator->initialize();
 *    navigator->navigate(&goal);                                      // a NavigationParams3D
 *    for (;;) navigator->navigationStep();                            // at a fixed rate
 *
 *  and destroys every navigator, factory and command before main() returns: MRPT unloads modules in
 * a static destructor. This header needs MRPT only. */
#pragma once

#include <mrpt/core/Clock.h>
#include <mrpt/kinematics/CVehicleVelCmd.h>
#include <mrpt/math/TPoint3D.h>
#include <mrpt/math/TPose3D.h>
#include <mrpt/math/TTwist3D.h>
#include <mrpt/nav/reactive/CAbstractNavigator.h>
#include <mrpt/nav/reactive/CRobot2NavInterface.h>
#include <mrpt/obs/obs_frwds.h>
#include <mrpt/rtti/CObject.h>

#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace slalom::core
{
struct CycleRecord;
}

namespace slalom::navigator
{
/** Velocity command of a multi-rotor: velocity in world axes (ENU, z up) and yaw rate. The default
 * is "stand still". Serializable by name as `slalom::navigator::VelocityCommand3D`. */
class VelocityCommand3D : public mrpt::kinematics::CVehicleVelCmd
{
  DEFINE_SERIALIZABLE(VelocityCommand3D, slalom::navigator)

 public:
  double vx = 0.0, vy = 0.0, vz = 0.0;  ///< [m/s] world axes
  double wz = 0.0;                      ///< [rad/s] counter-clockwise seen from above

  VelocityCommand3D() = default;
  VelocityCommand3D(double vx_, double vy_, double vz_, double wz_)
      : vx(vx_), vy(vy_), vz(vz_), wz(wz_)
  {
  }
  // The base's own copy calls virtual functions of the object under construction.
  VelocityCommand3D(const VelocityCommand3D& o) : VelocityCommand3D(o.vx, o.vy, o.vz, o.wz) {}
  VelocityCommand3D& operator=(const VelocityCommand3D& o)
  {
    vx = o.vx, vy = o.vy, vz = o.vz, wz = o.wz;
    return *this;
  }
  ~VelocityCommand3D() override = default;

  /// @name Elements 0..3 are vx, vy, vz, wz; other indices throw.
  /// @{
  size_t getVelCmdLength() const override { return 4; }
  std::string getVelCmdDescription(int index) const override;
  double getVelCmdElement(int index) const override;
  void setVelCmdElement(int index, double value) override;
  /// @}
  bool isStopCmd() const override;
  void setToStop() override;
  void cmdVel_scale(double scale) override;
  /** Blends `beta` of this command with `1 - beta` of `previous`, then scales velocity and yaw rate
   * together, so that the direction of the command is kept, until |v| <= robotMax_V_mps and
   * |wz| <= robotMax_W_radps. A limit that is not positive is not applied.
   * @return the factor of that scaling, in [0, 1]; 1: nothing was limited
   * @throws std::exception if `previous` is another class of command */
  double cmdVel_limits(const mrpt::kinematics::CVehicleVelCmd& previous, double beta,
                       const TVelCmdParams& params) override;
};

/// Pose and velocity of the vehicle at one instant.
struct State3D
{
  mrpt::math::TPose3D pose;    ///< body (forward-left-up) in the world (ENU) [m, rad]
  mrpt::math::TTwist3D twist;  ///< vx,vy,vz in world axes [m/s]; wx,wy,wz in body axes [rad/s]
  mrpt::Clock::time_point time = {};
  std::string frame = "map";  ///< name of the world frame
};

/** The vehicle as a navigator sees it; a host implements it. All calls come from the thread that
 * calls the navigator's verbs. */
class RobotInterface3D : public mrpt::nav::CRobot2NavInterface
{
 public:
  /// Latest pose and velocity. @return false: the vehicle cannot tell, the navigation fails.
  virtual bool getCurrentState3D(State3D& state) = 0;
  /// Flies the command until the next one. @return false: refused, the navigation fails.
  virtual bool changeSpeeds3D(const VelocityCommand3D& command) = 0;
  /// Stands still in the air; `emergency`: by the hardest means the vehicle has.
  virtual bool stop3D(bool emergency) = 0;

  /** Raw sensor observations since the last call, in order of arrival, appended to `observations`.
   * @return false (default): this host does not deliver raw observations. The navigator then lives
   * on getCurrentState3D() and senseObstacles(). Hosts that return true need not implement these
   * two seriously: position comes from the observations. */
  virtual bool pullObservations(
      std::vector<std::shared_ptr<mrpt::obs::CObservation>>& observations);
  /// The present, in the time base of the observations' stamps. Default: mrpt::Clock::now().
  virtual mrpt::Clock::time_point now();

  /** News that MRPT's four states cannot tell, sent at the end of a navigationStep():
   * WAITING_FOR_STATE, NAVIGATING (the vehicle moves again), GOAL_REACHED, GOAL_BLOCKED, FAILED; of
   * the tracker also SAFE_STOP (it brakes for a reason of safety), RECOVER (it flies on after
   * that), UNREACHABLE and SENSOR_LOST (it gives up, FAILED follows), or another name documented by
   * the plugin; `detail` is one readable line. Verbs of the navigator may be called from here, and
   * from every other event. */
  virtual void onEvent(const std::string& name, const std::string& detail);

  /// Obstacle points in the body frame, for hosts without raw observations. Default: no sensor.
  bool senseObstacles(mrpt::maps::CSimplePointsMap& obstacles,
                      mrpt::system::TTimeStamp& timestamp) override;

  /// @name MRPT's planar vocabulary, answered by the calls above.
  /// @{
  bool getCurrentPoseAndSpeeds(mrpt::math::TPose2D& pose, mrpt::math::TTwist2D& velocity,
                               mrpt::system::TTimeStamp& timestamp, mrpt::math::TPose2D& odometry,
                               std::string& frame_id) final;
  bool changeSpeeds(const mrpt::kinematics::CVehicleVelCmd& command) final;
  bool stop(bool emergency) final;
  mrpt::kinematics::CVehicleVelCmd::Ptr getEmergencyStopCmd() override;
  mrpt::kinematics::CVehicleVelCmd::Ptr getStopCmd() override;
  /// @}
};

/** A 3-D goal, with optional waypoints on the way. Goes through MRPT's own navigate(). The
 * inherited `target` is a planar shadow, filled by clone(); only its frame id is read: it must be
 * the frame of the vehicle's state. */
struct NavigationParams3D : mrpt::nav::CAbstractNavigator::TNavigationParams
{
  mrpt::math::TPose3D target3D;                 ///< world frame [m, rad]; finite
  std::vector<mrpt::math::TPoint3D> waypoints;  ///< world frame [m], to pass in this order before
  double allowed_distance_m = 0.5;              ///< [m] > 0: the goal is reached within this radius

  [[nodiscard]] std::string getAsText() const override;
  [[nodiscard]] std::unique_ptr<TNavigationParams> clone() const override;

 protected:
  bool isEqual(const mrpt::nav::CAbstractNavigator::TNavigationParamsBase& other) const override;
};

/** MRPT's navigator state machine (IDLE, NAVIGATING, SUSPENDED, NAV_ERROR) in three dimensions.
 *
 *  Differs from mrpt::nav::CAbstractNavigator where that one is planar or loses information:
 *  - goals, waypoints and the "not approaching" alarm are three-dimensional;
 *  - NAV_ERROR stays until resetNavError(), cancel() or a new navigate(), and stops the vehicle in
 *    the same step;
 *  - a verb called from inside a step (a callback of the robot) wins over the step;
 *  - every navigate() that does not merely change the goal in flight sends the start event;
 *  - navigationStep() may be called at any rate, and it senses in every state.
 *  Logs are silent below errors; setVerbosityLevel() opens them. Profilers are off and print
 * nothing.
 */
class AbstractNavigator3D : public mrpt::nav::CAbstractNavigator
{
 public:
  /// @param robot must outlive the navigator
  explicit AbstractNavigator3D(RobotInterface3D& robot);
  ~AbstractNavigator3D() override;

  /// @name MRPT's verbs
  /// @{
  void initialize() override;
  /** Starts towards a NavigationParams3D. @throws std::invalid_argument naming what is wrong with
   * `params` (class, relative target, value), std::logic_error before initialize(); the navigation
   * under way then goes on. */
  void navigate(const TNavigationParams* params) override;
  void navigationStep() override;
  void cancel() override;
  void suspend() override;
  void resume() override;
  void resetNavError() override;
  /// @}

  /// @name For hosts of the same build that watch closely; a plugin may have nothing to tell.
  /// @{
  using CycleListener = std::function<void(const slalom::core::CycleRecord&)>;
  using TruthListener = std::function<void(double t, const mrpt::math::TPose3D& pose)>;
  /** Called once per engine cycle, in every state of the navigator, at the end of navigationStep():
   * what a listener throws reaches the caller of navigationStep() and is no navigation error. */
  virtual void setCycleListener(CycleListener listener);
  /// Called for every ground-truth pose among the observations; t is log time [s].
  virtual void setTruthListener(TruthListener listener);
  /// INI text of every setting in force, with its origin.
  [[nodiscard]] virtual std::string effectiveConfig() const;
  /// JSON object: what was sensed and dropped so far.
  [[nodiscard]] virtual std::string runStatisticsJson() const;
  /// Writes the map as an octree (.bt). @return false: there is none, or the file cannot be written
  [[nodiscard]] virtual bool writeMap(const std::string& file);
  /// @}

 protected:
  enum class StateQuery
  {
    Known,
    NotYet,  ///< the estimator still waits for its sensors: hover, do not fail
    Failed
  };
  struct StepResult
  {
    enum class Status
    {
      Navigating,
      WaitingForState,
      GoalReached,
      GoalBlocked,  ///< cannot get closer for now; stays NAVIGATING, the host decides
      Failed        ///< becomes NAV_ERROR
    };
    Status status = Status::Navigating;
    VelocityCommand3D command;  ///< flown unless Failed; must be finite
    std::string detail;         ///< one line: why
  };

  /// @name What a navigator implements. t is the robot's getNavigationTime() [s].
  /// @{
  /// Command for one step in NAVIGATING. `state` is null while the state query says NotYet.
  virtual StepResult computeCommand(double t, const State3D* state,
                                    const NavigationParams3D& goal) = 0;
  /// Called first in every navigationStep(), in every state. An exception ends the navigation.
  virtual void sense(double t);
  /// Called instead of computeCommand() when the vehicle is not to be moved.
  virtual void idle(double t);
  /// Default: asks the robot.
  virtual StateQuery queryState(State3D& state);
  /// A valid new goal; may throw std::invalid_argument to refuse it.
  virtual void goalAccepted(const NavigationParams3D& goal);
  /// The goal is over: reached, cancelled or given up.
  virtual void goalEnded();
  /** Default: all waypoints passed, and the last stretch flown came within the allowed distance of
   * the target. Not asked while the state is unknown; computeCommand() may also report GoalReached.
   */
  [[nodiscard]] virtual bool reachedTarget(const State3D& state,
                                           const NavigationParams3D& goal) const;
  /// [m] for the "not approaching" alarm. Default: along the waypoints not yet passed.
  [[nodiscard]] virtual double remainingDistance(const State3D& state,
                                                 const NavigationParams3D& goal) const;
  /// @}

  /// Sends RobotInterface3D::onEvent() at the end of the step.
  void notify(const std::string& name, const std::string& detail);
  [[nodiscard]] RobotInterface3D& robot() { return robot_; }

  /// @name MRPT's hooks
  /// @{
  bool stop(bool emergency) override;
  void performNavigationStep() final;
  void performNavigationStepNavigating(bool call_virtual_nav_method) final;
  void onStartNewNavigation() final;
  void onNavigateCommandReceived() final;
  void updateCurrentPoseAndSpeeds() final;
  bool checkHasReachedTarget(double planar_distance) const final;
  /// @}

 private:
  [[nodiscard]] const NavigationParams3D& goal3D() const;
  void senseAndIdle();
  void failToSense(const std::string& why);
  void fly(const StepResult& result);
  void report(const StepResult& result);
  void oweErrorEvent();
  void restartAfterMissedIdle();
  void settle(bool threw);
  void adopt(const State3D& state);
  void rememberPlanar(const State3D& state);
  void countWaypoints();
  void guardProgress();
  void guardEarlyEndEvent();
  [[nodiscard]] double distanceFlownPast(const mrpt::math::TPoint3D& point) const;

  RobotInterface3D& robot_;
  bool initialized_ = false;
  double t_ = 0.0;

  std::optional<State3D> state_;
  mrpt::math::TPoint3D previous_position_;
  std::size_t next_waypoint_ = 0;
  bool engine_says_reached_ = false;
  StepResult::Status last_status_ = StepResult::Status::Navigating;

  double least_remaining_m_ = std::numeric_limits<double>::infinity();
  double least_remaining_t_ = 0.0;
  double early_end_distance_m_ = 0.0;

  TState base_last_state_ = IDLE;  ///< mirror of the base's private m_lastNavigationState
  bool start_event_due_ = false;
  bool in_step_ = false;            ///< inside the base's NAVIGATING step
  std::optional<TState> demanded_;  ///< by a verb called inside the step
  bool stopped_in_step_ = false;
};

/** Makes navigators of one class. Plugins register a concrete, default-constructible subclass:
 *
 *    class MyFactory : public slalom::navigator::NavigatorFactory
 *    { DEFINE_MRPT_OBJECT(MyFactory, my) public: std::unique_ptr<...> create(...) const override;
 * }; IMPLEMENTS_MRPT_OBJECT(MyFactory, slalom::navigator::NavigatorFactory, my)
 *    MRPT_INITIALIZER(register_my) { mrpt::rtti::registerClass(CLASS_ID(my::MyFactory)); }
 */
class NavigatorFactory : public mrpt::rtti::CObject
{
  DEFINE_VIRTUAL_MRPT_OBJECT(NavigatorFactory)

 public:
  [[nodiscard]] virtual std::unique_ptr<AbstractNavigator3D> create(
      RobotInterface3D& robot) const = 0;

  /** Loads a plugin module for the rest of the process.
   * @param module a path (with a '/'), or a bare name such as "slalom-tracker", looked for as
   *        NAME and NAME.so in the directories of pluginDirectories()
   * @throws std::runtime_error with the places tried, or the loader's complaint */
  static void loadModule(const std::string& module);
  /// $SLALOM_PLUGIN_PATH (colon-separated), then the directory of this library, then its slalom/.
  [[nodiscard]] static std::vector<std::string> pluginDirectories();
  /** @param class_name with or without its namespace
   * @throws std::runtime_error that lists the names there are */
  [[nodiscard]] static Ptr named(const std::string& class_name);
  /// Names of all factories registered so far, sorted.
  [[nodiscard]] static std::vector<std::string> availableNames();
};

}  // namespace slalom::navigator
