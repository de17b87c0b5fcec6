// SPDX-License-Identifier: BSD-3-Clause
#include "StopCheck.h"

#include <algorithm>
#include <cmath>

#include "CommandLimits.h"

namespace slalom::safety::detail
{
namespace
{
constexpr double kShortestHold = 0.02, kLongestHold = 1.0;  // [s]
constexpr double kLongestLead = 1.0;                        // [s]
constexpr double kRounding = 1e-9;                          // [m]
constexpr int kMostBrakeSteps = 200, kMostFollowSteps = 400;

/// A simulated step must be short beside the braking time only where that is long.
double holdOf(const GateInput& input, const core::Vehicle& vehicle)
{
  const double shortest = std::max(
      kShortestHold, vehicle.max_speed_mps / (vehicle.max_acceleration_mps2 * kMostBrakeSteps));
  const double asked = std::max(std::isfinite(input.dt) ? input.dt : 0.0,
                                std::isfinite(input.hold_s) ? input.hold_s : 0.0);
  return std::clamp(asked, shortest, std::max(shortest, kLongestHold));
}

StopCheck::Flight beginOf(const GateInput& input, const core::Vehicle& vehicle,
                          const Eigen::Vector3d& last)
{
  const double from = input.state.t - input.t;
  const double lead = std::clamp(vehicle.command_delay_s - from, 0.0, kLongestLead);
  const core::Motion now{input.state.p_L, input.state.v_W};
  const core::Motion then = core::held(now, {last, 0.0}, lead, vehicle);
  return {then.p, then.v, last, from + lead};
}

bool wellFormed(const StopPath* plan)
{
  return plan && plan->p_L.size() >= 2 && plan->v_L.size() == plan->p_L.size() &&
         plan->step_s >= 1e-3 && plan->step_s <= 10.0 && std::isfinite(plan->begins_s);
}

/// From now [s].
double endOf(const StopPath& plan)
{
  return plan.begins_s + static_cast<double>(plan.p_L.size() - 1) * plan.step_s;
}

Eigen::Vector3d at(const std::vector<Eigen::Vector3d>& values, double index)
{
  const double last = static_cast<double>(values.size() - 1);
  if (!(index < last)) return values.back();
  const auto i = static_cast<std::size_t>(std::max(index, 0.0));
  const double t = std::max(index, 0.0) - static_cast<double>(i);
  return (1.0 - t) * values[i] + t * values[i + 1];
}
}  // namespace

StopCheck::StopCheck(const GateInput& input, const SafetyConfig& config,
                     const core::Vehicle& vehicle, const Eigen::Vector3d& last,
                     const core::DistanceField* field)
    : input_(input),
      vehicle_(vehicle),
      lag_reserve_s_(config.lag_reserve_s),
      graze_m_(config.graze_m),
      evasion_margin_m_(config.evasion_margin_m),
      hold_s_(holdOf(input, vehicle)),
      change_(vehicle.max_acceleration_mps2 * std::min(hold_s_, kLongestTick)),
      response_(core::VelocityResponse::over(hold_s_, vehicle.velocity_lag_s)),
      begin_(beginOf(input, vehicle, last)),
      surroundings_(input, config, vehicle, field, begin_.p, begin_.tau)
{
  if (!config.evade || !field) return;
  keepEvasion(config);
  const bool sees = input.map_age_s <= config.map_timeout_s;
  if (input.may_evade && sees && surroundings_.moversNear()) listEvasions(config);
}

/// Also when nothing moves any more: it may be the only way left that is clear of what stands.
void StopCheck::keepEvasion(const SafetyConfig& config)
{
  Evasion kept = input_.kept_evasion;
  kept.for_s -= std::isfinite(input_.dt) ? input_.dt : 0.0;
  keeps_ = kept.v_W.allFinite() && kept.for_s > 0.0 && kept.for_s <= config.mover_horizon_s;
  if (keeps_) evasions_[evasion_count_++] = kept;
}

/** Eight directions and three durations: sideways first, then on and away, towards the mover last,
 * since a body that turns is passed most safely by who leaves its way. */
void StopCheck::listEvasions(const SafetyConfig& config)
{
  constexpr double kQuarter = 1.5707963267948966;
  constexpr double kTurns[] = {0.0, 2.0, 0.5, 1.5, 1.0, -0.5, -1.5, -1.0};
  constexpr double kShares[] = {0.8, 0.5, 0.25};  // of the horizon
  const auto add = [this](const Evasion& evasion) { evasions_[evasion_count_++] = evasion; };
  const Eigen::Vector3d side = surroundings_.aside();
  for (const double share : kShares)
    for (const double turn : kTurns)
    {
      const double c = std::cos(turn * kQuarter), s = std::sin(turn * kQuarter);
      const Eigen::Vector3d way(c * side.x() - s * side.y(), s * side.x() + c * side.y(), 0.0);
      add({vehicle_.max_speed_mps / way.cwiseAbs().maxCoeff() * way,
           share * config.mover_horizon_s});
    }
}

bool StopCheck::Enough::of(const Sweep& sweep) const
{
  if (sweep.fixed >= allowed)
    return to_beat.stands_clear &&
           sweep.mover < (to_beat.safe() ? to_beat.mover : std::min(to_beat.mover, 0.0));
  return to_beat.stands_clear || std::min(sweep.fixed, sweep.mover) < to_beat.slack();
}

/* With v' = (u - v) / lag the velocity in a step is a mixture of the first and the last one whose
 * weights move one way only. So p = p0 + A v0 + B v1 with A, B growing to alpha, beta and B convex
 * in A: the way stays in the triangle p0, p0 + alpha v0, p0 + alpha v0 + beta v1 = p1. */
Piece StopCheck::fly(Flight& flight, const Eigen::Vector3d& command) const
{
  const core::VelocityResponse& r = response_;
  const double alpha = r.p_v - r.v_v * r.p_u / r.v_u;
  const Flight from = flight;
  flight.p = from.p + r.p_v * from.v + r.p_u * command;
  flight.v = r.v_v * from.v + r.v_u * command;
  flight.u = command;
  flight.tau += hold_s_;
  Piece piece;
  piece.hull.col(0) = from.p;
  piece.hull.col(1) = piece.hull.col(2) = from.p + alpha * from.v;
  piece.hull.col(3) = piece.end = flight.p;
  piece.tau = from.tau;
  piece.duration = hold_s_;
  piece.spread = (flight.v - from.v).norm();
  return piece;
}

/** Where a vehicle that lags more than assumed is, seen from where it should be: with the same
 * commands the way gone is the integral of the commands less lag * (velocity gained). Counts where
 * speed is shed; who gains speed late is only behind on the same way. */
Eigen::Vector3d StopCheck::lateness(const Eigen::Vector3d& from, const Eigen::Vector3d& v) const
{
  const Eigen::Vector3d shed = from - v;
  return lag_reserve_s_ * (shed.array() * from.array() > 0.0).select(shed, Eigen::Vector3d::Zero());
}

/// Whether a brake from here stays in the room that is known to be clear.
bool StopCheck::stopsInRoom(const Flight& flight, double late, Sweep& sweep) const
{
  const double room = surroundings_.room(flight.p, sweep);
  if (room < 0.0) return false;
  const Eigen::Vector3d reach =
      0.5 / deceleration() * flight.u.cwiseAbs2() + vehicle_.velocity_lag_s * flight.v.cwiseAbs();
  const double left = room - reach.norm() - late;
  if (left < 0.0) return false;
  sweep.lower(left, Cause::Map);
  return true;
}

void StopCheck::brakeToRest(Flight flight, const Eigen::Vector3d& from, const Enough& enough,
                            Sweep& sweep) const
{
  const double most_late =
      from.isZero(0.0) ? 0.0 : lag_reserve_s_ * (from.norm() + flight.v.norm() + flight.u.norm());
  while (!flight.u.isZero(0.0))
  {
    if (stopsInRoom(flight, most_late, sweep)) return;
    Piece piece = fly(flight, braked(flight.u, change_));
    piece.hull.col(3) += lateness(from, flight.v);
    piece.hull.col(2) = piece.end;
    surroundings_.pass(piece, sweep);
    if (enough.of(sweep)) return;
  }
  // From here on straight to where the lag lets it come to rest.
  Piece piece;
  piece.hull.col(0) = piece.hull.col(1) = flight.p;
  piece.hull.col(3) = piece.end = flight.p + vehicle_.velocity_lag_s * flight.v;
  piece.hull.col(2) = piece.end;
  piece.hull.col(3) += lateness(from, Eigen::Vector3d::Zero());
  surroundings_.passStanding(piece, sweep);
  if (!enough.of(sweep)) waitAtRest(flight, enough, sweep);
}

/** Who has braked is not yet safe from what moves: ways that end early would seem better than those
 * that leave, were they not looked at for as long. */
void StopCheck::waitAtRest(Flight flight, const Enough& enough, Sweep& sweep) const
{
  constexpr double kStill = 0.01;  // [m/s]
  constexpr int kPieces = 20;      // of the whole time
  const double until = surroundings_.moversUntil();
  // Counted, since absurd times do not advance.
  for (int step = 0; step < kMostFollowSteps && flight.tau < until && flight.v.norm() > kStill;
       ++step)
  {
    surroundings_.passMovers(fly(flight, flight.u), sweep);
    if (enough.of(sweep)) return;
  }
  Piece piece;
  piece.end = flight.p + vehicle_.velocity_lag_s * flight.v;
  piece.hull.colwise() = piece.end;
  piece.hull.col(0) = flight.p;
  piece.duration = std::max(hold_s_, (until - begin_.tau) / kPieces);
  piece.spread = flight.v.norm();
  piece.tau = flight.tau;
  for (int i = 0; i <= kPieces && piece.tau < until; ++i, piece.tau += piece.duration)
  {
    surroundings_.passMovers(piece, sweep);
    if (enough.of(sweep)) return;
    piece.hull.colwise() = piece.end;
    piece.spread = 0.0;
  }
  surroundings_.passBeyond(piece.end, sweep);
}

/// Feed-forward of the plan's velocity, what the lag takes of it, and a pull to the plan.
Eigen::Vector3d StopCheck::track(const StopPath& plan, const Flight& flight) const
{
  const double lag = vehicle_.velocity_lag_s, gain = lag > 0.2 ? 0.5 / lag : 2.5;
  const double now = (flight.tau - plan.begins_s) / plan.step_s, ahead = hold_s_ / plan.step_s;
  const Eigen::Vector3d before = at(plan.v_L, now), after = at(plan.v_L, now + ahead);
  const Eigen::Vector3d u = 0.5 * (before + after) + lag / hold_s_ * (after - before) +
                            gain * (at(plan.p_L, now) - flight.p);
  return limited(u, flight.u, change_, vehicle_);
}

Eigen::Vector3d StopCheck::follow(const StopPath& plan) const
{
  return wellFormed(&plan) ? track(plan, begin_) : begin_.u;
}

void StopCheck::followToRest(Flight flight, const StopPath& plan, const Piece& held,
                             const Enough& enough, Sweep& sweep) const
{
  Piece piece = held;
  const double end = endOf(plan);
  // Asked anew in every step, so that the next pass of the gate finds what this one relies on.
  const auto stopsHere = [&]
  {
    surroundings_.look(flight.p, sweep);
    return stopsInRoom(flight, 0.0, sweep);
  };
  for (int step = 0; step < kMostFollowSteps && flight.tau < end; ++step)
  {
    if (stopsHere()) return surroundings_.pass(piece, sweep);
    // Two steps share one hull: the end of the first lies between their middle points.
    const Piece next = fly(flight, track(plan, flight));
    piece.hull.col(2) = next.hull.col(1);
    piece.hull.col(3) = piece.end = next.end;
    piece.duration += next.duration;
    piece.spread += next.spread;
    surroundings_.pass(piece, sweep);
    if (enough.of(sweep) || stopsHere()) return;
    piece = fly(flight, track(plan, flight));
  }
  surroundings_.pass(piece, sweep);
  brakeToRest(flight, Eigen::Vector3d::Zero(), enough, sweep);
}

namespace
{
Eigen::Vector3d faster(const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
  return (b.array().abs() > a.array().abs()).select(b, a);
}
}  // namespace

/// The vehicle may lag here, too: speed is gained one way while it is shed another.
void StopCheck::evadeToRest(Flight flight, const Evasion& evasion, Eigen::Vector3d fastest,
                            const Enough& enough, Sweep& sweep) const
{
  const int steps =
      static_cast<int>(std::min(evasion.for_s / hold_s_ + 0.5, 1.0 * kMostFollowSteps));
  for (int step = 0; step < steps; ++step)
  {
    Piece piece = fly(flight, limited(evasion.v_W, flight.u, change_, vehicle_));
    fastest = faster(fastest, flight.v);
    piece.hull.col(3) += lateness(fastest, flight.v);
    piece.hull.col(2) = piece.end;
    surroundings_.pass(piece, sweep);
    if (enough.of(sweep)) return;
  }
  brakeToRest(flight, fastest, enough, sweep);
}

Verdict StopCheck::judge(const Eigen::Vector3d& command, const Evasion& evasion,
                         const Verdict& to_beat) const
{
  Flight held = begin_;
  Piece piece = fly(held, command);
  const Enough enough{to_beat, -kRounding};
  Sweep sweep;
  surroundings_.look(held.p, sweep);
  piece.hull.col(2) = piece.end;
  piece.hull.col(3) += lateness(begin_.v, held.v);
  surroundings_.pass(piece, sweep);
  if (!enough.of(sweep)) evadeToRest(held, evasion, faster(begin_.v, held.v), enough, sweep);
  const bool clear = sweep.fixed >= -kRounding, leaves = sweep.beyond >= 0.0;
  return {
      sweep.fixed, sweep.mover, sweep.cause, nullptr,
      evasion,     clear,       leaves,      clear && leaves && sweep.mover >= evasion_margin_m_};
}

Verdict StopCheck::brakeAfter(const Eigen::Vector3d& command, const Verdict& to_beat) const
{
  Flight held = begin_;
  Piece late = fly(held, command);
  const Enough enough{to_beat, -kRounding};
  Sweep sweep;
  surroundings_.look(held.p, sweep);
  late.hull.col(2) = late.end;
  late.hull.col(3) += lateness(begin_.v, held.v);
  surroundings_.pass(late, sweep);
  // The next pass will count from the speed that this command leads to.
  if (!enough.of(sweep)) brakeToRest(held, faster(begin_.v, held.v), enough, sweep);
  const bool clear = sweep.fixed >= -kRounding;
  return {sweep.fixed, sweep.mover, sweep.cause, nullptr,
          {},          clear,       true,        clear && sweep.mover >= -kRounding};
}

Verdict StopCheck::followAfter(const Eigen::Vector3d& command, const StopPath& plan,
                               const Verdict& to_beat) const
{
  Flight held = begin_;
  const Piece piece = fly(held, command);
  const double allowed = -kRounding - std::max(0.0, graze_m_ - surroundings_.excused());
  Sweep sweep;
  surroundings_.look(held.p, sweep);
  followToRest(held, plan, piece, {to_beat, allowed}, sweep);
  const bool clear = sweep.fixed >= allowed;
  return {sweep.fixed, sweep.mover, sweep.cause, &plan,
          {},          clear,       true,        clear && sweep.mover >= -kRounding};
}

Verdict StopCheck::judge(const Eigen::Vector3d& command, const Verdict& to_beat,
                         std::span<const Evasion> aside) const
{
  Verdict best = brakeAfter(command, to_beat);
  const auto better = [&best](const Verdict& other)
  {
    if (other.good || other.betterThan(best)) best = other;
    return best.good;
  };
  const auto bar = [&] { return best.betterThan(to_beat) ? best : to_beat; };
  bool walked_into = best.mover < -kRounding;
  for (const StopPath* plan : {input_.plan, input_.kept_plan})
    if (!best.good && wellFormed(plan))
    {
      const Verdict verdict = followAfter(command, *plan, bar());
      walked_into = walked_into || verdict.mover < -kRounding;
      better(verdict);
    }
  // What the last command may have counted on always, others only because of what moves.
  for (const Evasion& evasion : walked_into ? aside : keptEvasion())
    if (best.good || better(judge(command, evasion, bar()))) break;
  return best;
}

}  // namespace slalom::safety::detail
