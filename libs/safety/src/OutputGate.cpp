// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/safety/OutputGate.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>

#include "CommandLimits.h"
#include "StopCheck.h"

namespace slalom::safety
{
namespace
{
using detail::Cause;
using detail::StopCheck;
using detail::Verdict;

constexpr double kSame = 1e-6;  // [m/s] commands that differ less count as the same
constexpr int kHalvings = 3;

/// Throws on the first field outside its range.
struct RangeCheck
{
  void operator()(const char* name, const double& number, const core::Range& range, const char*,
                  core::Level = core::Level::Public) const
  {
    if (number >= range.min && number <= range.max) return;
    throw std::invalid_argument(std::string(name) + " = " + std::to_string(number) +
                                " is outside [" + std::to_string(range.min) + ", " +
                                std::to_string(range.max) + "]");
  }
  template <class... Others>
  void operator()(const Others&...) const
  {
  }
};

template <class... Numbers>
std::string format(const char* pattern, Numbers... numbers)
{
  char text[160];
  std::snprintf(text, sizeof text, pattern, numbers...);
  return text;
}

bool plausible(const GateInput& input)
{
  const core::VehicleState& s = input.state;
  const auto within = [](const Eigen::Vector3d& x, double most)
  { return x.allFinite() && x.cwiseAbs().maxCoeff() <= most; };
  return std::isfinite(input.t) && std::isfinite(s.t) && within(s.p_L, 1e7) && within(s.p_W, 1e7) &&
         within(s.v_W, 1e3);
}

/// Why nothing but braking is trusted.
struct Distrust
{
  Intervention intervention = Intervention::None;
  std::string reason;
};

/// All that a pass works on.
struct Pass
{
  const GateInput& input;
  const SafetyConfig& config;
  const core::Vehicle& vehicle;
  core::VelocityCommand last;
  double change;           // [m/s] per axis
  Eigen::Vector3d brake;   // the hardest one
  Eigen::Vector3d target;  // what is to be passed
  GateOutput output;

