// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/local_planner/LocalPlanner.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <optional>
#include <stdexcept>

#include "HorizonReference.h"
#include "KeepOuts.h"
#include "Nmpc.h"
#include "Plan.h"
#include "slalom/core/CommandLimits.h"

namespace slalom::local_planner
{
namespace
{
using core::Termination;
using detail::HorizonReference;
using detail::KeepOuts;
using detail::Model;
using detail::Plan;

constexpr int kMaxShifts = 5;       // ticks that an old plan may be flown on
constexpr int kColdAfter = 3;       // failures in a row after which nothing is kept of the old plan
constexpr int kTrustAfter = 3;      // good solutions in a row that end braking
constexpr double kFeasible = 1e-3;  // [SI] residual of a plan that may be flown
constexpr double kStationary = 1e-2;  // [1] and of its gradient

/// Throws on the first field outside its range.
struct RangeCheck
{
  template <class Number>
  void operator()(const char* name, const Number& value, const core::Range& range, const char*,
                  core::Level = core::Level::Public) const
  {
    const auto number = static_cast<double>(value);
    if (number >= range.min && number <= range.max) return;
    throw std::invalid_argument(std::string(name) + " = " + std::to_string(number) +
                                " is outside [" + std::to_string(range.min) + ", " +
                                std::to_string(range.max) + "]");
  }
  template <class Choice, class Names>
  void operator()(const char*, const Choice&, const Names&, const char*,
                  core::Level = core::Level::Public) const
  {
  }
};

/// Why this input cannot be planned on; empty if it can.
std::string trouble(const LocalPlannerInput& input)
{
  if (!input.reference || !input.law) return "no reference";
  const core::VehicleState& s = input.state;
  if (!std::isfinite(s.t) || !s.p_L.allFinite() || !s.v_W.allFinite() || !s.w_B.allFinite() ||
      !s.q_WB.coeffs().allFinite() || !std::isfinite(s.yaw()))
    return "the state is not finite";
  if (!std::isfinite(input.progress)) return "the progress on the reference is not finite";
  if (!input.disturbance_W.allFinite()) return "the disturbance is not finite";
  if (!input.last_command.v_W.allFinite() || !std::isfinite(input.last_command.yaw_rate))
    return "the last command is not finite";
  return {};
}

Eigen::Vector4d stack(const core::VelocityCommand& command)
{
  return {command.v_W.x(), command.v_W.y(), command.v_W.z(), command.yaw_rate};
}

/// Towards rest as fast as the acceleration limit permits.
core::VelocityCommand brake(const core::VelocityCommand& last, double dt,
                            const core::Vehicle& vehicle)
{
  return {core::braked(last.v_W, vehicle.max_acceleration_mps2 * dt), 0.0};
}

/// What a planner may hand out: finite, inside the limits, not farther from `last` than the
/// acceleration limit permits.
core::VelocityCommand lawful(const core::VelocityCommand& wanted, const core::VelocityCommand& last,
                             double dt, const core::Vehicle& vehicle)
{
  if (!wanted.v_W.allFinite() || !std::isfinite(wanted.yaw_rate)) return brake(last, dt, vehicle);
  return {core::limited(wanted.v_W, last.v_W, vehicle.max_acceleration_mps2 * dt, vehicle),
          std::clamp(wanted.yaw_rate, -vehicle.max_yaw_rate_radps, vehicle.max_yaw_rate_radps)};
}

std::string withNumber(const char* format, double number)
{
  char text[96];
  std::snprintf(text, sizeof text, format, number);
  return text;
}
}  // namespace

std::string_view toString(Fallback fallback)
{
  switch (fallback)
  {
    case Fallback::None:
      return "None";
    case Fallback::Shifted:
      return "Shifted";
    case Fallback::Committed:
      return "Committed";
    case Fallback::Brake:
      return "Brake";
  }
  return "?";
}

struct LocalPlanner::Impl
{
  Impl(const LocalPlannerConfig& given, const core::Vehicle& limits);

