// SPDX-License-Identifier: BSD-3-Clause
#include "TrackerNavigator.h"

#include <mrpt/core/format.h>
#include <mrpt/core/initializer.h>
#include <mrpt/core/lock_helper.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

IMPLEMENTS_MRPT_OBJECT(TrackerNavigatorFactory, NavigatorFactory, slalom::navigator)

MRPT_INITIALIZER(registerAllClasses_slalom_tracker)
{
  mrpt::rtti::registerClass(CLASS_ID(slalom::navigator::TrackerNavigatorFactory));
}

namespace slalom::navigator
{
namespace
{
using engine::EngineStatus;
using engine::StateSourceKind;

mrpt::math::TPose3D poseOf(const Eigen::Vector3d& p, const Eigen::Quaterniond& q)
{
  const Eigen::Matrix3d r = q.toRotationMatrix();
  const double yaw = std::atan2(r(1, 0), r(0, 0));
  const double pitch = std::atan2(-r(2, 0), std::hypot(r(0, 0), r(1, 0)));
  const double roll = std::atan2(r(2, 1), r(2, 2));
  return {p.x(), p.y(), p.z(), yaw, pitch, roll};
}

Eigen::Vector3d vectorOf(const mrpt::math::TPoint3D& p)
{
  return {p.x, p.y, p.z};
}

engine::Mission missionOf(const NavigationParams3D& goal)
{
  engine::Mission mission;
  mission.waypoints_W.resize(3, static_cast<Eigen::Index>(goal.waypoints.size()) + 1);
  Eigen::Index column = 0;
  for (const auto& waypoint : goal.waypoints)
    mission.waypoints_W.col(column++) = vectorOf(waypoint);
  mission.waypoints_W.col(column) = vectorOf(goal.target3D.translation());
  return mission;
}

// A host without observations is itself the source of the pose.
void settleStateSource(StateSourceKind& source)
{
  if (source == StateSourceKind::Fusion)
    throw mrpt_io::ConfigError(
        "[state] source = fusion: needs a host that delivers raw observations "
        "(RobotInterface3D::pullObservations)");
  if (source != StateSourceKind::Static) source = StateSourceKind::PoseObservation;
}

}  // namespace

std::unique_ptr<AbstractNavigator3D> TrackerNavigatorFactory::create(RobotInterface3D& robot) const
{
  return std::make_unique<TrackerNavigator>(robot);
}

TrackerNavigator::TrackerNavigator(RobotInterface3D& robot) : AbstractNavigator3D(robot)
{
  params_abstract_navigator.alarm_seems_not_approaching_target_timeout =
      config_.mrpt.alarm_seems_not_approaching_target_timeout;
}

TrackerNavigator::~TrackerNavigator() = default;

void TrackerNavigator::loadConfigFile(const mrpt::config::CConfigFileBase& source)
{
  const auto lock = mrpt::lockHelper(m_nav_cs);
  if (engine_) throw std::logic_error("loadConfigFile(): must come before initialize()");
  config_ = readTrackerConfig(mrpt_io::IniDocument::from(source, "host"));
  AbstractNavigator3D::loadConfigFile(source);
}

void TrackerNavigator::saveConfigFile(mrpt::config::CConfigFileBase& target) const
{
  mrpt_io::IniDocument::parse(config_.effective, "effective").copyTo(target);
  AbstractNavigator3D::saveConfigFile(target);
}

void TrackerNavigator::initialize()
{
  const auto lock = mrpt::lockHelper(m_nav_cs);
  engine_.reset();
  if (config_.effective.empty()) config_ = readTrackerConfig({});
  engine::EngineConfig engine_config = config_.engine;
  senses_ = std::make_unique<HostSenses>(robot(), config_.input,
                                         engine_config.state.source == StateSourceKind::Truth);
  if (!senses_->delivers()) settleStateSource(engine_config.state.source);
  engine_ = std::make_unique<engine::Engine>(engine_config);
  AbstractNavigator3D::initialize();
}

void TrackerNavigator::navigationStep()
{
  const auto lock = mrpt::lockHelper(m_nav_cs);
  if (!engine_) throw std::logic_error("navigationStep(): initialize() was not called");
  AbstractNavigator3D::navigationStep();
  tellListeners();
}

void TrackerNavigator::tellListeners()
{
  for (const core::TimedPose& pose : senses_->takeTruth())
    if (on_truth_) on_truth_(pose.t, poseOf(pose.position, pose.orientation));
  if (record_ && on_cycle_) on_cycle_(*record_);
  record_.reset();
}

void TrackerNavigator::sense(double t)
{
  senses_->pull(t, [this](const core::Measurement& measurement) { engine_->add(measurement); });
}

const core::CycleRecord* TrackerNavigator::cycle(bool drive)
{
  if (!senses_->now()) return nullptr;
  record_ = engine_->step(*senses_->now(), drive);
  distance_to_goal_m_ = record_->distance_to_goal_m;
  tellHost(record_->events);
  return &*record_;
}

// The other changes of status travel as the result of the step.
void TrackerNavigator::tellHost(const std::vector<core::Event>& events)
{
  for (const core::Event& event : events)
    if (event.name == "SAFE_STOP" || event.name == "RECOVER" || event.name == "UNREACHABLE" ||
        event.name == "SENSOR_LOST")
      notify(event.name, event.detail);
}

void TrackerNavigator::idle(double)
{
  cycle(false);
}

AbstractNavigator3D::StepResult TrackerNavigator::computeCommand(double, const State3D*,
                                                                 const NavigationParams3D&)
{
  using Status = StepResult::Status;
  StepResult result;
  result.status = Status::WaitingForState;
  result.detail = "no observation yet";
  const core::CycleRecord* record = cycle(true);
  if (!record) return result;

  const core::VelocityCommand& command = record->command;
  result.command = {command.v_W.x(), command.v_W.y(), command.v_W.z(), command.yaw_rate};
  result.detail = record->reason;
  switch (engine_->status())
  {
    case EngineStatus::WaitingForState:
      break;
    case EngineStatus::NoMission:  // it was given one: refused
      result.status = Status::Failed;
      break;
    case EngineStatus::Navigating:
      result.status = Status::Navigating;
      break;
    case EngineStatus::GoalReached:
      result.status = Status::GoalReached;
      break;
    case EngineStatus::GoalBlocked:
      result.status = Status::GoalBlocked;
      break;
    case EngineStatus::Unreachable:
      result.status = Status::Failed;
      result.detail = "UNREACHABLE: " + result.detail;
      break;
    case EngineStatus::SensorLost:  // a recording may go on, and nobody flies it
      result.status = config_.engine.rates.open_loop ? Status::Navigating : Status::Failed;
      result.detail = "SENSOR_LOST: " + result.detail;
      break;
  }
  return result;
}

AbstractNavigator3D::StateQuery TrackerNavigator::queryState(State3D& out)
{
  if (!senses_->delivers() && !senses_->hostState()) return StateQuery::Failed;
  const auto state = engine_->state();
  if (!state) return StateQuery::NotYet;
  const Eigen::Vector3d &v = state->v_W, &w = state->w_B;
  out.pose = poseOf(state->p_W, state->q_WB);
  out.twist = {v.x(), v.y(), v.z(), w.x(), w.y(), w.z()};
  out.time = senses_->stamp(state->t);
  if (senses_->hostState()) out.frame = senses_->hostState()->frame;
  return StateQuery::Known;
}

void TrackerNavigator::goalAccepted(const NavigationParams3D& goal)
{
  if (!engine_) throw std::logic_error("navigate(): initialize() was not called");
  const double tolerance = config_.engine.mission.goal_tolerance_m;
  if (goal.allowed_distance_m < tolerance)
    throw std::invalid_argument(
        mrpt::format("navigate(): allowed_distance_m = %g is below [mission] goal_tolerance_m = %g",
                     goal.allowed_distance_m, tolerance));
  engine_->setMission(missionOf(goal));
}

// A goal that was reached stays the engine's, so that its last cycles can be seen.
void TrackerNavigator::goalEnded()
{
  if (engine_->status() != EngineStatus::GoalReached) engine_->clearMission();
}

bool TrackerNavigator::reachedTarget(const State3D&, const NavigationParams3D&) const
{
  return false;  // the engine says so in computeCommand()
}

double TrackerNavigator::remainingDistance(const State3D&, const NavigationParams3D&) const
{
  return distance_to_goal_m_;
}

std::string TrackerNavigator::runStatisticsJson() const
{
  if (!engine_) return "{}";
  const engine::EngineStatistics& engine = engine_->statistics();
  auto dropped = senses_->dropped();
  for (const auto& [reason, count] : engine.dropped) dropped[reason] += count;
  std::vector<std::uint32_t> points = senses_->pointsPerScan();
  std::sort(points.begin(), points.end());

  nlohmann::json json;
  json["epoch_s"] = senses_->decoder().epoch();
  if (const auto datum = senses_->decoder().datum())
    json["datum"] = {{"lat_deg", datum->x()}, {"lon_deg", datum->y()}, {"alt_m", datum->z()}};
  json["state_source"] = engine.state_source;
  json["dropped"] = dropped;
  json["points_per_scan"] = {{"n", points.size()}, {"median", nullptr}, {"max", nullptr}};
  if (!points.empty())
  {
    json["points_per_scan"]["median"] = points[points.size() / 2];
    json["points_per_scan"]["max"] = points.back();
  }
  json["cycles"] = engine.cycles;
  json["scans"] = engine.scans;
  json["map_updates"] = engine.map_updates;
  json["replans"] = engine.replans;
  json["safe_stops"] = engine.safe_stops;
  json["safe_recoveries"] = engine.safe_recoveries;
  json["reference_length_m"] = engine_->referenceLength();
  return json.dump();
}

bool TrackerNavigator::writeMap(const std::string& file)
{
  return engine_ && engine_->writeOctree(file);
}

}  // namespace slalom::navigator
