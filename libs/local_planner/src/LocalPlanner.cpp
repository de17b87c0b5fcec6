// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/local_planner/LocalPlanner.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <optional>
#include <stdexcept>

#include "CloseObstacles.h"
#include "HorizonReference.h"
#include "NmpcProgram.h"
#include "OutputGate.h"
#include "Plan.h"

namespace slalom::local_planner
{
namespace
{
using core::Termination;
using detail::CloseObstacles;
using detail::HorizonReference;
using detail::NmpcProgram;
using detail::Plan;

constexpr int kMaxShifts = 5;   // ticks that an old plan may be flown on
constexpr double kReach = 1.0;  // [m] beyond the asked-for distance, how far obstacles matter
constexpr double kFarthestPull = 1.5;  // [m] of the reference from the expected position
constexpr int kQuickIterations = 25;
constexpr double kDeep = 0.05;   // [m] a guess this far inside the asked-for distance is a bad one
constexpr double kUnused = 1e3;  // [m] depth of a row that is not needed
constexpr double kFeasible = 1e-3;    // [SI] residual of a plan that may be flown
constexpr double kStationary = 5e-2;  // and of its gradient

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
};

/// Why this input cannot be planned on; empty if it can.
std::string trouble(const LocalPlannerInput& input)
{
  if (!input.reference || !input.law) return "no reference";
  const core::VehicleState& s = input.state;
  if (!std::isfinite(s.t) || !s.p_L.allFinite() || !s.v_W.allFinite() ||
      !s.q_WB.coeffs().allFinite() || !std::isfinite(s.yaw()))
    return "the state is not finite";
  if (!std::isfinite(input.progress)) return "the progress on the reference is not finite";
  if (!input.last_command.v_W.allFinite() || !std::isfinite(input.last_command.yaw_rate))
    return "the last command is not finite";
  return {};
}

Eigen::Vector4d stack(const core::VelocityCommand& command)
{
  return {command.v_W.x(), command.v_W.y(), command.v_W.z(), command.yaw_rate};
}

core::VelocityCommand commandOf(const Eigen::Vector4d& input)
{
  return {input.head<3>(), input[3]};
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
    case Fallback::Brake:
      return "Brake";
  }
  return "?";
}

struct LocalPlanner::Impl
{
  Impl(const LocalPlannerConfig& given, const core::Vehicle& limits);

  LocalPlannerOutput step(const LocalPlannerInput& input);

  /// One problem shape with its solver; a shape per number of obstacle rows keeps free flight
  /// cheap.
  struct Shape
  {
    NmpcProgram program;
    optim::IpoptSolver quick, thorough;
  };

  /// What a step works on.
  struct Tick
  {
    const LocalPlannerInput& input;
    core::VelocityCommand last;
    double dt;  ///< [s] since the last step
    LocalPlannerOutput output;
  };

  double sinceLastStep(double t);
  [[nodiscard]] Eigen::Vector4d startOf(const core::VehicleState& state,
                                        const HorizonReference& reference) const;
  [[nodiscard]] Eigen::Vector4d lead(const HorizonReference& reference) const;
  [[nodiscard]] Eigen::Vector4d lastInput(const Tick& tick,
                                          const HorizonReference& reference) const;
  Plan guess(const Tick& tick, const HorizonReference& reference) const;
  Shape& prepare(const Tick& tick, const HorizonReference& reference, const Plan& guess,
                 const CloseObstacles& close);
  [[nodiscard]] double askedDistance() const
  {
    return vehicle.radius_m + config.min_clearance_margin_m;
  }
  optim::NlpSolution solve(Shape& shape, const Plan& guess, const core::Deadline& deadline) const;
  bool flyFresh(Tick& tick, const HorizonReference& reference);
  bool flyShifted(Tick& tick);
  void flyBrake(Tick& tick, const std::string& why);
  [[nodiscard]] bool collides(const Plan& motion, const core::DistanceField* field) const;
  void show(const Plan& motion, LocalPlannerOutput& output) const;

  LocalPlannerConfig config;
  core::Vehicle vehicle;
  std::vector<Shape> shapes;  // by rows per stage