  [[nodiscard]] Distrust distrust() const;
  void fence(const StopCheck& check);
  void keepStop(const StopCheck& check, bool trusted);
  void rely(const Verdict& verdict, const StopCheck& check);
  void followInstead(const StopCheck& check, const Verdict& grazing);
  void chooseInstead(const StopCheck& check, const Verdict& refused);
  void evade(const StopCheck& check, Verdict& best);
  void explain(const Verdict& refused, double excused);
  void describe(const Eigen::Vector3d& wanted, const Distrust& distrust);
  [[nodiscard]] const core::DistanceField* field() const;
};

Distrust Pass::distrust() const
{
  const GateInput& in = input;
  if (!in.wanted.v_W.allFinite() || !std::isfinite(in.wanted.yaw_rate))
    return {Intervention::NotFinite, "the command is not finite: brake"};
  if (!plausible(in)) return {Intervention::NotFinite, "the state is not finite: brake"};
  if (!(in.state_age_s <= config.state_timeout_s))
    return {Intervention::StateTooOld, format("the state is %.2f s old: brake", in.state_age_s)};
  if (!in.needs_map) return {};
  if (!in.field) return {Intervention::MapTooOld, "no map: brake"};
  if (!(in.map_age_s <= config.map_timeout_s))
    return {Intervention::MapTooOld, format("the map is %.2f s old: brake", in.map_age_s)};
  if (in.plan_age_s <= config.plan_timeout_s) return {};
  return {Intervention::PlanTooOld,
          std::isfinite(in.plan_age_s)
              ? format("the plan was verified %.2f s ago: brake", in.plan_age_s)
              : std::string("no plan: brake")};
}

/// An old map is still the best there is, unless the host does without.
const core::DistanceField* Pass::field() const
{
  const bool counts = input.needs_map || input.map_age_s <= config.map_timeout_s;
  return counts ? input.field.get() : nullptr;
}

void Pass::fence(const StopCheck& check)
{
  if ((config.fenceMin().array() <= -1e6).all() && (config.fenceMax().array() >= 1e6).all()) return;
  const core::VehicleState& s = input.state;
  const Eigen::Vector3d p_W = check.begin().p + s.p_W - s.p_L;
  for (int i = 0; i < 3; ++i)
    target[i] = detail::insideFence(
        target[i],
        {p_W[i], check.begin().v[i], config.fenceMin()[i], config.fenceMax()[i], brake[i],
         check.hold(), vehicle.velocity_lag_s, config.lag_reserve_s, check.deceleration()});
}

void Pass::keepStop(const StopCheck& check, bool trusted)
{
  if (!field() && input.movers.empty()) return;
  const Verdict verdict = check.judge(target, Verdict{}, check.evasions());
  rely(verdict, check);
  // Without anything around there is no margin to tell of.
  if (!std::isfinite(verdict.slack())) output.stop_margin_m = 0.0;
  if (!verdict.good) chooseInstead(check, verdict);
  // A brake of the gate's own choice should not even graze.
  if (verdict.good && verdict.slack() < 0.0 && !trusted) followInstead(check, verdict);
}

void Pass::rely(const Verdict& verdict, const StopCheck& check)
{
  output.stop_margin_m = verdict.slack() - check.excused();
  output.stop_plan = verdict.plan;
  output.evasion = verdict.evasion;
}

void Pass::followInstead(const StopCheck& check, const Verdict& grazing)
{
  Verdict best = grazing;
  best.stands_clear = false;  // what counts here is by how much
  for (const StopPath* plan : {input.plan, input.kept_plan})
  {
    if (!plan) continue;
    const Eigen::Vector3d command = detail::limited(check.follow(*plan), last.v_W, change, vehicle);
    Verdict verdict = check.judge(command, best, check.keptEvasion());
    if (!(verdict.slack() > best.slack())) continue;
    target = command;
    best = verdict;
    best.stands_clear = false;
    rely(best, check);
  }
}

void Pass::chooseInstead(const StopCheck& check, const Verdict& refused)
{
  const Eigen::Vector3d wanted = target;
  Verdict best = refused;
  const auto better = [&](const Eigen::Vector3d& command, std::span<const Evasion> aside)
  {
    Verdict bar = best;
    if (best.good) bar.mover = std::min(best.mover, 0.0);
    const Verdict verdict = check.judge(command, bar, aside);
    // Among good ones the later one counts: the halving climbs towards what was wanted.
    if (!(verdict.good || (!best.good && verdict.betterThan(best)))) return false;
    best = verdict;
    target = command;
    return verdict.good;
  };
  const auto blend = [&](double share)
  { return Eigen::Vector3d(brake + share * (wanted - brake)); };

  bool found = false;
  for (const StopPath* plan : {input.plan, input.kept_plan})
    if (plan && !found)
      found = better(detail::limited(check.follow(*plan), last.v_W, change, vehicle),
                     check.keptEvasion());
  const bool brakes = (brake - wanted).cwiseAbs().maxCoeff() <= kSame;
  if (!found && !brakes && better(brake, check.evasions()))
  {
    found = true;
    // The way aside that saves the brake is the one to save more.
    const Evasion aside = best.evasion;
    const auto same = aside.for_s > 0.0 ? std::span(&aside, 1) : check.keptEvasion();
    double low = 0.0, high = 1.0;
    for (int halving = 0; halving < kHalvings; ++halving)
    {
      const double middle = 0.5 * (low + high);
      (better(blend(middle), same) ? low : high) = middle;
    }
  }
  for (const double share : {0.5, 0.25, 0.75})
    if (!found && !brakes) found = better(blend(share), check.keptEvasion());
  if (!best.stands_clear)
    better(detail::limited(last.v_W + change * check.away(), last.v_W, change, vehicle),
           check.keptEvasion());
  if (!best.good) evade(check, best);
  rely(best, check);
  if (target != wanted) explain(refused, check.excused());  // else nothing would be better
}

/// @param refused what is wrong with the wanted command
void Pass::explain(const Verdict& refused, double excused)
{
  const char* what = "no stop in known free space";
  output.intervention = Intervention::NoStop;
  if (refused.stands_clear)
  {
    what = "no stop clear of a moving obstacle";
    output.intervention = Intervention::MovingObstacle;
  }
  else if (refused.cause == Cause::Fence)
  {
    what = "no stop inside the fence";
    output.intervention = Intervention::Geofence;
  }
  output.reason =
      format("%s after this command: %.3f m beyond the radius; passed one with %.3f m%s", what,
             refused.slack() - excused, output.stop_margin_m,
             output.evasion.for_s > 0.0 ? ", which leads aside" : "");
}

/// Begins the way aside that keeps the largest distance.
void Pass::evade(const StopCheck& check, Verdict& best)
{
  constexpr double kAmple = 0.5;     // [m] more is not looked for
  constexpr double kFaithful = 0.1;  // [m] by which another way must be better than the one begun
  bool begun = check.keepsEvasion(), kept = false;
  for (const Evasion& evasion : check.evasions())
  {
    const Eigen::Vector3d command = detail::limited(evasion.v_W, last.v_W, change, vehicle);
    Verdict bar = best;
    // Not so for one that may begin later: each tick of waiting costs less than any such margin.
    if (kept) bar.mover += kFaithful;
    const Verdict verdict = check.judge(command, evasion, bar);
    if (verdict.betterThan(bar))
    {
      best = verdict;
      target = command;
      kept = begun;
    }
    if (best.stands_clear && best.leaves &&
        best.mover >= (begun ? config.evasion_margin_m : kAmple))
      return;
    begun = false;
  }
}

void Pass::describe(const Eigen::Vector3d& wanted, const Distrust& distrust)
{
  const auto differs = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b)
  { return !((a - b).cwiseAbs().maxCoeff() <= kSame); };
  if (distrust.intervention != Intervention::None)
  {
    // Who wanted to brake anyway was not overruled.
    const bool same = distrust.intervention != Intervention::NotFinite &&
                      !differs(output.command.v_W, input.wanted.v_W) &&
                      std::abs(input.wanted.yaw_rate) <= kSame;
    output.intervention = same ? Intervention::None : distrust.intervention;
    output.reason = same ? std::string() : distrust.reason;
    if (!same && output.stop_plan) output.reason += ", along a planned stop";
    return;
  }
  if (output.intervention != Intervention::None) return;
  if (differs(output.command.v_W, wanted))
  {
    output.intervention = Intervention::Geofence;
    output.reason = "no room to stop before the fence";
  }
  else if (differs(wanted, input.wanted.v_W) ||
           std::abs(output.command.yaw_rate - input.wanted.yaw_rate) > kSame)
  {
    output.intervention = Intervention::Limits;
    output.reason = "speed, acceleration or yaw rate outside the limits";
  }
}

}  // namespace

