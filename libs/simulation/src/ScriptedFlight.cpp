// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/simulation/ScriptedFlight.h"

#include <algorithm>
#include <cmath>

#include "FlightPath.h"
#include "slalom/core/Math.h"

namespace slalom::simulation
{
ScriptedFlight::ScriptedFlight(std::unique_ptr<const Path> path) : path_(std::move(path)) {}
ScriptedFlight::~ScriptedFlight() = default;
ScriptedFlight::ScriptedFlight(ScriptedFlight&&) noexcept = default;
ScriptedFlight& ScriptedFlight::operator=(ScriptedFlight&&) noexcept = default;

double ScriptedFlight::duration() const
{
  return path_->duration();
}

Eigen::Isometry3d ScriptedFlight::pose(double t) const
{
  const Path::Sample sample = path_->at(t);
  Eigen::Isometry3d pose(hoverAttitude(sample.a, sample.yaw));
  pose.translation() = sample.p;
  return pose;
}

MotionSample ScriptedFlight::at(double t) const
{
  const Path::Sample sample = path_->at(t);
  MotionSample motion;
  motion.p_W = sample.p;
  motion.v_W = sample.v;
  motion.a_W = sample.a;
  motion.q_WB = hoverAttitude(sample.a, sample.yaw);
  // Central difference of the attitude: its error, about 1e-7 rad/s, is far below any gyroscope's.
  constexpr double kStep = 5e-4;
  const Path::Sample before = path_->at(t - kStep), after = path_->at(t + kStep);
  const Eigen::AngleAxisd turn(hoverAttitude(before.a, before.yaw).conjugate() *
                               hoverAttitude(after.a, after.yaw));
  motion.w_B = turn.axis() * core::wrapAngle(turn.angle()) / (2.0 * kStep);
  return motion;
}

}  // namespace slalom::simulation