  // The warm start.
  std::optional<Plan> plan;    // the last fresh solution
  bool plan_is_guess = false;  // false after a failure: do not start from what just failed
  int shifts = 0;
  std::optional<double> held_heading;
  std::optional<double> last_t;
};

LocalPlanner::Impl::Impl(const LocalPlannerConfig& given, const core::Vehicle& limits)
    : config(given), vehicle(limits)
{
  LocalPlannerConfig::fields(config, RangeCheck());
  core::Vehicle::fields(vehicle, RangeCheck());
  // A small barrier takes the least iterations from a good guess but may stall from a bad one,
  // where the multipliers are still far from the penalty; the large one starts at that scale.
  optim::IpoptConfig quick{.tolerance = config.tolerance,
                           .max_iterations = std::min(kQuickIterations, config.max_iterations)};
  optim::IpoptConfig thorough{.tolerance = config.tolerance,
                              .max_iterations = config.max_iterations};
  thorough.initial_barrier = std::max(quick.initial_barrier, 0.05 * config.obstacle_penalty);
  for (int rows = 0; rows <= config.obstacles_per_stage; ++rows)
    shapes.push_back({NmpcProgram(config, vehicle, rows), optim::IpoptSolver(quick),
                      optim::IpoptSolver(thorough)});
}

/// The time over which a change of command is spread; never longer than one stage, so that a late
/// step does not make the command jump.
double LocalPlanner::Impl::sinceLastStep(double t)
{
  const double elapsed = last_t && std::isfinite(t) ? t - *last_t : config.step_s;
  if (std::isfinite(t)) last_t = t;
  return elapsed > 1e-3 ? std::min(elapsed, config.step_s) : config.step_s;
}

/* With v' = (u - v) / lag and z = p + lag (v - v_ref) the motion obeys z' = u - lag a_ref: the
 * kinematic model, in z and u - lag a_ref, without error. z is p where the vehicle keeps up with
 * its reference; elsewhere it is where the vehicle will be once its velocity has caught up. */
Eigen::Vector4d LocalPlanner::Impl::startOf(const core::VehicleState& state,
                                            const HorizonReference& reference) const
{
  Eigen::Vector4d start;
  start << state.p_L + vehicle.velocity_lag_s * (state.v_W - reference.inputs.col(0).head<3>()),
      state.yaw();
  return start;
}

/// What the command is ahead of the model's input.
Eigen::Vector4d LocalPlanner::Impl::lead(const HorizonReference& reference) const
{
  Eigen::Vector4d ahead = Eigen::Vector4d::Zero();
  ahead.head<3>() = vehicle.velocity_lag_s * reference.acceleration;
  return ahead;
}

/// The model's input that the last command was; within the limits, which hold for both.
Eigen::Vector4d LocalPlanner::Impl::lastInput(const Tick& tick,
                                              const HorizonReference& reference) const
{
  Eigen::Vector4d input = stack(tick.last) - lead(reference);
  input.head<3>() =
      input.head<3>().cwiseMax(-vehicle.max_speed_mps).cwiseMin(vehicle.max_speed_mps);
  return input;
}

Plan LocalPlanner::Impl::guess(const Tick& tick, const HorizonReference& reference) const
{
  const Eigen::Vector4d start = startOf(tick.input.state, reference);
  const double age = plan ? tick.input.state.t - plan->t : -1.0;
  if (!plan_is_guess || age < 0.0 || age >= config.horizon * config.step_s)
    return detail::pursue(start, lastInput(tick, reference), reference, config.step_s, vehicle);
  Plan shifted{tick.input.state.t, {}, detail::shiftedInputs(*plan, age, config.step_s)};
  shifted.states = detail::rollOut(start, shifted.inputs, config.step_s);
  return shifted;
}

