// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/core/format.h>
#include <mrpt/core/lock_helper.h>
#include <mrpt/poses/CPose2D.h>
#include <mrpt/poses/CPose3D.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "slalom/navigator/Navigator.h"

namespace slalom::navigator
{
namespace
{
using mrpt::math::TPoint3D;

constexpr double kProgress_m = 0.05;       // less is noise, not an approach
constexpr double kPlanarHistory_s = 20.0;  // what MRPT keeps for its subclasses
constexpr float kWatchdog_ms = 1000.0F;    // as MRPT starts it

bool finite(const TPoint3D& p)
{
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}
bool finite(const mrpt::math::TPose3D& p)
{
  return finite(p.translation()) && std::isfinite(p.yaw) && std::isfinite(p.pitch) &&
         std::isfinite(p.roll);
}
bool finite(const State3D& s)
{
  const mrpt::math::TTwist3D& v = s.twist;
  return finite(s.pose) && finite(TPoint3D(v.vx, v.vy, v.vz)) && finite(TPoint3D(v.wx, v.wy, v.wz));
}
bool finite(const VelocityCommand3D& c)
{
  return finite(TPoint3D(c.vx, c.vy, c.vz)) && std::isfinite(c.wz);
}

const NavigationParams3D& checked(
    const mrpt::nav::CAbstractNavigator::TNavigationParams* const params)
{
  const auto refuse = [](const std::string& why)
  { throw std::invalid_argument("navigate(): " + why); };
  const auto* goal = dynamic_cast<const NavigationParams3D*>(params);
  if (!goal) refuse("needs a slalom::navigator::NavigationParams3D");
  if (goal->target.targetIsRelative)
    refuse("relative targets are not supported, give world coordinates");
  if (!finite(goal->target3D)) refuse("the target is not finite");
  if (!std::isfinite(goal->allowed_distance_m) || goal->allowed_distance_m <= 0.0)
    refuse(mrpt::format("allowed_distance_m = %g must be positive", goal->allowed_distance_m));
  for (std::size_t i = 0; i < goal->waypoints.size(); ++i)
    if (!finite(goal->waypoints[i])) refuse("waypoint " + std::to_string(i) + " is not finite");
  return *goal;
}

}  // namespace

AbstractNavigator3D::AbstractNavigator3D(RobotInterface3D& robot)
    : mrpt::nav::CAbstractNavigator(robot), robot_(robot)
{
  // MRPT logs "target reached" as a warning to stdout, and profilers print in their destructors.
  setMinLoggingLevel(mrpt::system::LVL_ERROR);
  m_timlog_delays.enable(false);
}

AbstractNavigator3D::~AbstractNavigator3D()
{
  m_timlog_delays.clear(true);
  m_navProfiler.clear(true);
}

void AbstractNavigator3D::initialize()
{
  initialized_ = true;
}

void AbstractNavigator3D::navigate(const TNavigationParams* params)
{
  const auto lock = mrpt::lockHelper(m_nav_cs);
  const NavigationParams3D& goal = checked(params);
  if (!initialized_) throw std::logic_error("navigate(): initialize() was not called");
  goalAccepted(goal);

  oweErrorEvent();
  if (m_navigationState != NAVIGATING) start_event_due_ = true;
  CAbstractNavigator::navigate(params);
  if (in_step_) demanded_ = NAVIGATING;
}

void AbstractNavigator3D::cancel()
{
  const auto lock = mrpt::lockHelper(m_nav_cs);
  resetNavError();
  const bool flying = m_navigationState != IDLE;
  CAbstractNavigator::cancel();
  if (in_step_) demanded_ = IDLE;
  if (flying) goalEnded();
}

void AbstractNavigator3D::suspend()
{
  const auto lock = mrpt::lockHelper(m_nav_cs);
  CAbstractNavigator::suspend();
  if (in_step_) demanded_ = m_navigationState;
}

void AbstractNavigator3D::resume()
{
  const auto lock = mrpt::lockHelper(m_nav_cs);
  CAbstractNavigator::resume();
  if (in_step_) demanded_ = m_navigationState;
}

void AbstractNavigator3D::resetNavError()
{
  const auto lock = mrpt::lockHelper(m_nav_cs);
  oweErrorEvent();
  CAbstractNavigator::resetNavError();
}

void AbstractNavigator3D::navigationStep()
{
  const auto lock = mrpt::lockHelper(m_nav_cs);
  t_ = robot_.getNavigationTime();
  senseAndIdle();
  if (m_navigationState != NAVIGATING) base_last_state_ = m_navigationState;
  CAbstractNavigator::navigationStep();
}

void AbstractNavigator3D::senseAndIdle()
{
  try
  {
    sense(t_);
    if (m_navigationState != NAVIGATING) idle(t_);
  }
  catch (const std::exception& e)
  {
    failToSense(e.what());
  }
  catch (...)
  {
    failToSense("something unknown was thrown");
  }
}

void AbstractNavigator3D::failToSense(const std::string& why)
{
  if (m_navigationState == NAVIGATING)
  {
    doEmergencyStop(why);
    goalEnded();
    // The base reports errors that follow a step in NAVIGATING only.
    if (base_last_state_ != NAVIGATING)
      m_pending_events.emplace_back([this] { robot_.sendNavigationEndDueToErrorEvent(); });
  }
  notify("FAILED", why);
}

// The base reports NAV_ERROR in the step after it; a verb that comes between must not swallow that.
void AbstractNavigator3D::oweErrorEvent()
{
  if (m_navigationState == NAV_ERROR && base_last_state_ == NAVIGATING)
    m_pending_events.emplace_back([this] { robot_.sendNavigationEndDueToErrorEvent(); });
}

// The base recognises a new navigation by a step in IDLE before it. Do its work where none was.
void AbstractNavigator3D::restartAfterMissedIdle()
{
  if (!start_event_due_) return;
  start_event_due_ = false;
  if (base_last_state_ == NAVIGATING)
  {
    robot_.startWatchdog(kWatchdog_ms);
    m_latestPoses.clear();
    m_latestOdomPoses.clear();
    onStartNewNavigation();
  }
  if (base_last_state_ != IDLE)
    m_pending_events.emplace_back([this] { robot_.sendNavigationStartEvent(); });
}

void AbstractNavigator3D::performNavigationStepNavigating(bool call_virtual_nav_method)
{
  restartAfterMissedIdle();
  demanded_.reset();
  stopped_in_step_ = false;
  early_end_distance_m_ = params_abstract_navigator.dist_to_target_for_sending_event;
  in_step_ = true;
  try
  {
    CAbstractNavigator::performNavigationStepNavigating(call_virtual_nav_method);
  }
  catch (...)  // only if the host asked for enableRethrowNavExceptions()
  {
    settle(true);
    throw;
  }
  settle(false);
}

// The base ends its step by restoring the state the step began with, whatever happened in it.
void AbstractNavigator3D::settle(bool threw)
{
  in_step_ = false;
  params_abstract_navigator.dist_to_target_for_sending_event = early_end_distance_m_;
  if (demanded_)
    m_navigationState = *demanded_;
  else if (getErrorReason().error_code != ERR_NONE)
    m_navigationState = NAV_ERROR;

  if (m_navigationState == NAV_ERROR)
  {
    if (!stopped_in_step_) stop(true);
    goalEnded();
    if (threw && base_last_state_ != NAVIGATING)
      m_pending_events.emplace_back([this] { robot_.sendNavigationEndDueToErrorEvent(); });
    notify("FAILED", getErrorReason().error_msg);
  }
  else if (m_navigationState == IDLE && !demanded_)
  {
    goalEnded();
    notify("GOAL_REACHED", "");
  }
  if (!threw) base_last_state_ = NAVIGATING;
}

void AbstractNavigator3D::performNavigationStep()
{
  if (demanded_) return;
  const NavigationParams3D& goal = goal3D();
  if (state_ && state_->frame != goal.target.target_frame_id)
    return doEmergencyStop("the target is in frame '" + goal.target.target_frame_id +
                           "', the vehicle's state in '" + state_->frame + "'");
  fly(computeCommand(t_, state_ ? &*state_ : nullptr, goal));
}

void AbstractNavigator3D::fly(const StepResult& result)
{
  report(result);
  if (result.status == StepResult::Status::Failed)
    return doEmergencyStop(result.detail.empty() ? "no command" : result.detail);
  if (!finite(result.command)) return doEmergencyStop("the velocity command is not finite");
  if (!changeSpeeds(result.command) && !demanded_)
    doEmergencyStop("the robot refused the velocity command");
}

void AbstractNavigator3D::report(const StepResult& result)
{
  using Status = StepResult::Status;
  engine_says_reached_ = result.status == Status::GoalReached;
  if (result.status == last_status_) return;
  last_status_ = result.status;
  if (result.status == Status::Navigating) notify("NAVIGATING", result.detail);
  if (result.status == Status::WaitingForState) notify("WAITING_FOR_STATE", result.detail);
  if (result.status == Status::GoalBlocked)
  {
    m_pending_events.emplace_back([this] { robot_.sendCannotGetCloserToBlockedTargetEvent(); });
    notify("GOAL_BLOCKED", result.detail);
  }
}

void AbstractNavigator3D::notify(const std::string& name, const std::string& detail)
{
  m_pending_events.emplace_back([this, name, detail] { robot_.onEvent(name, detail); });
}

bool AbstractNavigator3D::stop(bool emergency)
{
  stopped_in_step_ = true;
  return CAbstractNavigator::stop(emergency);
}

void AbstractNavigator3D::onStartNewNavigation()
{
  least_remaining_m_ = std::numeric_limits<double>::infinity();
}

void AbstractNavigator3D::onNavigateCommandReceived()
{
  CAbstractNavigator::onNavigateCommandReceived();
  state_.reset();
  next_waypoint_ = 0;
  engine_says_reached_ = false;
  last_status_ = StepResult::Status::Navigating;
  least_remaining_m_ = std::numeric_limits<double>::infinity();
}

void AbstractNavigator3D::updateCurrentPoseAndSpeeds()
{
  State3D now;
  StateQuery answer = queryState(now);
  if (answer == StateQuery::Known && !finite(now)) answer = StateQuery::Failed;
  if (answer == StateQuery::Failed)
  {
    doEmergencyStop("the robot cannot tell its state, or it is not finite");
    throw std::runtime_error("the robot cannot tell its state, or it is not finite");
  }
  if (answer == StateQuery::NotYet)
  {
    state_.reset();
    now.time = robot_.now();
  }
  else
    adopt(now);
  rememberPlanar(now);
  if (!in_step_ || !m_navigationParams) return;
  countWaypoints();
  guardProgress();
  guardEarlyEndEvent();
}

void AbstractNavigator3D::adopt(const State3D& state)
{
  previous_position_ = (state_ ? state_->pose : state.pose).translation();
  state_ = state;
}

// What the base's planar code and MRPT's subclasses look at.
void AbstractNavigator3D::rememberPlanar(const State3D& state)
{
  m_curPoseVel.pose = m_curPoseVel.rawOdometry = mrpt::math::TPose2D(state.pose);
  m_curPoseVel.velGlobal = {state.twist.vx, state.twist.vy, state.twist.wz};
  m_curPoseVel.velLocal = m_curPoseVel.velGlobal;
  m_curPoseVel.velLocal.rotate(-m_curPoseVel.pose.phi);
  m_curPoseVel.timestamp = state.time;
  m_curPoseVel.pose_frame_id = state.frame;
  m_last_curPoseVelUpdate_robot_time = t_;

  const bool other_frame = m_last_curPoseVelUpdate_pose_frame_id != state.frame;
  m_last_curPoseVelUpdate_pose_frame_id = state.frame;
  for (auto* path : {&m_latestPoses, &m_latestOdomPoses})
  {
    if (other_frame) path->clear();
    path->insert(state.time, mrpt::poses::CPose2D(m_curPoseVel.pose));
    while (path->size() > 1 && mrpt::system::timeDifference(
                                   path->begin()->first, path->rbegin()->first) > kPlanarHistory_s)
      path->erase(path->begin());
  }
}

void AbstractNavigator3D::countWaypoints()
{
  if (!state_) return;
  const NavigationParams3D& goal = goal3D();
  for (; next_waypoint_ < goal.waypoints.size() &&
         distanceFlownPast(goal.waypoints[next_waypoint_]) < goal.allowed_distance_m;
       ++next_waypoint_)
    m_pending_events.emplace_back([this, index = static_cast<int>(next_waypoint_)]
                                  { robot_.sendWaypointReachedEvent(index, true); });
}

// The base's alarm measures in the plane, where a climb is no approach. It is kept quiet until the
// same alarm in three dimensions goes off, and then made to speak: only the base can set
// ERR_CANNOT_REACH_TARGET.
void AbstractNavigator3D::guardProgress()
{
  m_badNavAlarm_minDistTarget = std::numeric_limits<double>::max();
  m_badNavAlarm_lastMinDistTime = mrpt::Clock::now();
  if (!state_)
  {
    least_remaining_t_ = t_;
    return;
  }
  const double timeout = params_abstract_navigator.alarm_seems_not_approaching_target_timeout;
  const double remaining = remainingDistance(*state_, goal3D());
  if (remaining < least_remaining_m_ - kProgress_m)
  {
    least_remaining_m_ = remaining;
    least_remaining_t_ = t_;
  }
  else if (timeout > 0.0 && t_ - least_remaining_t_ > timeout)
  {
    const auto past = std::chrono::duration<double>(timeout + 1.0);
    m_badNavAlarm_minDistTarget = -1.0;
    m_badNavAlarm_lastMinDistTime -= std::chrono::duration_cast<mrpt::Clock::duration>(past);
  }
}

// Likewise for the end event that a host may ask to get some distance before the target.
void AbstractNavigator3D::guardEarlyEndEvent()
{
  const bool near = state_ && next_waypoint_ == goal3D().waypoints.size() &&
                    distanceFlownPast(goal3D().target3D.translation()) < early_end_distance_m_;
  params_abstract_navigator.dist_to_target_for_sending_event =
      near ? std::numeric_limits<double>::max() : 0.0;
}

bool AbstractNavigator3D::checkHasReachedTarget(double) const
{
  return engine_says_reached_ || (state_ && reachedTarget(*state_, goal3D()));
}

const NavigationParams3D& AbstractNavigator3D::goal3D() const
{
  return static_cast<const NavigationParams3D&>(*m_navigationParams);
}

double AbstractNavigator3D::distanceFlownPast(const TPoint3D& point) const
{
  const TPoint3D flown = state_->pose.translation() - previous_position_;
  const TPoint3D there = point - previous_position_;
  const double length2 = flown.x * flown.x + flown.y * flown.y + flown.z * flown.z;
  const double along = flown.x * there.x + flown.y * there.y + flown.z * there.z;
  const double fraction = length2 > 0.0 ? std::clamp(along / length2, 0.0, 1.0) : 0.0;
  return (there - flown * fraction).norm();
}

void AbstractNavigator3D::sense(double) {}
void AbstractNavigator3D::idle(double) {}
void AbstractNavigator3D::goalAccepted(const NavigationParams3D&) {}
void AbstractNavigator3D::goalEnded() {}

AbstractNavigator3D::StateQuery AbstractNavigator3D::queryState(State3D& state)
{
  return robot_.getCurrentState3D(state) ? StateQuery::Known : StateQuery::Failed;
}

bool AbstractNavigator3D::reachedTarget(const State3D&, const NavigationParams3D& goal) const
{
  return next_waypoint_ == goal.waypoints.size() &&
         distanceFlownPast(goal.target3D.translation()) < goal.allowed_distance_m;
}

double AbstractNavigator3D::remainingDistance(const State3D& state,
                                              const NavigationParams3D& goal) const
{
  TPoint3D from = state.pose.translation();
  double length = 0.0;
  const auto go = [&from, &length](const TPoint3D& to)
  {
    length += (to - from).norm();
    from = to;
  };
  for (std::size_t i = next_waypoint_; i < goal.waypoints.size(); ++i) go(goal.waypoints[i]);
  go(goal.target3D.translation());
  return length;
}

void AbstractNavigator3D::setCycleListener(CycleListener) {}
void AbstractNavigator3D::setTruthListener(TruthListener) {}
std::string AbstractNavigator3D::effectiveConfig() const
{
  return {};
}
std::string AbstractNavigator3D::runStatisticsJson() const
{
  return "{}";
}
bool AbstractNavigator3D::writeMap(const std::string&)
{
  return false;
}

}  // namespace slalom::navigator
