// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/global_planner/GlobalPlanner.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "PlanningWindow.h"
#include "slalom/global_planner/GradientVectors.h"
#include "slalom/global_planner/OccupiedSegments.h"
#include "slalom/global_planner/PushingDirections.h"
#include "slalom/global_planner/RefinementCost.h"
#include "slalom/optim/BoxMinimizer.h"

namespace slalom::global_planner
{
namespace
{
using core::DistanceField;
using core::UnknownAs;
using spline::UniformBSpline;

constexpr double kMergeGap_s = 0.6;
constexpr double kAroundGoal_s = 1.0;

/// Parameter of the knot at which control point `index` has most influence (Greville abscissa) [s].
double influenceTime(const UniformBSpline& curve, Eigen::Index index)
{
  return curve.start() + curve.knotSpan() * static_cast<double>(index - 1);
}

/// Moves a point up the distance gradient until it keeps `clearance`, at most two metres.
Eigen::Vector3d escape(const DistanceField& field, Eigen::Vector3d p_L, double clearance)
{
  for (int i = 0; i < 10; ++i)
  {
    const auto here = field.sample(p_L, UnknownAs::Free);
    if (!here || here->distance >= clearance || here->gradient.norm() < 1e-3) break;
    p_L += here->gradient.normalized() * std::min(0.2, clearance - here->distance + 1e-3);
  }
  return p_L;
}

double polylineLength(const Eigen::Matrix3Xd& line)
{
  if (line.cols() < 2) return 0.0;
  return (line.rightCols(line.cols() - 1) - line.leftCols(line.cols() - 1)).colwise().norm().sum();
}

GlobalPlannerConfig inLocalFrame(GlobalPlannerConfig config, double altitude_offset)
{
  config.min_altitude_m += altitude_offset;
  config.max_altitude_m += altitude_offset;
  return config;
}

/// One step's working set; the step itself is the list of its member calls in
/// GlobalPlanner::step().
class Refinement
{
 public:
  Refinement(const GlobalPlannerConfig& config, const core::Vehicle& vehicle,
             const GlobalPlannerInput& input)
      : config_(inLocalFrame(config, input.altitude_offset)),
        vehicle_(vehicle),
        in_(input),
        field_(*input.field),
        r_(*input.reference),
        // Surfaces are known to half a voxel's edge, corners of voxels reach a little farther.
        hard_(vehicle.radius_m + 0.4 * input.field->resolution()),
        curve_(usablePrevious() ? in_.previous->spline : r_),
        window_(choosePlanningWindow(r_, in_.progress, config_.horizon_m, field_, 1.05 * hard_))
  {
  }

  GlobalPlannerOutput run();

 private:
  [[nodiscard]] bool usablePrevious() const;
  [[nodiscard]] Eigen::Matrix3Xd startPoints();
  [[nodiscard]] bool restartsHere(const Eigen::Vector3d& off) const;
  [[nodiscard]] Eigen::VectorXd fitWeights() const;
  [[nodiscard]] PushingPath pushingPath(const UniformBSpline& curve,
                                        OccupiedSegment& segment) const;
  bool pushOut(Eigen::Matrix3Xd& points, std::vector<Push>& pushes);
  void pushSegment(const OccupiedSegment& segment, const PushingPath& path,
                   Eigen::Matrix3Xd& points, std::vector<Push>& pushes);
  void keepClear(const Eigen::Matrix3Xd& points, std::vector<Push>& pushes) const;
  [[nodiscard]] Eigen::Matrix3Xd minimise(Eigen::Matrix3Xd points, std::vector<Push> pushes,
                                          double gain);
  [[nodiscard]] UniformBSpline curveWith(const Eigen::Matrix3Xd& points) const;
  [[nodiscard]] std::vector<OccupiedSegment> occupied(const UniformBSpline& curve,
                                                      double clearance) const;
  [[nodiscard]] bool atEndOfReference() const
  {
    return window_.goal_blocked || window_.to >= r_.end();
  }
  [[nodiscard]] GlobalPlannerOutput commit(RefineOutcome outcome, const UniformBSpline& curve);
  [[nodiscard]] GlobalPlannerOutput keep(RefineOutcome outcome);