LocalPlanner::Impl::Shape& LocalPlanner::Impl::prepare(const Tick& tick,
                                                       const HorizonReference& reference,
                                                       const Plan& guess,
                                                       const CloseObstacles& close)
{
  std::vector<std::vector<Eigen::Vector3d>> nearest(static_cast<std::size_t>(config.horizon));
  std::size_t rows = 0;
  for (std::size_t k = 0; k < nearest.size() && !close.points_L.empty(); ++k)
  {
    nearest[k] =
        detail::nearestAround(close.anchors.col(static_cast<Eigen::Index>(k) + 1), close.points_L,
                              config.obstacles_per_stage, askedDistance() + kReach);
    rows = std::max(rows, nearest[k].size());
  }
  Shape& shape = shapes[rows];
  detail::NmpcData& data = shape.program.data;
  data.state = guess.states.col(0);
  data.last_input = lastInput(tick, reference);
  data.elapsed = tick.dt;
  data.state_reference = reference.states;
  // A bounded pull keeps the penalty on obstacles exact however far the reference has run ahead.
  for (int k = 1; k <= config.horizon; ++k)
  {
    auto wanted = data.state_reference.col(k).head<3>();
    const Eigen::Vector3d away = wanted - guess.states.col(k).head<3>();
    if (away.norm() > kFarthestPull) wanted -= (1.0 - kFarthestPull / away.norm()) * away;
  }
  data.input_reference = reference.inputs;
  for (std::size_t k = 0; rows > 0 && k < nearest.size(); ++k)
  {
    const Eigen::Vector3d anchor = close.anchors.col(static_cast<Eigen::Index>(k) + 1);
    for (std::size_t j = 0; j < rows; ++j)
    {
      detail::KeepOut& row = data.keep_outs[k * rows + j];
      // A row that is not needed holds everywhere; the structure stays.
      row = {Eigen::Vector3d::UnitZ(), anchor.z() - kUnused};
      if (j >= nearest[k].size()) continue;
      row.normal = (anchor - nearest[k][j]).normalized();
      row.offset = row.normal.dot(nearest[k][j]) + askedDistance();
    }
  }
  return shape;
}

void LocalPlanner::Impl::show(const Plan& motion, LocalPlannerOutput& output) const
{
  output.horizon_L = motion.states.topRows<3>();
  output.horizon_yaw = motion.states.row(3).transpose();
}

optim::NlpSolution LocalPlanner::Impl::solve(Shape& shape, const Plan& guess,
                                             const core::Deadline& deadline) const
{
  optim::NlpPoint start;
  start.x = shape.program.pack(guess.states, guess.inputs);
  if (shape.program.neededSlack(guess.states) <= kDeep)
  {
    optim::NlpSolution solution = shape.quick.solve(shape.program, start, deadline);
    if (solution.report.converged() || deadline.passed()) return solution;
  }
  return shape.thorough.solve(shape.program, start, deadline);
}

/// A fresh plan; false if there is none that may be flown.
bool LocalPlanner::Impl::flyFresh(Tick& tick, const HorizonReference& reference)
{
  const Plan start = guess(tick, reference);
  CloseObstacles close;
  if (tick.input.field && config.obstacles_per_stage > 0)
  {
    close = detail::collectCloseObstacles(*tick.input.field, start.states.topRows<3>(),
                                          vehicle.radius_m, askedDistance() + kReach);
  }
  LocalPlannerOutput& output = tick.output;
  if (!close.finite)
  {
    output.report.message = "the distance field is not finite";
    return false;
  }
  output.close_obstacles_L = close.points_L;
  Shape& shape = prepare(tick, reference, start, close);
  optim::NlpSolution solution = solve(shape, start, tick.input.deadline);
  output.report = std::move(solution.report);

  const core::SolveReport& report = output.report;
  const bool nearly = report.termination == Termination::IterationLimit &&
                      report.primal_residual <= kFeasible && report.dual_residual <= kStationary;
  plan_is_guess = (report.converged() || nearly) && solution.point.x.allFinite();
  if (!plan_is_guess) return false;

  plan = Plan{tick.input.state.t, shape.program.statesOf(solution.point.x),
              shape.program.inputsOf(solution.point.x)};
  shifts = 0;
  output.fallback = Fallback::None;
  output.command =
      detail::gate(commandOf(plan->inputs.col(0) + lead(reference)), tick.last, tick.dt, vehicle);
  output.worst_obstacle_slack_m = std::max(0.0, shape.program.worstSlack(solution.point.x));
  show(*plan, output);
  output.reason = nearly ? "tracking, iteration limit reached" : "tracking";
  if (output.worst_obstacle_slack_m > 0.01)
    output.reason +=
        withNumber(", %.2f m inside the asked-for distance", output.worst_obstacle_slack_m);
  return true;
}