std::string_view toString(Intervention intervention)
{
  switch (intervention)
  {
    case Intervention::None:
      return "None";
    case Intervention::NotFinite:
      return "NotFinite";
    case Intervention::Limits:
      return "Limits";
    case Intervention::StateTooOld:
      return "StateTooOld";
    case Intervention::MapTooOld:
      return "MapTooOld";
    case Intervention::PlanTooOld:
      return "PlanTooOld";
    case Intervention::Geofence:
      return "Geofence";
    case Intervention::NoStop:
      return "NoStop";
    case Intervention::MovingObstacle:
      return "MovingObstacle";
  }
  return "?";
}

OutputGate::OutputGate(const SafetyConfig& config, const core::Vehicle& vehicle)
    : config_(config), vehicle_(vehicle)
{
  SafetyConfig::fields(config_, RangeCheck());
  core::Vehicle::fields(vehicle_, RangeCheck());
  if (!(config_.fenceMin().array() < config_.fenceMax().array()).all())
    throw std::invalid_argument("fence_min must be below fence_max on every axis");
}

GateOutput OutputGate::pass(const GateInput& input) const
{
  Pass pass{input, config_, vehicle_, detail::trustedLast(input.last, input.state.v_W, vehicle_),
            0.0,   {},      {},       {}};
  // Written so that what is not a number counts as 0.
  const double dt = input.dt > 0.0 ? std::min(input.dt, detail::kLongestTick) : 0.0;
  pass.change = vehicle_.max_acceleration_mps2 * dt;
  pass.brake = detail::braked(pass.last.v_W, pass.change);

  const Distrust distrust = pass.distrust();
  const bool trusted = distrust.intervention == Intervention::None;
  pass.target = trusted ? detail::limited(input.wanted.v_W, pass.last.v_W, pass.change, vehicle_)
                        : pass.brake;
  const Eigen::Vector3d wanted = pass.target;
  if (plausible(input) && distrust.intervention != Intervention::StateTooOld)
  {
    const StopCheck check(input, config_, vehicle_, pass.last.v_W,
                          config_.verify_stop ? pass.field() : nullptr);
    pass.fence(check);
    if (config_.verify_stop) pass.keepStop(check, trusted);
  }
  GateOutput& output = pass.output;
  output.command.v_W = detail::limited(pass.target, pass.last.v_W, pass.change, vehicle_);
  const double turn = vehicle_.max_yaw_rate_radps;
  if (trusted && !(output.intervention != Intervention::None && pass.target == pass.brake))
    output.command.yaw_rate = std::clamp(input.wanted.yaw_rate, -turn, turn);
  pass.describe(wanted, distrust);
  return std::move(output);
}

}  // namespace slalom::safety
