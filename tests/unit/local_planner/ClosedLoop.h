// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>

#include "AnalyticField.h"
#include "Laws.h"
#include "slalom/core/Math.h"
#include "slalom/local_planner/LocalPlanner.h"

namespace slalom::test
{
/// A vehicle whose velocity is the command.
[[nodiscard]] inline core::Vehicle atOnce(core::Vehicle vehicle = {})
{
  vehicle.velocity_lag_s = 0.0;
  return vehicle;
}

/** A vehicle that flies every command exactly, and the planner that steers it, at 20 Hz. The
 * reference runs with time, at most `lead` seconds ahead of the vehicle's projection. */
class ClosedLoop
{
 public:
  static constexpr double kPeriod = 0.05;

  ClosedLoop(std::shared_ptr<const spline::UniformBSpline> reference,
             std::shared_ptr<const AnalyticField> field,
             const local_planner::LocalPlannerConfig& config = {},
             const core::Vehicle& vehicle = {})
      : reference_(std::move(reference)),
        field_(std::move(field)),
        planner_(config, atOnce(vehicle)),
        progress_(reference_->start())
  {
    input.law = lawTo(*reference_, reference_->end());
    input.reference = reference_;
    input.field = field_;
    state.p_L = reference_->position(progress_);
  }

  /// One tick: plan, then fly the command for a period.
  local_planner::LocalPlannerOutput tick()
  {
    state.q_WB = core::fromYaw(yaw);
    state.v_W = command.v_W;
    input.state = state;
    input.last_command = command;
    input.progress = progress_;
    local_planner::LocalPlannerOutput output = planner_.step(input);
    command = output.command;
    state.p_L += kPeriod * command.v_W;
    state.t += kPeriod;
    yaw = core::wrapAngle(yaw + kPeriod * command.yaw_rate);
    turned += kPeriod * std::abs(command.yaw_rate);
    const double nearest = reference_->project(state.p_L, progress_ - 1.0, progress_ + 1.0);
    progress_ = std::min(input.law->advance(progress_, kPeriod), nearest + lead);
    return output;
  }

  void fly(double seconds,
           const std::function<void(const local_planner::LocalPlannerOutput&)>& watch = {})
  {
    for (const double end = state.t + seconds; state.t < end - 1e-9;)
    {
      const auto output = tick();
      if (watch) watch(output);
    }
  }

  [[nodiscard]] double clearance() const { return field_->signedDistance(state.p_L); }
  [[nodiscard]] double trackingError() const
  {
    return (state.p_L - reference_->position(progress_)).norm();
  }
  [[nodiscard]] double progress() const { return progress_; }
  void progressTo(double progress) { progress_ = progress; }
  [[nodiscard]] local_planner::LocalPlanner& planner() { return planner_; }

  core::VehicleState state;
  core::VelocityCommand command;
  local_planner::LocalPlannerInput input;  ///< field, reference, law may be changed
  double yaw = 0.0;
  double turned = 0.0;  ///< [rad] sum of all turning
  double lead = 1.0;    ///< [s]

 private:
  std::shared_ptr<const spline::UniformBSpline> reference_;
  std::shared_ptr<const AnalyticField> field_;
  local_planner::LocalPlanner planner_;
  double progress_;
};

/// Straight at constant speed: equally spaced control points.
inline std::shared_ptr<const spline::UniformBSpline> straightReference(
    const Eigen::Vector3d& from, const Eigen::Vector3d& velocity, double seconds)
{
  constexpr double kSpan = 0.2;
  Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(seconds / kSpan) + 4);
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) = from + (static_cast<double>(i) - 1.0) * kSpan * velocity;
  return std::make_shared<spline::UniformBSpline>(points, kSpan);
}

/// A field whose answers are not numbers.
class BrokenField : public AnalyticField
{
 public:
  BrokenField() : AnalyticField(std::vector<Obstacle>{}) {}
  std::optional<core::DistanceSample> sample(const Eigen::Vector3d&, core::UnknownAs) const override
  {
    return core::DistanceSample{std::numeric_limits<double>::quiet_NaN(), Eigen::Vector3d::UnitX()};
  }
};

inline std::shared_ptr<const AnalyticField> fieldOf(std::vector<Obstacle> obstacles)
{
  return std::make_shared<AnalyticField>(std::move(obstacles));
}

}  // namespace slalom::test