/// True if the motion comes nearer than the radius to an obstacle, and nearer than it starts.
bool LocalPlanner::Impl::collides(const Plan& motion, const core::DistanceField* field) const
{
  if (!field) return false;
  const auto start = field->distance(motion.states.col(0).head<3>(), core::UnknownAs::Free);
  for (const auto& state : motion.states.colwise())
  {
    const auto d = field->distance(state.head<3>(), core::UnknownAs::Free);
    if (d && !(*d >= vehicle.radius_m || (start && *d >= *start - 1e-3))) return true;
  }
  return false;
}

/// The last plan as it looks now, if it is fresh enough and still free.
bool LocalPlanner::Impl::flyShifted(Tick& tick)
{
  const core::VehicleState& state = tick.input.state;
  const double age = plan ? state.t - plan->t : -1.0;
  if (age < 0.0 || age >= config.horizon * config.step_s || shifts >= kMaxShifts) return false;
  Eigen::Vector4d start;
  start << state.p_L, state.yaw();
  Plan motion{state.t, {}, detail::shiftedInputs(*plan, age, config.step_s)};
  motion.states = detail::rollOut(start, motion.inputs, config.step_s);
  if (collides(motion, tick.input.field.get())) return false;

  ++shifts;
  LocalPlannerOutput& output = tick.output;
  output.fallback = Fallback::Shifted;
  output.command = detail::gate(commandOf(motion.inputs.col(0)), tick.last, tick.dt, vehicle);
  output.reason = output.report.message + ": previous plan, tick " + std::to_string(shifts) +
                  " of " + std::to_string(kMaxShifts);
  show(motion, output);
  return true;
}

void LocalPlanner::Impl::flyBrake(Tick& tick, const std::string& why)
{
  LocalPlannerOutput& output = tick.output;
  output.fallback = Fallback::Brake;
  output.command = detail::brake(tick.last, tick.dt, vehicle);
  output.reason = why + ": brake";
  plan.reset();
  plan_is_guess = false;
  const core::VehicleState& state = tick.input.state;
  if (!state.p_L.allFinite() || !state.q_WB.coeffs().allFinite()) return;
  Plan motion{state.t, {}, Eigen::Matrix4Xd(4, config.horizon)};
  core::VelocityCommand slowing = output.command;
  for (Eigen::Index k = 0; k < motion.inputs.cols(); ++k)
  {
    motion.inputs.col(k) = stack(slowing);
    slowing = detail::brake(slowing, config.step_s, vehicle);
  }
  Eigen::Vector4d start;
  start << state.p_L, state.yaw();
  motion.states = detail::rollOut(start, motion.inputs, config.step_s);
  show(motion, output);
}

LocalPlannerOutput LocalPlanner::Impl::step(const LocalPlannerInput& input)
{
  Tick tick{input,
            detail::trustedLast(input.last_command, input.state.v_W, vehicle),
            sinceLastStep(input.state.t),
            {}};
  if (const std::string why = trouble(input); !why.empty())
  {
    tick.output.report.message = why;
    flyBrake(tick, why);
    return std::move(tick.output);
  }
  const HorizonReference reference = detail::sampleHorizon(input, config, vehicle, held_heading);
  held_heading = reference.heading;
  if (!flyFresh(tick, reference) && !flyShifted(tick)) flyBrake(tick, tick.output.report.message);
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
    output.command =
        detail::brake(detail::trustedLast(input.last_command, input.state.v_W, impl_->vehicle),
                      impl_->config.step_s, impl_->vehicle);
    output.reason = std::string(error.what()) + ": brake";
    return output;
  }
}

void LocalPlanner::reset()
{
  impl_->plan.reset();
  impl_->plan_is_guess = false;
  impl_->shifts = 0;
  impl_->held_heading.reset();
  impl_->last_t.reset();
}

}  // namespace slalom::local_planner
