// SPDX-License-Identifier: BSD-3-Clause
#include "PlanStep.h"

#include <algorithm>
#include <cmath>

#include "slalom/global_planner/Guides.h"

namespace slalom::global_planner
{
using core::UnknownAs;
using spline::UniformBSpline;

namespace
{
constexpr int kGuides = 3;  // topologically distinct ways that are compared

/// How readily a plan that is away from R gives way to a fresh one.
struct Challenge
{
  int every;       // plans
  double cheaper;  // it must cost less than this share of the present one
};
constexpr Challenge kSoon{5, 0.9}, kLate{2, 0.95};

constexpr double kStanding_mps = 0.15;
constexpr double kHarder = 0.01;  // braking by this much more than planned with goes unnoticed
constexpr double kAltitudeAhead_s = 15.0;

bool returnsLate(ReturnPolicy policy, bool only_goal)
{
  return policy == ReturnPolicy::Late || (policy == ReturnPolicy::Auto && only_goal);
}

/// Altitude limits in the local frame, and not farther from those of R ahead than it may leave
/// them.
GlobalPlannerConfig inLocalFrame(GlobalPlannerConfig config, const GlobalPlannerInput& input)
{
  const UniformBSpline& r = *input.reference;
  const double at = input.previous ? input.previous->referenceTime(input.progress) : input.progress;
  const Eigen::Index first = r.spanAt(at);
  const Eigen::Index last = std::min(r.size() - 1, r.spanAt(at + kAltitudeAhead_s) + 3);
  const auto z = r.controlPoints().row(2).segment(first, last - first + 1);
  config.min_altitude_m =
      std::max(config.min_altitude_m + input.altitude_offset, z.minCoeff() - config.max_climb_m);
  config.max_altitude_m =
      std::min(config.max_altitude_m + input.altitude_offset, z.maxCoeff() + config.max_climb_m);
  return config;
}

}  // namespace

PlanStep::PlanStep(const GlobalPlannerConfig& config, const core::Vehicle& vehicle,
                   const GlobalPlannerInput& input)
    : in_(input),
      config_(inLocalFrame(config, input)),
      vehicle_(vehicle),
      field_(*input.field),
      r_(*input.reference),
      previous_(input.previous && input.previous->spline.knotSpan() == r_.knotSpan()
                    ? input.previous.get()
                    : nullptr),
      rho_(previous_ ? previous_->referenceTime(input.progress) : input.progress),
      context_{config_,
               vehicle,
               field_,
               r_,
               {},
               {},
               input.progress,
               returnsLate(config.return_to_reference, input.only_goal),
               0.0,
               0.0,
               input.deadline}
{
  keepMargin(config_.margin_m);
  restart_ = mustRestart();
  if (restart_) rho_ = joinTime();
  context_.window = chooseWindow(r_, rho_, config_.horizon_m, field_, 1.05 * context_.hard);
  context_.reference_occupied = findOccupiedSegments(r_, context_.window.from, context_.window.to,
                                                     field_, config_.clearance_m, 0.6);
  classifyGoal();
}

/// Guides and polyhedra keep the margin too, and the little that voxels' corners reach beyond the
/// half edge to which surfaces are known.
void PlanStep::keepMargin(double margin_m)
{
  context_.margin = margin_m;
  context_.hard = vehicle_.radius_m + margin_m + 0.2 * field_.resolution();
}

/// A vehicle that is far from its plan (open-loop replay, a gust), or that stands at the end of
/// what was clear in it, starts a new one where it is.
bool PlanStep::mustRestart() const
{
  const UniformBSpline& curve = previous_ ? previous_->spline : r_;
  // A vehicle that is late is not off its plan: what counts is the way to the plan's course.
  constexpr double kLate_s = 1.0;
  const double nearest =
      curve.project(in_.state.p_L, std::max(curve.start(), in_.progress - kLate_s),
                    std::min(curve.end(), in_.progress + kLate_s));
  if ((in_.state.p_L - curve.position(nearest)).norm() > config_.restart_distance_m) return true;
  if (!previous_ || in_.state.v_W.norm() > kStanding_mps) return false;
  // One that stands apart from where its plan has come to does not get there by waiting.
  const double apart = (in_.state.p_L - curve.position(in_.progress)).norm();
  if (apart > 0.5 * config_.restart_distance_m) return true;
  const bool before_end = previous_->stop_at < curve.end() || previous_->end == PlanEnd::Braking ||
                          (previous_->end == PlanEnd::OnReference &&
                           previous_->referenceTime(curve.end()) < r_.end() - r_.knotSpan());
  return before_end && previous_->stop_at - in_.progress < 2.0 * r_.knotSpan();
}

/// The plan only leads to a rest on the way, and the vehicle is there: only another plan leads on.
bool PlanStep::endsHere() const
{
  constexpr double kAtEnd_s = 1.0;
  if (!previous_ || previous_->end == PlanEnd::OnReference || previous_->end == PlanEnd::NearGoal)
    return false;
  return previous_->end == PlanEnd::Braking || in_.progress > previous_->spline.end() - kAtEnd_s;
}

/// Where on R a vehicle that lost its plan goes on: near where it was, unless it was taken along
/// another way altogether.
double PlanStep::joinTime() const
{
  constexpr double kBack_s = 1.0, kAhead_s = 6.0, kLost_m = 4.0;
  const double back = std::max(r_.start(), rho_ - kBack_s);
  const auto off = [&](double t) { return (r_.position(t) - in_.state.p_L).norm(); };
  const double near = r_.project(in_.state.p_L, back, std::min(r_.end(), rho_ + kAhead_s));
  if (off(near) < kLost_m) return std::max(near, rho_ - kBack_s);
  const double far = r_.project(in_.state.p_L, back, r_.end());
  return off(far) < 0.5 * off(near) ? far : near;
}

/// The columns that are given: those under the vehicle, and whatever the plan has behind them.
Draft PlanStep::begin() const
{
  if (restart_) return draftAtVehicle(in_.state, in_.progress, rho_, r_.knotSpan());
  return previous_ ? draftOfPlan(*previous_, in_.progress, r_, context_.window)
                   : draftOfReference(r_, in_.progress, context_.window);
}

void PlanStep::classifyGoal()
{
  const Eigen::Vector3d goal = r_.position(r_.end());
  goal_.nearest_L = goal;
  if (!field_.bounds().contains(goal))
    goal_.state = GoalState::NotSeen;
  else if (optimisticDistance(field_, goal) < context_.hard)
    goal_.state = GoalState::Occupied;
  else
    goal_.state =
        field_.occupancy(goal) == core::Occupancy::Unknown ? GoalState::Unknown : GoalState::Free;
}

/** Leads a draft around everything. The guide around its first obstacle is the cheapest there is;
 * other ways are searched and compared only when that one does not lead to a plan. */
PlanStep::Attempt PlanStep::attempt(Draft draft, const std::vector<Bypass>& bypasses) const
{
  Attempt result;
  result.draft = std::move(draft);
  result.led_around = !bypasses.empty();
  std::vector<Eigen::Matrix3Xd> guides;
  for (const Bypass& bypass : bypasses)
  {
    GuideSearch search =
        searchGuides(field_, bypass.from_L, bypass.to_L, context_.hard, 1, config_);
    if (search.guides.empty())
    {
      result.reason = search.reason;
      result.unreachable = search.unreachable;
      result.blocked = bypass;
      result.nearest_L = search.nearest_L;
      return result;
    }
    guides.push_back(std::move(search.guides.front()));
  }
  tryWay(result, bypasses, guides, "way 1");
  if (result.best || bypasses.empty()) return result;
  const Bypass& first = bypasses.front();
  const std::vector<Eigen::Matrix3Xd> ways =
      searchGuides(field_, first.from_L, first.to_L, context_.hard, kGuides, config_).guides;
  for (std::size_t k = 1; k < ways.size(); ++k)
  {
    guides.front() = ways[k];
    tryWay(result, bypasses, guides,
           "way " + std::to_string(k + 1) + "/" + std::to_string(ways.size()));
  }
  return result;
}

/// Refines along given guides; the cheapest that is proved becomes the attempt's best.
void PlanStep::tryWay(Attempt& attempt, const std::vector<Bypass>& bypasses,
                      const std::vector<Eigen::Matrix3Xd>& guides, const std::string& name) const
{
  Refinement refinement = refine(context_, attempt.draft, bypasses, guides);
  if (!refinement.accepted)
  {
    if (!attempt.best) attempt.reason = refinement.failure;
    attempt.failed = std::move(refinement.record);
    return;
  }
  if (attempt.best && refinement.travel_cost >= attempt.best->travel_cost) return;
  attempt.best = std::move(refinement);
  attempt.reason =
      bypasses.empty() ? "nothing in the way" : name + " around " + std::to_string(bypasses.size());
}

PlanStep::Attempt PlanStep::followPlan() const
{
  Draft draft = begin();
  const std::vector<Bypass> bypasses = bypassesOf(draft, context_);
  return attempt(std::move(draft), bypasses);
}

/// From the columns that are given straight back to R where it is free again, or to the window's
/// end.
PlanStep::Attempt PlanStep::returnToReference(const Draft& from) const
{
  const double lag = (from.points.col(from.fixed - 1) - r_.position(rho_)).norm();
  const double lead = std::max(5.0 * r_.knotSpan(), lag / vehicle_.max_speed_mps);
  const auto indexAt = [&](double t)
  { return static_cast<Eigen::Index>(std::ceil((t - r_.start()) / r_.knotSpan() + 1.0)); };
  const Eigen::Index last = context_.window.lastPoint() - 2;
  Eigen::Index join = context_.late_return ? last : std::min(indexAt(rho_ + lead), last);
  const auto free = [&](Eigen::Index k)
  {
    const double t = r_.start() + r_.knotSpan() * static_cast<double>(k - 1);
    return optimisticDistance(field_, r_.position(t)) >= 1.05 * context_.hard;
  };
  while (join < last && !free(join)) ++join;
  Draft draft = draftBackToReference(from, r_, join, context_.window);
  Bypass gap = joinOf(draft);
  std::vector<Bypass> bypasses = bypassesOf(draft, context_);
  std::erase_if(bypasses,
                [&](const Bypass& b)
                {
                  if (b.first > gap.last + 1) return false;
                  gap.last = std::max(gap.last, b.last);
                  return true;
                });
  gap.to_L = draft.points.col(gap.last);
  bypasses.insert(bypasses.begin(), gap);
  return attempt(std::move(draft), bypasses);
}

/// To the reachable point nearest to what cannot be reached, and rest there.
PlanStep::Attempt PlanStep::approach(const Attempt& failed, PlanEnd end) const
{
  Draft draft = failed.draft;
  Bypass way = failed.blocked ? *failed.blocked : Bypass{};
  Eigen::Vector3d rest = failed.nearest_L;
  if (!failed.blocked)
  {
    way.from_L = draft.points.col(draft.points.cols() - 1);
    const GuideSearch search =
        searchGuides(field_, way.from_L, r_.position(r_.end()), config_.clearance_m, 1, config_);
    rest = search.nearest_L;
    way.first = draft.points.cols();
  }
  // Around a goal inside a trunk every side is equally near: what is gained must be worth the way.
  constexpr double kWorthIt_m = 0.5;
  const Eigen::Vector3d goal = failed.blocked ? failed.blocked->to_L : r_.position(r_.end());
  const double gained = (way.from_L - goal).norm() - (rest - goal).norm();
  if (gained < kWorthIt_m || way.first < draft.fixed)
    return Attempt::none("as near as it can be", std::move(draft));
  draft.replace(way.first, draft.points.cols(), Eigen::Matrix3Xd(3, 0), Eigen::VectorXd());
  draft.restAt(rest, end);
  way.last = way.first;
  way.to_L = rest;
  std::vector<Bypass> bypasses = bypassesOf(draft, context_);
  std::erase_if(bypasses, [&](const Bypass& b) { return b.last + 1 >= way.first; });
  bypasses.push_back(way);
  return attempt(std::move(draft), bypasses);
}

/// Every few plans one that is away from R is compared with a fresh one.
bool PlanStep::isChallenged(const Refinement& plan) const
{
  if (!previous_ || !plan.draft.hasFreePoints()) return false;
  if (plan.draft.end == PlanEnd::NearReference) return true;
  if (plan.draft.end == PlanEnd::NearGoal && !context_.window.goal_blocked) return true;
  const Challenge& challenge = context_.late_return ? kLate : kSoon;
  if (previous_->sequence % challenge.every != 0) return false;
  const UniformBSpline curve = plan.draft.curve();
  const double straight = (curve.position(curve.end()) - curve.position(in_.progress)).norm();
  if (straight > challenge.cheaper * plan.travel_cost) return false;  // no way could win
  const Eigen::Matrix3Xd off = plan.draft.points - referencePoints(r_, plan.draft.along);
  return off.rightCols(off.cols() - plan.draft.fixed).colwise().norm().maxCoeff() > kAwayFromR_m;
}

/** Per span of the curve how fast it may be flown in view of what is left to the sides, since
 * tracking errors grow with speed. A vehicle that comes too fast brakes within its limits. */
std::vector<double> PlanStep::tightSpeeds(const UniformBSpline& curve, double from,
                                          double pace) const
{
  constexpr int kSamples = 4;
  std::vector<double> speeds(static_cast<std::size_t>(curve.spans()), vehicle_.max_speed_mps);
  const double now = pace * curve.velocity(from).cwiseAbs().maxCoeff();
  double braked = now * now;
  for (Eigen::Index span = curve.spanAt(from); span < curve.spans(); ++span)
  {
    const double t = curve.start() + curve.knotSpan() * static_cast<double>(span);
    const Eigen::Matrix3Xd line = curve.sample(t, t + curve.knotSpan(), kSamples);
    double left = field_.maxDistance();
    for (Eigen::Index k = 0; k < kSamples; ++k)
      left = std::min(left, optimisticDistance(field_, line.col(k)) - vehicle_.radius_m);
    const double allowed = config_.tight_speed_mps + std::max(0.0, left) / config_.reaction_s;
    // Half of what braking could take away, so that the law has room for the curve's bends.
    speeds[static_cast<std::size_t>(span)] = std::min(
        vehicle_.max_speed_mps, std::max(allowed, 1.01 * std::sqrt(std::max(0.0, braked))));
    braked -= vehicle_.max_acceleration_mps2 * (line.col(kSamples - 1) - line.col(0)).norm();
  }
  return speeds;
}

/// What can be promised for a curve: at rest before anything that is not known to be free.
RefinedReference PlanStep::promise(const UniformBSpline& curve, Eigen::VectorXd along,
                                   double clear_until) const
{
  const double from = std::clamp(in_.progress, curve.start(), curve.end());
  double stop_at = clear_until;
  if (config_.unknown == UnknownPolicy::Avoid)
    stop_at =
        certify(curve, from, clear_until, field_, UnknownAs::Occupied, vehicle_.radius_m).until;
  const double pace = restart_ ? 1.0 : in_.pace;
  RefinedReference promised{
      curve, std::move(along),
      spline::TimeLaw(curve, from, stop_at, pace,
                      {vehicle_.max_speed_mps, vehicle_.max_acceleration_mps2},
                      tightSpeeds(curve, from, pace))};
  promised.clear_until = clear_until;
  promised.stop_at = stop_at;
  promised.sequence = in_.previous ? in_.previous->sequence + 1 : 1;
  promised.map_sequence = field_.sequence();
  return promised;
}

/// Where the vehicle comes to rest if no better plan follows, as seen from the goal.
GoalReport PlanStep::goalFrom(const RefinedReference& plan) const
{
  GoalReport report = goal_;
  report.nearest_L = plan.spline.position(plan.stop_at);
  report.short_m = (report.nearest_L - r_.position(r_.end())).norm();
  return report;
}

GlobalPlannerOutput PlanStep::commit(const Attempt& attempt, RefineOutcome outcome)
{
  const Refinement& plan = *attempt.best;
  const UniformBSpline curve = plan.draft.curve();
  RefinedReference promised = promise(curve, plan.draft.along, curve.end());
  promised.end = plan.draft.end;
  core::RefinementRecord record = plan.record;
  record.certified = true;
  record.reason = attempt.reason;
  record.stop_excess = promised.law.excess();
  record.certificate_margin_m = plan.certificate.margin_m;
  record.ran = true;
  record.outcome = toString(outcome);
  const GoalReport goal = goalFrom(promised);
  return {outcome, goal, std::make_shared<const RefinedReference>(std::move(promised)),
          std::move(record)};
}

/// The previous plan stays, but nobody may follow it into what is known to block it.
GlobalPlannerOutput PlanStep::keep(Attempt failed, RefineOutcome outcome)
{
  Draft draft = begin();
  if (restart_)
    draft.restAt(in_.state.p_L +
                     in_.state.v_W * in_.state.v_W.norm() / (2.0 * vehicle_.max_acceleration_mps2),
                 PlanEnd::Braking);
  const bool unchanged = previous_ && !restart_;
  const UniformBSpline curve = unchanged ? previous_->spline : draft.curve();
  const Certificate certificate =
      certify(curve, std::clamp(in_.progress, curve.start(), curve.end()), curve.end(), field_,
              UnknownAs::Free, vehicle_.radius_m);
  RefinedReference kept =
      promise(curve, unchanged ? previous_->along : draft.along, certificate.until);
  kept.end = unchanged ? previous_->end : draft.end;
  core::RefinementRecord record = std::move(failed.failed);
  record.ran = true;
  record.reason = failed.reason;
  record.stop_excess = kept.law.excess();
  record.certificate_margin_m = certificate.margin_m;
  record.min_clearance_m = minClearance(curve, in_.progress, curve.end(), field_);
  record.outcome = toString(outcome);
  const GoalReport goal = goalFrom(kept);
  return {outcome, goal, std::make_shared<const RefinedReference>(std::move(kept)),
          std::move(record)};
}

/// The plan in force, led on; or a fresh one straight back to R, where that is better or all there
/// is.
PlanStep::Attempt PlanStep::leadOn() const
{
  const bool ends = restart_ || endsHere();
  Attempt plan = ends ? Attempt::none("starts anew", begin()) : followPlan();
  if (plan.best && !isChallenged(*plan.best)) return plan;
  Attempt fresh = returnToReference(plan.best ? plan.best->draft : begin());
  const double cheaper = (context_.late_return ? kLate : kSoon).cheaper;
  const bool better = fresh.best && (!plan.best || plan.best->draft.end != PlanEnd::OnReference ||
                                     fresh.best->travel_cost < cheaper * plan.best->travel_cost);
  if (!better && !ends) return plan;
  fresh.reason = (restart_ ? "from here: " : "back to R: ") + fresh.reason;
  return fresh;
}

/// Where the goal is blocked, or nothing leads back to R: as near as it can be.
void PlanStep::comeNear(Attempt& plan)
{
  const bool goal_blocked = context_.window.goal_blocked;
  const bool cut_off = context_.window.to >= r_.end() && !plan.best && plan.unreachable;
  if (cut_off) goal_.state = GoalState::Unreachable;
  holds_ = goal_blocked || cut_off;
  const bool holds_already = plan.best && plan.best->draft.end == PlanEnd::NearGoal;
  if (holds_already && !goal_blocked) goal_.state = GoalState::Unreachable;
  holds_ = holds_ || holds_already;
  if (holds_already || !(goal_blocked || (!plan.best && plan.blocked))) return;

  if (plan.best) plan.draft = plan.best->draft;
  Attempt nearer = approach(plan, holds_ ? PlanEnd::NearGoal : PlanEnd::NearReference);
  if (!nearer.best) return;
  plan = std::move(nearer);
  plan.reason = "as near as it can be: " + plan.reason;
}

GlobalPlannerOutput PlanStep::run()
{
  if (config_.goal_policy == GoalPolicy::Reject && goal_.state == GoalState::Occupied)
    return keep(Attempt::none("goal occupied: rejected", {}), RefineOutcome::GoalBlocked);
  Attempt plan = leadOn();
  comeNear(plan);
  // Where it stands with less than the margin around it, the way out need not keep it either.
  if (!plan.best && in_.state.v_W.norm() < kStanding_mps)
  {
    keepMargin(0.0);
    plan = leadOn();
    comeNear(plan);
  }
  if (!plan.best)
  {
    const RefineOutcome outcome = holds_         ? RefineOutcome::GoalBlocked
                                  : plan.blocked ? RefineOutcome::GuideFailed
                                                 : RefineOutcome::StillOccupied;
    return keep(std::move(plan), outcome);
  }
  GlobalPlannerOutput committed = commit(plan, holds_                 ? RefineOutcome::GoalBlocked
                                               : plan.best->recovered ? RefineOutcome::Recovered
                                               : plan.led_around      ? RefineOutcome::Refined
                                                                      : RefineOutcome::Clear);
  const double excess = committed.refined->law.excess();
  if (excess <= kHarder || !previous_ || restart_) return committed;
  // Nothing is gained by a plan that cannot be stopped in time if the present one can.
  plan.reason = "cannot stop in time: " + plan.reason;
  GlobalPlannerOutput kept = keep(std::move(plan), RefineOutcome::StillOccupied);
  return kept.refined->law.excess() < excess ? kept : committed;
}

}  // namespace slalom::global_planner