  LocalPlannerOutput step(const LocalPlannerInput& input);

  /// What a step works on.
  struct Tick
  {
    const LocalPlannerInput& input;
    core::VelocityCommand last;
    double dt;  ///< [s] since the last step
    Model model;
    core::Motion motion;  ///< the vehicle's
    LocalPlannerOutput output;
  };

  double sinceLastCommand(const LocalPlannerInput& input);
  [[nodiscard]] Plan guess(const Tick& tick, const HorizonReference& reference) const;
  [[nodiscard]] std::optional<Plan> plannedOn(const Tick& tick) const;
  bool solve(Tick& tick, const HorizonReference& reference);
  void flyFresh(Tick& tick);
  bool flyShifted(Tick& tick);
  bool flyCommitted(Tick& tick, const HorizonReference& reference);
  void flyBrake(Tick& tick, const std::string& why);
  void distrust();
  [[nodiscard]] bool collides(const Plan& motion, const LocalPlannerInput& input) const;
  void show(const Plan& motion, LocalPlannerOutput& output) const;

  LocalPlannerConfig config;
  core::Vehicle vehicle;
  detail::Nmpc nmpc;

  // The warm start, and what is thought of it.
  std::optional<Plan> plan;  // the last fresh solution
  int shifts = 0;
  int failures = 0;   // in a row
  int probation = 0;  // good solutions still asked for before one is flown
  std::optional<double> held_heading;
  std::optional<double> last_t;
};

namespace
{
const LocalPlannerConfig& checked(const LocalPlannerConfig& config, const core::Vehicle& vehicle)
{
  LocalPlannerConfig::fields(config, RangeCheck());
  core::Vehicle::fields(vehicle, RangeCheck());
  return config;
}
}  // namespace

namespace
{
/// True if an obstacle stands between a motion and the reference: it passes it on the other side.
bool losesSight(const Plan& motion, const HorizonReference& reference,
                const core::DistanceField& field, double radius)
{
  constexpr double kStep_m = 0.15, kMostPieces = 20.0;
  for (Eigen::Index k = 1; k < motion.positions.cols(); ++k)
  {
    const Eigen::Vector3d from = motion.positions.col(k);
    const Eigen::Vector3d across = reference.positions.col(k) - from;
    const double pieces = std::min(kMostPieces, std::ceil(across.norm() / kStep_m));
    for (double i = 1.0; i < pieces; ++i)
      if (field.distance(from + i / pieces * across, core::UnknownAs::Free).value_or(radius) <
          0.5 * radius)
        return true;
  }
  return false;
}
}  // namespace

LocalPlanner::Impl::Impl(const LocalPlannerConfig& given, const core::Vehicle& limits)
    : config(checked(given, limits)), vehicle(limits), nmpc(config, vehicle)
{
}

/// The time over which a change of command is spread; never longer than one stage, so that a late
/// step does not make the command jump.
double LocalPlanner::Impl::sinceLastCommand(const LocalPlannerInput& input)
{
  const double t = input.state.t;
  double elapsed = last_t && std::isfinite(t) ? t - *last_t : config.step_s;
  if (input.elapsed_s > 0.0) elapsed = input.elapsed_s;
  if (std::isfinite(t)) last_t = t;
  return elapsed > 1e-3 ? std::min(elapsed, config.step_s) : config.step_s;
}

/// The last plan as it looks now; none if it is too old.
std::optional<Plan> LocalPlanner::Impl::plannedOn(const Tick& tick) const
{
  const double age = plan ? tick.input.state.t - plan->t : -1.0;
  if (age < 0.0 || age >= config.horizon * config.step_s) return std::nullopt;
  return detail::rollOut(tick.input.state.t, tick.motion,
                         detail::shiftedInputs(*plan, age, config.step_s), tick.model);
}

Plan LocalPlanner::Impl::guess(const Tick& tick, const HorizonReference& reference) const
{
  Plan pursuit =
      detail::pursue(tick.input.state.t, tick.motion, stack(tick.last), reference, tick.model);
  if (failures >= kColdAfter) return pursuit;
  auto shifted = plannedOn(tick);
  if (!shifted) return pursuit;
  // Obstacles seen from the wrong side of one would keep the vehicle there.
  const auto lost = [&](const Plan& motion) {
    return tick.input.field && losesSight(motion, reference, *tick.input.field, vehicle.radius_m);
  };
  return lost(*shifted) && !lost(pursuit) ? pursuit : *std::move(shifted);
}

void LocalPlanner::Impl::show(const Plan& motion, LocalPlannerOutput& output) const
{
  output.horizon_L = motion.positions;
  output.horizon_yaw = motion.yaw;
}

/// Makes a new plan; false if there is none that may be flown.
bool LocalPlanner::Impl::solve(Tick& tick, const HorizonReference& reference)
{
  const Plan start = guess(tick, reference);
  const KeepOuts rows = detail::keepOuts(tick.input, start, config, vehicle);
  LocalPlannerOutput& output = tick.output;
  if (!rows.finite)
  {
    output.report.message = "what is known of obstacles is not finite";
    return false;
  }
  output.close_obstacles_L = rows.points_L;
  detail::Nmpc::Result result =
      nmpc.solve({tick.input.state.t, tick.motion, stack(tick.last), tick.dt}, reference, rows,
                 start, tick.model, tick.input.deadline);
  output.report = std::move(result.report);
  const core::SolveReport& report = output.report;
  const bool early = report.termination == Termination::IterationLimit ||
                     report.termination == Termination::TimeLimit;
  const bool nearly =
      early && report.primal_residual <= kFeasible && report.dual_residual <= kStationary;
  if (!(report.converged() || nearly) || !result.plan.inputs.allFinite()) return false;
  plan = std::move(result.plan);
  output.worst_obstacle_slack_m = std::max(0.0, result.worst_slack);
  output.reason = nearly ? "tracking, solver stopped early" : "tracking";
  return true;
}

void LocalPlanner::Impl::flyFresh(Tick& tick)
{
  shifts = 0;
  LocalPlannerOutput& output = tick.output;
  output.fallback = Fallback::None;
  output.command = lawful(plan->command(), tick.last, tick.dt, vehicle);
  show(*plan, output);
  if (output.worst_obstacle_slack_m > 0.01)
    output.reason +=
        withNumber(", %.2f m inside the asked-for distance", output.worst_obstacle_slack_m);
}

/// True if the motion comes nearer than the radius to an obstacle, and nearer than it starts.
bool LocalPlanner::Impl::collides(const Plan& motion, const LocalPlannerInput& input) const
{
  const auto room = [&](Eigen::Index k)
  {
    const Eigen::Vector3d p = motion.positions.col(k);
    const double time = motion.t + static_cast<double>(k) * config.step_s;
    double least = std::numeric_limits<double>::infinity();
    if (input.field)
      least = input.field->distance(p, core::UnknownAs::Free).value_or(least) - vehicle.radius_m;
    for (const core::MovingObstacle& mover : input.movers)
      least = std::min(least, (p - mover.nearest(p, time)).norm() -
                                  detail::contactDistance(mover, time, vehicle));
    return least;
  };
  const double start = room(0);
  for (Eigen::Index k = 1; k < motion.positions.cols(); ++k)
    if (const double here = room(k); !(here >= 0.0 || here >= start - 1e-3)) return true;
  return false;
}

/// Flies the last plan on, if it is fresh enough and still free.
bool LocalPlanner::Impl::flyShifted(Tick& tick)
{
  if (shifts >= kMaxShifts) return false;
  const std::optional<Plan> motion = plannedOn(tick);
  if (!motion || collides(*motion, tick.input)) return false;
  ++shifts;
  LocalPlannerOutput& output = tick.output;
  output.fallback = Fallback::Shifted;
  output.command = lawful(motion->command(), tick.last, tick.dt, vehicle);
  output.reason = output.report.message + ": previous plan, tick " + std::to_string(shifts) +
                  " of " + std::to_string(kMaxShifts);
  show(*motion, output);
  return true;
}

/// Pursues the reference, which is certified and ends at rest, as long as that leads nowhere else.
bool LocalPlanner::Impl::flyCommitted(Tick& tick, const HorizonReference& reference)
{
  const Plan motion =
      detail::pursue(tick.input.state.t, tick.motion, stack(tick.last), reference, tick.model);
  if (!motion.inputs.allFinite() || collides(motion, tick.input)) return false;
  LocalPlannerOutput& output = tick.output;
  output.fallback = Fallback::Committed;
  output.command = lawful(motion.command(), tick.last, tick.dt, vehicle);
  output.reason = output.report.message + ": pursuing the committed reference";
  show(motion, output);
  return true;
}

void LocalPlanner::Impl::distrust()
{
  plan.reset();
  probation = kTrustAfter;
}

void LocalPlanner::Impl::flyBrake(Tick& tick, const std::string& why)
{
  LocalPlannerOutput& output = tick.output;
  output.fallback = Fallback::Brake;
  output.command = brake(tick.last, tick.dt, vehicle);
  output.reason = why + ": brake";
  const core::VehicleState& state = tick.input.state;
  if (!state.p_L.allFinite() || !state.v_W.allFinite() || !state.q_WB.coeffs().allFinite()) return;
  Eigen::Matrix4Xd inputs(4, config.horizon);
  core::VelocityCommand slowing = output.command;
  for (auto input : inputs.colwise())
  {
    input = stack(slowing);
    slowing = brake(slowing, config.step_s, vehicle);
  }
  show(detail::rollOut(state.t, tick.motion, inputs, tick.model), output);
}

LocalPlannerOutput LocalPlanner::Impl::step(const LocalPlannerInput& input)
{
  Tick tick{input,
            core::trustedLast(input.last_command, input.state.v_W, vehicle),
            sinceLastCommand(input),
            {vehicle, config.step_s, input.disturbance_W},
            detail::motionOf(input.state),
            {}};
  if (const std::string why = trouble(input); !why.empty())
  {
    plan.reset();
    tick.output.report.message = why;
    flyBrake(tick, why);
    return std::move(tick.output);
  }
  const HorizonReference reference = detail::sampleHorizon(input, config, vehicle, held_heading);
  held_heading = reference.heading;
  const bool solved = solve(tick, reference);
  failures = solved ? 0 : failures + 1;
  if (probation > 0) probation = solved ? probation - 1 : kTrustAfter;
  if (probation > 0)
  {
    flyBrake(tick, solved ? "solver on probation" : tick.output.report.message);
  }
  else if (solved)
    flyFresh(tick);
  else if (!flyShifted(tick) && !flyCommitted(tick, reference))
  {
    distrust();
    flyBrake(tick, tick.output.report.message);
  }
  return std::move(tick.output);
}

LocalPlanner::LocalPlanner(const LocalPlannerConfig& config, const core::Vehicle& vehicle)
    : impl_(std::make_unique<Impl>(config, vehicle))
{
}
LocalPlanner::~LocalPlanner() = default;
LocalPlanner::LocalPlanner(LocalPlanner&&) noexcept = default;
LocalPlanner& LocalPlanner::operator=(LocalPlanner&&) noexcept = default;

LocalPlannerOutput LocalPlanner::step(const LocalPlannerInput& input)
{
  try
  {
    return impl_->step(input);
  }
  catch (const std::exception& error)
  {
    LocalPlannerOutput output;
    output.fallback = Fallback::Brake;
    output.command = brake(core::trustedLast(input.last_command, input.state.v_W, impl_->vehicle),
                           impl_->config.step_s, impl_->vehicle);
    output.reason = std::string(error.what()) + ": brake";
    return output;
  }
}

void LocalPlanner::reset()
{
  impl_->plan.reset();
  impl_->shifts = impl_->failures = impl_->probation = 0;
  impl_->held_heading.reset();
  impl_->last_t.reset();
}

}  // namespace slalom::local_planner
