// SPDX-License-Identifier: BSD-3-Clause
#include "HostSenses.h"

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace slalom::navigator
{
namespace
{
constexpr double kSameTimeBase_s = 1.0;  // stamps this near to the host's clock were made by it
constexpr char kHost[] = "host";

Eigen::Isometry3d isometry(const mrpt::math::TPose3D& pose)
{
  return Eigen::Translation3d(pose.x, pose.y, pose.z) *
         Eigen::AngleAxisd(pose.yaw, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(pose.pitch, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(pose.roll, Eigen::Vector3d::UnitX());
}

}  // namespace

HostSenses::HostSenses(RobotInterface3D& robot, const mrpt_io::InputConfig& config,
                       bool fly_by_truth)
    : robot_(robot), decoder_(config), fly_by_truth_(fly_by_truth)
{
  delivers_ = robot_.pullObservations(waiting_);
}

void HostSenses::pull(double navigation_time, const Sink& sink)
{
  if (delivers_) return pullObservations(sink);
  now_ = navigation_time;
  askForState(navigation_time, sink);
  askForObstacles(navigation_time, sink);
}

void HostSenses::pullObservations(const Sink& sink)
{
  robot_.pullObservations(waiting_);
  heard_ = false;
  for (const auto& observation : std::exchange(waiting_, {}))
    if (observation) take(*observation, sink);
  advanceClock();
}

void HostSenses::take(const mrpt::obs::CObservation& observation, const Sink& sink)
{
  std::vector<core::Measurement> measurements;
  try
  {
    if (const auto pose = decoder_.truth(observation))
    {
      truth_.push_back(*pose);
      if (fly_by_truth_)
        measurements.emplace_back(
            core::PoseFix{pose->t, Eigen::Translation3d(pose->position) * pose->orientation, 1e-3,
                          1e-3, observation.sensorLabel});
    }
    else
      measurements = decoder_.decode(observation);
  }
  catch (const std::exception&)  // one bad observation must not end a flight
  {
    ++undecodable_;
  }
  for (const core::Measurement& measurement : measurements)
  {
    newest_ = std::max(newest_.value_or(core::timeOf(measurement)), core::timeOf(measurement));
    heard_ = true;
    if (const auto* scan = std::get_if<core::RangeScan>(&measurement))
      points_per_scan_.push_back(static_cast<std::uint32_t>(scan->points.size()));
    sink(measurement);
  }
}

// The host's clock goes on while sensors are silent, whatever its offset from the stamps is.
void HostSenses::advanceClock()
{
  if (!newest_) return;
  const double host = decoder_.logTime(robot_.now());
  if (heard_)
  {
    clock_agrees_ = std::abs(host - *newest_) < kSameTimeBase_s;
    host_when_heard_ = host;
  }
  const double now =
      clock_agrees_ ? std::max(host, *newest_) : *newest_ + std::max(0.0, host - host_when_heard_);
  now_ = std::max(now_.value_or(now), now);
}

mrpt::Clock::time_point HostSenses::stamp(double log_time) const
{
  return delivers_     ? mrpt::Clock::fromDouble(decoder_.epoch() + log_time)
         : host_state_ ? host_state_->time
                       : mrpt::Clock::time_point{};
}

/// Age of a stamp by the host's own clock [s]; 0 for a stamp that is not set or not believable.
double HostSenses::ageOf(const mrpt::Clock::time_point& stamp) const
{
  constexpr double kBelievable_s = 10.0;
  if (stamp == mrpt::Clock::time_point{} || stamp == INVALID_TIMESTAMP) return 0.0;
  const double age = mrpt::Clock::toDouble(robot_.now()) - mrpt::Clock::toDouble(stamp);
  return age > 0.0 && age < kBelievable_s ? age : 0.0;
}

void HostSenses::askForState(double t, const Sink& sink)
{
  State3D state;
  host_state_.reset();
  if (!robot_.getCurrentState3D(state)) return;
  host_state_ = state;
  if (state.time != mrpt::Clock::time_point{} &&
      state.time == std::exchange(last_state_, state.time))
    return;  // nothing new: the state grows old, and the engine brakes when it is too old
  core::PoseFix fix;
  fix.t = t - ageOf(state.time);
  fix.T_WB = isometry(state.pose);
  fix.source = kHost;
  if (fix.T_WB.matrix().allFinite()) sink(fix);
}

void HostSenses::askForObstacles(double t, const Sink& sink)
{
  mrpt::maps::CSimplePointsMap obstacles;
  mrpt::system::TTimeStamp stamp = INVALID_TIMESTAMP;
  if (!robot_.senseObstacles(obstacles, stamp)) return;
  if (stamp != INVALID_TIMESTAMP && stamp == std::exchange(last_obstacles_, stamp)) return;
  core::RangeScan scan;
  scan.t = t - ageOf(stamp);
  scan.label = kHost;
  for (std::size_t i = 0; i < obstacles.size(); ++i)
  {
    core::ScanPoint point;
    obstacles.getPointFast(i, point.p_S.x(), point.p_S.y(), point.p_S.z());
    if (point.p_S.allFinite() && !point.p_S.isZero(0.0F)) scan.points.push_back(point);
  }
  points_per_scan_.push_back(static_cast<std::uint32_t>(scan.points.size()));
  sink(scan);
}

std::vector<core::TimedPose> HostSenses::takeTruth()
{
  return std::exchange(truth_, {});
}

std::map<std::string, std::uint64_t> HostSenses::dropped() const
{
  auto dropped = decoder_.dropped();
  if (undecodable_ > 0) dropped["observation: undecodable"] += undecodable_;
  return dropped;
}

}  // namespace slalom::navigator