  const GlobalPlannerConfig config_;
  const core::Vehicle& vehicle_;
  const GlobalPlannerInput& in_;
  const DistanceField& field_;
  const UniformBSpline& r_;
  const double hard_;
  UniformBSpline curve_;
  const PlanningWindow window_;
  bool recovered_ = false;
  double stretch_ =
      1.0;  // a detour may ask for this much more than the limits: the clock slows down there
  core::RefinementRecord record_;
};

bool Refinement::usablePrevious() const
{
  return in_.previous && in_.previous->spline.size() == in_.reference->size() &&
         in_.previous->spline.knotSpan() == in_.reference->knotSpan();
}

Eigen::Matrix3Xd Refinement::startPoints()
{
  Eigen::Matrix3Xd points = curve_.controlPoints().middleCols(window_.first, window_.count);
  const auto reference = r_.controlPoints().middleCols(window_.first, window_.count);
  const Eigen::Index free = window_.lastFree() - window_.firstFree() + 1;

  const bool reference_is_clear =
      findOccupiedSegments(r_, window_.from, window_.to, field_, config_.clearance_m, kMergeGap_s)
          .empty();
  if (reference_is_clear && free > 0)
    points.middleCols(kFixedAtStart, free) = reference.middleCols(kFixedAtStart, free);
  points.rightCols(std::min(kFixedAtEnd, window_.count)) =
      reference.rightCols(std::min(kFixedAtEnd, window_.count));

  if (const Eigen::Vector3d off = in_.state.p_L - curve_.position(window_.from);
      restartsHere(off) && free > 0)
  {
    const Eigen::Vector3d step = in_.state.v_W * r_.knotSpan();
    for (Eigen::Index i = 0; i < kFixedAtStart; ++i)
      points.col(i) = in_.state.p_L + step * static_cast<double>(i - 1);
    constexpr double kBlend = 12.0;
    for (Eigen::Index i = kFixedAtStart; i <= window_.lastFree(); ++i)
      points.col(i) += off * std::max(0.0, 1.0 - static_cast<double>(i - 3) / kBlend);
  }
  return points;
}

/// A vehicle that is far from its plan (open-loop replay, a gust), or that stands at the end of
/// what was clear in it, starts a new one where it is.
bool Refinement::restartsHere(const Eigen::Vector3d& off) const
{
  constexpr double kStanding_mps = 0.15;
  const bool stands_before_blockage = in_.previous && in_.state.v_W.norm() < kStanding_mps &&
                                      in_.previous->stop_at < r_.end() &&
                                      in_.previous->stop_at - window_.from < 2.0 * r_.knotSpan();
  return off.norm() > config_.restart_distance_m || stands_before_blockage;
}

Eigen::VectorXd Refinement::fitWeights() const
{
  // Where R itself is too near to obstacles, leaving it is the purpose: no pull back there, nor one
  // metre around.
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(window_.count);
  constexpr double kAround_s = 1.0;
  for (const OccupiedSegment& s :
       findOccupiedSegments(r_, window_.from, window_.to, field_, config_.clearance_m, kMergeGap_s))
    for (Eigen::Index i = 0; i < window_.count; ++i)
    {
      const double t = influenceTime(r_, window_.first + i);
      if (t > s.from - kAround_s && t < s.to + kAround_s) weights[i] = 0.0;
    }
  return weights;
}

UniformBSpline Refinement::curveWith(const Eigen::Matrix3Xd& points) const
{
  Eigen::Matrix3Xd all = curve_.controlPoints();
  all.middleCols(window_.first, window_.count) = points;
  const Eigen::Index behind = window_.first + window_.count;
  all.rightCols(all.cols() - behind) = r_.controlPoints().rightCols(all.cols() - behind);
  return curve_.withControlPoints(std::move(all));
}

std::vector<OccupiedSegment> Refinement::occupied(const UniformBSpline& curve,
                                                  double clearance) const
{
  // The span under the vehicle cannot be changed any more, the next three only in part: what was
  // accepted there once is not refused because a voxel grew by a hand's breadth.
  const auto knot = [&](Eigen::Index i)
  {
    return std::min(window_.to,
                    curve.start() + curve.knotSpan() * static_cast<double>(window_.first + i));
  };
  const double committed = std::min(clearance, vehicle_.radius_m + 0.1 * field_.resolution());
  std::vector<OccupiedSegment> segments =
      findOccupiedSegments(curve, knot(1), knot(kFixedAtStart), field_, committed, kMergeGap_s);
  for (const OccupiedSegment& segment :
       findOccupiedSegments(curve, knot(kFixedAtStart), window_.to, field_, clearance, kMergeGap_s))
  {
    if (!segments.empty() && segment.from - segments.back().to < kMergeGap_s)
      segments.back().to = segment.to, segments.back().open_end = segment.open_end;
    else
      segments.push_back(segment);
  }
  return segments;
}

/// S_* of one segment. Where the way around is long, the segment is widened into free stretches of
/// the curve, so that the detour has as many control points as its length needs.
PushingPath Refinement::pushingPath(const UniformBSpline& curve, OccupiedSegment& segment) const
{
  constexpr double kCrowded = 1.5;  // the clock slows down where a detour is crowded, up to here
  constexpr int kWidenings = 2;
  for (int widening = 0;; ++widening)
  {
    const auto count = static_cast<Eigen::Index>(
        std::clamp(std::ceil((segment.to - segment.from) / curve.knotSpan()) + 2.0, 5.0, 80.0));
    const Eigen::Vector3d start = escape(field_, curve.position(segment.from), 1.05 * hard_);
    const Eigen::Vector3d goal = escape(field_, curve.position(segment.to), 1.05 * hard_);
    PushingPath path = findPushingPath(field_, start, goal, count, hard_, config_);
    const double needed = polylineLength(path.guide) / vehicle_.max_speed_mps;
    if (!path.found || widening == kWidenings || segment.to >= window_.to ||
        needed <= kCrowded * (segment.to - segment.from))
      return path;
    segment.to = std::min(window_.to, segment.from + needed);
    while (segment.to < window_.to &&
           optimisticDistance(field_, curve.position(segment.to)) < 1.05 * hard_)
      segment.to = std::min(window_.to, segment.to + curve.knotSpan());
  }
}

bool Refinement::pushOut(Eigen::Matrix3Xd& points, std::vector<Push>& pushes)
{
  const UniformBSpline curve = curveWith(points);
  const std::vector<OccupiedSegment> segments = occupied(curve, hard_);
  if (segments.empty()) return true;
  record_ = {};  // explains the last push, not the sum of all attempts
  double done_until = window_.from;
  for (OccupiedSegment segment : segments)
  {
    if (segment.to <= done_until) continue;
    record_.occupied_segments.push_back(curve.sample(
        segment.from, segment.to,
        std::max<Eigen::Index>(2, Eigen::Index(curve.length(segment.from, segment.to) / 0.1))));
    segment.from = std::max(segment.from, done_until);
    const PushingPath path = pushingPath(curve, segment);
    done_until = segment.to;
    if (path.guide.cols() > 0) record_.guides.push_back(path.guide);
    if (!path.found)
    {
      record_.outcome = path.reason;
      return false;
    }
    recovered_ = recovered_ || path.recovered;
    record_.pushing_paths.push_back(path.path);
    record_.polyhedra.insert(record_.polyhedra.end(), path.polyhedra.begin(), path.polyhedra.end());
    pushSegment(segment, path, points, pushes);
  }
  return true;
}

void Refinement::pushSegment(const OccupiedSegment& segment, const PushingPath& path,
                             Eigen::Matrix3Xd& points, std::vector<Push>& pushes)
{
  const Eigen::Matrix3Xd before = points;
  const double duration = segment.to - segment.from;
  const double detour = polylineLength(path.path);
  stretch_ = std::max(stretch_, 1.2 * detour / (duration * vehicle_.max_speed_mps));
  for (Eigen::Index i = window_.firstFree(); i <= window_.lastFree(); ++i)
  {
    const double share = (influenceTime(r_, window_.first + i) - segment.from) / duration;
    if (share < 0.0 || share > 1.0) continue;
    const double at = share * static_cast<double>(path.path.cols() - 1);
    const auto k = std::min<Eigen::Index>(static_cast<Eigen::Index>(at), path.path.cols() - 2);
    const double u = at - static_cast<double>(k);
    const Eigen::Vector3d even = (1.0 - u) * path.path.col(k) + u * path.path.col(k + 1);
    const Eigen::Vector3d target =
        crossing(before.col(i - 1), before.col(i), before.col(i + 1), path.path).value_or(even);
    const Eigen::Vector3d pull = target - before.col(i);
    points.col(i) = even;
    if (pull.norm() < 1e-5) continue;
    // S_* already keeps D_z where the gap permits, so the pull ends on it: its anchor lies D_z
    // behind (D-05).
    const Eigen::Vector3d direction = pull.normalized();
    pushes.push_back({i, target - config_.clearance_m * direction, direction});
    record_.directions.push_back({before.col(i), target});
  }
}

void Refinement::keepClear(const Eigen::Matrix3Xd& points, std::vector<Push>& pushes) const
{
  for (Eigen::Index i = window_.firstFree(); i <= window_.lastFree(); ++i)
  {
    const Eigen::Vector3d p = points.col(i);
    const auto here = field_.sample(p, UnknownAs::Free);
    if (!here || here->distance >= 1.5 * config_.clearance_m) continue;
    const double steepness = here->gradient.norm();
    if (steepness < 0.2) continue;  // on a ridge between two obstacles there is no side to prefer
    const Eigen::Vector3d normal = here->gradient / steepness;
    pushes.push_back({i, p - here->distance * normal, normal});
  }
}

Eigen::Matrix3Xd Refinement::minimise(Eigen::Matrix3Xd points, std::vector<Push> pushes,
                                      double gain)
{
  RefinementCost::Problem problem;
  problem.points = std::move(points);
  problem.reference = r_.controlPoints().middleCols(window_.first, window_.count);
  problem.fit_weight = fitWeights();
  problem.first_free = window_.firstFree();
  problem.last_free = window_.lastFree();
  problem.knot_span = r_.knotSpan();
  problem.pushes = std::move(pushes);
  problem.obstacle_gain = gain;

  const Eigen::Index free = problem.last_free - problem.first_free + 1;
  Eigen::Matrix3Xd lower =
      problem.reference.middleCols(problem.first_free, free).array() - config_.max_offset_m;
  Eigen::Matrix3Xd upper =
      problem.reference.middleCols(problem.first_free, free).array() + config_.max_offset_m;
  const auto altitude = problem.reference.row(2).middleCols(problem.first_free, free).array();
  lower.row(2) = (altitude - config_.max_climb_m).max(lower.row(2).array());
  upper.row(2) = (altitude + config_.max_climb_m).min(upper.row(2).array());
  lower.row(2) = lower.row(2).cwiseMax(config_.min_altitude_m).cwiseMin(config_.max_altitude_m);
  upper.row(2) = upper.row(2).cwiseMin(config_.max_altitude_m).cwiseMax(config_.min_altitude_m);

  core::Vehicle stretched = vehicle_;
  stretched.max_speed_mps *= stretch_;
  stretched.max_acceleration_mps2 *= stretch_ * stretch_;
  RefinementCost cost(std::move(problem), config_, stretched);
  optim::BoxMinimizerConfig solver;
  solver.method = config_.optimizer;
  solver.max_evaluations = config_.max_evaluations;
  const optim::BoxMinimum minimum = optim::minimizeInBox(
      cost, cost.start(), lower.reshaped(), upper.reshaped(), solver, in_.deadline);
  record_.solve = minimum.report;
  return cost.points(minimum.x);
}

GlobalPlannerOutput Refinement::commit(RefineOutcome outcome, const UniformBSpline& curve)
{
  RefinedReference refined{curve};
  refined.clear_until = window_.to;
  refined.stop_at = window_.to;  // nothing beyond was looked at
  refined.sequence = in_.previous ? in_.previous->sequence + 1 : 1;
  refined.map_sequence = field_.sequence();
  record_.min_clearance_m = minClearance(curve, window_.from, window_.to, field_);
  record_.ran = true;
  record_.outcome = toString(outcome);
  return {outcome, std::make_shared<const RefinedReference>(std::move(refined)),
          std::move(record_)};
}

GlobalPlannerOutput Refinement::keep(RefineOutcome outcome)
{
  // The previous plan stays, but nobody may follow it into what is known to block it.
  RefinedReference kept{curve_};
  const auto blocked = findOccupiedSegments(curve_, window_.from, window_.to, field_, hard_, 0.0);
  kept.clear_until = blocked.empty() ? window_.to : blocked.front().from;
  kept.stop_at = kept.clear_until;
  kept.sequence = in_.previous ? in_.previous->sequence + 1 : 1;
  kept.map_sequence = field_.sequence();
  record_.min_clearance_m = minClearance(curve_, window_.from, window_.to, field_);
  record_.ran = true;
  const std::string detail = record_.outcome;
  record_.outcome = std::string(toString(outcome)) + (detail.empty() ? "" : " (" + detail + ")");
  return {outcome, std::make_shared<const RefinedReference>(std::move(kept)), std::move(record_)};
}

GlobalPlannerOutput Refinement::run()
{
  if (window_.to <= window_.from && window_.from < r_.end() && !window_.blocked_end)
  {
    record_.outcome = "reference outside the map";
    return keep(RefineOutcome::StillOccupied);
  }
  if (!window_.hasFreePoints())
  {
    const bool blocked = window_.blocked_end || !occupied(curve_, hard_).empty();
    return keep(!blocked             ? RefineOutcome::Clear
                : atEndOfReference() ? RefineOutcome::GoalBlocked
                                     : RefineOutcome::StillOccupied);
  }

  // A result is accepted at the hard clearance, but one with half a voxel to spare is tried for:
  // the next map will differ.
  const double comfortable = hard_ + 0.5 * field_.resolution();
  Eigen::Matrix3Xd points = startPoints();
  std::optional<UniformBSpline> accepted;
  bool blocks_goal = false;  // what could not be cleared lies around the very end of R
  double gain = 1.0;
  for (int attempt = 0; attempt < config_.max_attempts; ++attempt, gain *= 2.0)
  {
    std::vector<Push>
        pushes;  // seeded anew at every attempt: anchors belong to the points they were made for
    if (!pushOut(points, pushes)) break;
    keepClear(points, pushes);
    points = minimise(std::move(points), std::move(pushes), gain);
    const UniformBSpline curve = curveWith(points);
    const std::vector<OccupiedSegment> left = occupied(curve, hard_);
    blocks_goal = !left.empty() && left.back().to >= r_.end() - kAroundGoal_s;
    if (!left.empty()) continue;
    accepted = curve;
    if (occupied(curve, comfortable).empty()) break;
  }
  if (accepted)
    return commit(window_.goal_blocked                ? RefineOutcome::GoalBlocked
                  : recovered_                        ? RefineOutcome::Recovered
                  : record_.occupied_segments.empty() ? RefineOutcome::Clear
                                                      : RefineOutcome::Refined,
                  *accepted);
  if (!record_.outcome.empty())
    return keep(atEndOfReference() && record_.outcome != "guide: start blocked"
                    ? RefineOutcome::GoalBlocked
                    : RefineOutcome::GuideFailed);
  return keep(blocks_goal ? RefineOutcome::GoalBlocked : RefineOutcome::StillOccupied);
}

}  // namespace

std::string_view toString(RefineOutcome outcome)
{
  switch (outcome)
  {
    case RefineOutcome::Clear:
      return "Clear";
    case RefineOutcome::Refined:
      return "Refined";
    case RefineOutcome::Recovered:
      return "Recovered";
    case RefineOutcome::GuideFailed:
      return "GuideFailed";
    case RefineOutcome::StillOccupied:
      return "StillOccupied";
    case RefineOutcome::GoalBlocked:
      return "GoalBlocked";
    case RefineOutcome::NoField:
      return "NoField";
  }
  return "?";
}

GlobalPlanner::GlobalPlanner(const GlobalPlannerConfig& config, const core::Vehicle& vehicle)
    : config_(config), vehicle_(vehicle)
{
  if (config.clearance_m <= vehicle.radius_m)
    throw std::invalid_argument(
        "global_planner.clearance_m = " + std::to_string(config.clearance_m) +
        " must exceed vehicle.radius_m = " + std::to_string(vehicle.radius_m));
  if (config.min_altitude_m >= config.max_altitude_m)
    throw std::invalid_argument(
        "global_planner.min_altitude_m = " + std::to_string(config.min_altitude_m) +
        " must be below max_altitude_m = " + std::to_string(config.max_altitude_m));
}

GlobalPlannerOutput GlobalPlanner::step(const GlobalPlannerInput& input) const
{
  if (!input.field)
  {
    GlobalPlannerOutput output;
    output.refined = input.previous;
    if (!output.refined)
    {
      RefinedReference as_given{*input.reference};
      as_given.clear_until = as_given.stop_at =
          input.reference->start();  // nothing is known to be clear
      output.refined = std::make_shared<const RefinedReference>(std::move(as_given));
    }
    output.record.ran = true;
    output.record.outcome = toString(RefineOutcome::NoField);
    return output;
  }
  return Refinement(config_, vehicle_, input).run();
}

}  // namespace slalom::global_planner
