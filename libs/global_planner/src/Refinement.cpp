// SPDX-License-Identifier: BSD-3-Clause
#include "Refinement.h"

#include <algorithm>
#include <cmath>

#include "slalom/global_planner/GradientVectors.h"
#include "slalom/global_planner/Guides.h"
#include "slalom/global_planner/PushingDirections.h"
#include "slalom/optim/BoxMinimizer.h"

namespace slalom::global_planner
{
namespace
{
using core::UnknownAs;
using spline::UniformBSpline;

constexpr double kMergeGap_s = 0.6;
constexpr double kTurnOff_m = 1.0;  // room before and behind an obstacle to turn off and back
constexpr double kFitAround_s = 1.0;
constexpr double kRidge = 0.2;     // a flatter distance has no side
constexpr double kStronger = 4.0;  // J_obs from attempt to attempt

double polylineLength(const Eigen::Matrix3Xd& line)
{
  if (line.cols() < 2) return 0.0;
  return (line.rightCols(line.cols() - 1) - line.leftCols(line.cols() - 1)).colwise().norm().sum();
}

/// Point at a share of a polyline's columns, in [0, 1].
Eigen::Vector3d pointAt(const Eigen::Matrix3Xd& line, double share)
{
  const double at = share * static_cast<double>(line.cols() - 1);
  const auto k = std::min<Eigen::Index>(static_cast<Eigen::Index>(at), line.cols() - 2);
  const double u = at - static_cast<double>(k);
  return (1.0 - u) * line.col(k) + u * line.col(k + 1);
}

/// Control points that lead along S_*, which direction each is pushed in, and what they stand for.
struct PushedColumns
{
  Eigen::Matrix3Xd points;
  Eigen::VectorXd along;
  std::vector<std::optional<Eigen::Vector3d>> targets;
};

class Work
{
 public:
  Work(const StepContext& context, Draft draft) : c_(context) { result_.draft = std::move(draft); }

  Refinement run(std::vector<Bypass> bypasses, std::vector<Eigen::Matrix3Xd> guides);

 private:
  void push(const std::vector<Bypass>& bypasses, const std::vector<Eigen::Matrix3Xd>& guides);
  void lead(const Bypass& bypass, const PushingPath& path);
  [[nodiscard]] Eigen::Matrix3Xd before(const Bypass& bypass, Eigen::Index count) const;
  void keepClear();
  void pushOff(Eigen::Index column, const Eigen::Vector3d& p_L, const core::DistanceSample& sample);
  void pushOffOpposite(Eigen::Index column, const Eigen::Vector3d& p_L,
                       const Eigen::Vector3d& away);
  void minimise(double gain);
  [[nodiscard]] Eigen::VectorXd fitWeights() const;
  [[nodiscard]] Eigen::Matrix3Xd wantedBend(const Eigen::Matrix3Xd& reference,
                                            const Eigen::VectorXd& fit) const;
  [[nodiscard]] Certificate prove(const UniformBSpline& curve, double more) const;
  bool examine(std::optional<Refinement>& accepted);
  bool findGuides(const std::vector<Bypass>& bypasses, std::vector<Eigen::Matrix3Xd>& guides);
  [[nodiscard]] double travelCost(const UniformBSpline& curve) const;

  const StepContext& c_;
  Refinement result_;
  std::vector<Push> pushes_;  // anchors belong to the points they were made for: anew each attempt
};

/// Replaces the bypassed columns by as many as S_* is long, at the pace of full speed, but not
/// fewer than R has there.
void Work::lead(const Bypass& bypass, const PushingPath& path)
{
  Draft& draft = result_.draft;
  const double spacing = c_.vehicle.max_speed_mps * draft.knot_span;
  const double stands_from = draft.along[bypass.first - 1], stands_to = draft.along[bypass.last];
  const double on_r = (stands_to - stands_from) / draft.knot_span - 1.0;
  const double on_path = std::ceil(polylineLength(path.path) / spacing) - 1.0;
  const auto count = static_cast<Eigen::Index>(std::max({1.0, on_path, std::round(on_r)}));

  const Eigen::Matrix3Xd old = before(bypass, count);
  Eigen::Matrix3Xd points(3, count);
  Eigen::VectorXd along(count);
  for (Eigen::Index j = 0; j < count; ++j)
  {
    const double share = static_cast<double>(j + 1) / static_cast<double>(count + 1);
    points.col(j) = pointAt(path.path, share);
    along[j] = stands_from + share * (stands_to - stands_from);
    const Eigen::Vector3d target =
        crossing(old.col(j), old.col(j + 1), old.col(j + 2), path.path).value_or(points.col(j));
    const Eigen::Vector3d pull = target - old.col(j + 1);
    if (pull.norm() < 1e-5) continue;
    // S_* already keeps D_z where the gap permits, so the pull ends on it: its anchor lies D_z
    // behind (D-05).
    const Eigen::Vector3d direction = pull.normalized();
    pushes_.push_back({bypass.first + j, target - c_.config.clearance_m * direction, direction});
    result_.record.directions.push_back({old.col(j + 1), target});
  }
  draft.replace(bypass.first, bypass.last, points, along);
}

/// Where `count` evenly spread control points, and one neighbour on each side, were before.
Eigen::Matrix3Xd Work::before(const Bypass& bypass, Eigen::Index count) const
{
  const Draft& draft = result_.draft;
  const Eigen::Matrix3Xd old =
      draft.points.middleCols(bypass.first - 1, bypass.last - bypass.first + 2);
  Eigen::Matrix3Xd even(3, count + 2);
  for (Eigen::Index j = 0; j < count + 2; ++j)
    even.col(j) = pointAt(old, static_cast<double>(j) / static_cast<double>(count + 1));
  return even;
}

void Work::push(const std::vector<Bypass>& bypasses, const std::vector<Eigen::Matrix3Xd>& guides)
{
  core::RefinementRecord& record = result_.record;
  record = {};  // explains the last push, not the sum of all attempts
  result_.recovered = false;
  pushes_.clear();
  // From the last to the first: the columns of those before stay where they are.
  for (std::size_t k = bypasses.size(); k-- > 0;)
  {
    const Bypass& bypass = bypasses[k];
    record.occupied_segments.push_back(
        result_.draft.points.middleCols(bypass.first - 1, bypass.last - bypass.first + 2));
    record.guides.push_back(guides[k]);
    const double spacing = c_.vehicle.max_speed_mps * result_.draft.knot_span;
    const auto count = static_cast<Eigen::Index>(
        std::clamp(std::ceil(polylineLength(guides[k]) / spacing) + 2.0, 5.0, 80.0));
    const PushingPath path = pushAlong(c_.field, guides[k], count, c_.hard, c_.config);
    result_.recovered = result_.recovered || path.recovered;
    record.pushing_paths.push_back(path.path);
    record.polyhedra.insert(record.polyhedra.end(), path.polyhedra.begin(), path.polyhedra.end());
    const Eigen::Index columns = result_.draft.points.cols();
    const std::size_t already = pushes_.size();
    lead(bypass, path);
    const Eigen::Index shift = result_.draft.points.cols() - columns;
    for (std::size_t i = 0; i < already; ++i) pushes_[i].point += shift;
  }
}

/// Every control point near an obstacle is kept off it, and in a gap off both its sides.
void Work::keepClear()
{
  const Draft& draft = result_.draft;
  for (Eigen::Index i = draft.firstFree(); i <= draft.lastFree(); ++i)
  {
    const Eigen::Vector3d p = draft.points.col(i);
    const auto here = c_.field.sample(p, UnknownAs::Free);
    if (!here || here->distance >= 1.5 * c_.config.clearance_m) continue;
    if (here->gradient.norm() >= kRidge)
    {
      pushOff(i, p, *here);
      pushOffOpposite(i, p, here->gradient.normalized());
      continue;
    }
    // On the ridge between two obstacles the sides are told apart a voxel to the left and right.
    const Eigen::Vector3d along = draft.points.col(i + 1) - draft.points.col(i - 1);
    const Eigen::Vector3d left = Eigen::Vector3d::UnitZ().cross(along).stableNormalized();
    for (const double side : {-1.0, 1.0})
    {
      const Eigen::Vector3d q = p + side * c_.field.resolution() * left;
      if (const auto there = c_.field.sample(q, UnknownAs::Free)) pushOff(i, q, *there);
    }
  }
}

void Work::pushOff(Eigen::Index column, const Eigen::Vector3d& p_L,
                   const core::DistanceSample& sample)
{
  const double steepness = sample.gradient.norm();
  if (steepness < kRidge) return;
  const Eigen::Vector3d normal = sample.gradient / steepness;
  pushes_.push_back({column, p_L - sample.distance * normal, normal});
}

/// The other side of a gap: where the distance falls again on the way away from this one.
void Work::pushOffOpposite(Eigen::Index column, const Eigen::Vector3d& p_L,
                           const Eigen::Vector3d& away)
{
  const double step = c_.field.resolution();
  for (double t = step; t <= c_.config.clearance_m; t += step)
  {
    const auto there = c_.field.sample(p_L + t * away, UnknownAs::Free);
    if (!there || there->distance >= 1.5 * c_.config.clearance_m) return;
    if (there->gradient.dot(away) > -kRidge) continue;
    pushOff(column, p_L + t * away, *there);
    return;
  }
}

/// Where R itself is too near to obstacles, leaving it is the purpose: no pull back there, nor
/// around.
Eigen::VectorXd Work::fitWeights() const
{
  const Draft& draft = result_.draft;
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(draft.points.cols());
  for (const OccupiedSegment& s : c_.reference_occupied)
    for (Eigen::Index i = 0; i < weights.size(); ++i)
      if (draft.along[i] > s.from - kFitAround_s && draft.along[i] < s.to + kFitAround_s)
        weights[i] = 0.0;
  // Nor before the window's end, if the shortest way there is what is wanted. A pull on a part of
  // it would draw in the rest, plan by plan.
  if (c_.late_return)
  {
    const Eigen::Matrix3Xd off = draft.points - referencePoints(c_.r, draft.along);
    if (off.rightCols(off.cols() - draft.fixed).colwise().norm().maxCoeff() > kAwayFromR_m)
      weights.setZero();
  }
  // Nor where the way does not get on along R at all.
  for (Eigen::Index i = 1; i < weights.size(); ++i)
    if (draft.along[i] <= draft.along[i - 1]) weights[i] = 0.0;
  return weights;
}

/// R's own bends are no roughness where the plan is to be R; elsewhere the straighter the better.
Eigen::Matrix3Xd Work::wantedBend(const Eigen::Matrix3Xd& reference,
                                  const Eigen::VectorXd& fit) const
{
  const Eigen::VectorXd& along = result_.draft.along;
  Eigen::Matrix3Xd bend = Eigen::Matrix3Xd::Zero(3, reference.cols() - 2);
  for (Eigen::Index i = 0; i < bend.cols(); ++i)
  {
    const double uneven = along[i + 2] - 2.0 * along[i + 1] + along[i];
    if (std::abs(uneven) < 1e-6 && fit.segment<3>(i).minCoeff() > 0.0)
      bend.col(i) = reference.col(i + 2) - 2.0 * reference.col(i + 1) + reference.col(i);
  }
  return bend;
}

void Work::minimise(double gain)
{
  Draft& draft = result_.draft;
  if (!draft.hasFreePoints()) return;
  const GlobalPlannerConfig& config = c_.config;
  RefinementCost::Problem problem;
  problem.points = draft.points;
  problem.reference = referencePoints(c_.r, draft.along);
  problem.fit_weight = fitWeights();
  problem.bend = wantedBend(problem.reference, problem.fit_weight);
  problem.first_free = draft.firstFree();
  problem.last_free = draft.lastFree();
  problem.knot_span = draft.knot_span;
  problem.pushes = pushes_;
  // J_obs was weighted for a margin of 0.45 m between D_z and the radius; its cubic scales with it.
  constexpr double kUsualMargin_m = 0.45;
  constexpr double kLargest = 20.0;
  problem.obstacle_gain =
      gain *
      std::min(kLargest, std::pow(kUsualMargin_m / (config.clearance_m - c_.vehicle.radius_m), 3));

  const Eigen::Index free = problem.last_free - problem.first_free + 1;
  const Eigen::Matrix3Xd reference = problem.reference.middleCols(problem.first_free, free);
  const Eigen::Matrix3Xd now = draft.points.middleCols(problem.first_free, free);
  Eigen::Matrix3Xd lower = reference.array() - config.max_offset_m;
  Eigen::Matrix3Xd upper = reference.array() + config.max_offset_m;
  lower.row(2) = (reference.row(2).array() - config.max_climb_m).max(config.min_altitude_m);
  upper.row(2) = (reference.row(2).array() + config.max_climb_m).min(config.max_altitude_m);
  // A vehicle that comes from outside of the box is led back into it, not torn.
  const Eigen::Vector3d given = draft.points.col(problem.first_free - 1);
  lower.topRows<2>() = lower.topRows<2>().cwiseMin(now.topRows<2>());
  upper.topRows<2>() = upper.topRows<2>().cwiseMax(now.topRows<2>());
  lower.row(2) = lower.row(2).cwiseMin(given.z());
  upper.row(2) = upper.row(2).cwiseMax(given.z());

  RefinementCost cost(std::move(problem), config, c_.vehicle);
  optim::BoxMinimizerConfig solver;
  solver.method = config.optimizer;
  solver.max_evaluations = config.max_evaluations;
  const optim::BoxMinimum minimum = optim::minimizeInBox(cost, cost.start(), lower.reshaped(),
                                                         upper.reshaped(), solver, c_.deadline);
  result_.record.solve = minimum.report;
  draft.points = cost.points(minimum.x);
}

bool Work::findGuides(const std::vector<Bypass>& bypasses, std::vector<Eigen::Matrix3Xd>& guides)
{
  guides.clear();
  for (const Bypass& bypass : bypasses)
  {
    const GuideSearch search =
        searchGuides(c_.field, bypass.from_L, bypass.to_L, c_.hard, 1, c_.config);
    if (search.guides.empty())
    {
      result_.failure = search.reason;
      return false;
    }
    guides.push_back(search.guides.front());
  }
  return true;
}

/// Length of the curve ahead, every metre dearer by how much it is nearer than D_z: the guide's
/// measure.
double Work::travelCost(const UniformBSpline& curve) const
{
  const double from = c_.progress, to = curve.end();
  const auto count = static_cast<Eigen::Index>(std::ceil((to - from) / (0.5 * curve.knotSpan())));
  if (count < 1) return 0.0;
  const Eigen::Matrix3Xd line = curve.sample(from, to, count + 1);
  const double tight = c_.config.clearance_m - c_.vehicle.radius_m;
  double cost = 0.0;
  for (Eigen::Index k = 0; k < count; ++k)
  {
    const double missing = c_.config.clearance_m - optimisticDistance(c_.field, line.col(k + 1));
    cost += (line.col(k + 1) - line.col(k)).norm() *
            (1.0 + c_.config.guide_proximity_weight * std::max(0.0, missing) / tight);
  }
  return cost;
}

/// What a proof of the draft would have to show, with `more` clearance than needed.
Certificate Work::prove(const UniformBSpline& curve, double more) const
{
  // The margin is demanded of what can still be changed. What is given was proved with it when it
  // was free, on another map; or it is where the vehicle flies anyhow.
  const double radius = c_.vehicle.radius_m, margin = c_.margin + more;
  const double from = std::min(c_.progress, curve.end());
  const double given =
      std::clamp(result_.draft.influence(result_.draft.fixed - 1), from, curve.end());
  const Certificate first = certify(curve, from, given, c_.field, UnknownAs::Free, radius);
  if (!first.holds(given)) return first;
  const Certificate rest =
      certify(curve, given, curve.end(), c_.field, UnknownAs::Free, radius + margin);
  return {rest.until, std::min(first.margin_m, rest.margin_m + margin)};
}

/// Takes the draft as it is if it is proved clear. True if half a voxel is to spare besides, since
/// the next map will differ.
bool Work::examine(std::optional<Refinement>& accepted)
{
  const UniformBSpline curve = result_.draft.curve();
  const Certificate certificate = prove(curve, 0.0);
  if (!certificate.holds(curve.end())) return false;
  const bool comfortable = prove(curve, 0.5 * c_.field.resolution()).holds(curve.end());
  const double clearance = minClearance(curve, c_.progress, curve.end(), c_.field);
  if (comfortable || !accepted || clearance > accepted->record.min_clearance_m)
  {
    accepted = result_;
    accepted->accepted = true;
    accepted->certificate = certificate;
    accepted->failure.clear();
    accepted->travel_cost = travelCost(curve);
    accepted->record.min_clearance_m = clearance;
  }
  return comfortable;
}

Refinement Work::run(std::vector<Bypass> bypasses, std::vector<Eigen::Matrix3Xd> guides)
{
  std::optional<Refinement> accepted;
  double gain = 1.0;
  for (int attempt = 0; attempt < c_.config.max_attempts; ++attempt, gain *= kStronger)
  {
    if (attempt > 0)
    {
      bypasses = bypassesOf(result_.draft, c_);
      if (!findGuides(bypasses, guides)) break;
    }
    push(bypasses, guides);
    Draft pushed = result_.draft;
    keepClear();
    minimise(gain);
    result_.failure = "not clear after optimisation";
    if (examine(accepted)) break;
    if (accepted || bypasses.empty()) continue;
    // S_* lies inside its polyhedra, however much J would rather have a smoother way.
    std::swap(result_.draft, pushed);
    examine(accepted);
    std::swap(result_.draft, pushed);
  }
  return accepted ? std::move(*accepted) : std::move(result_);
}

}  // namespace

std::vector<Bypass> bypassesOf(const Draft& draft, const StepContext& context)
{
  if (!draft.hasFreePoints()) return {};
  const UniformBSpline curve = draft.curve();
  const double from = std::max(draft.influence(draft.fixed - 1), context.progress);
  std::vector<Bypass> bypasses;
  const auto columnAfter = [&](double t)
  { return static_cast<Eigen::Index>(std::ceil((t - draft.start) / draft.knot_span + 1.0)); };
  for (const OccupiedSegment& s :
       findOccupiedSegments(curve, from, curve.end(), context.field, context.hard, kMergeGap_s))
  {
    // As far before and behind as it takes to turn off, while the curve stays free.
    const auto widened = [&](double t, double step)
    {
      const Eigen::Vector3d edge = curve.position(t);
      for (;;)
      {
        const double next = t + step;
        if (next < from || next > curve.end() ||
            (curve.position(next) - edge).norm() > kTurnOff_m ||
            optimisticDistance(context.field, curve.position(next)) < context.hard)
          return t;
        t = next;
      }
    };
    Bypass bypass;
    bypass.first =
        std::clamp(columnAfter(widened(s.from, -draft.knot_span)), draft.fixed, draft.lastFree());
    bypass.last = std::clamp(columnAfter(widened(s.to, draft.knot_span)), bypass.first + 1,
                             draft.lastFree() + 1);
    if (!bypasses.empty() && bypass.first <= bypasses.back().last + 1)
      bypasses.back().last = std::max(bypasses.back().last, bypass.last);
    else
      bypasses.push_back(bypass);
  }
  for (Bypass& bypass : bypasses)
  {
    bypass.from_L = curve.position(draft.influence(bypass.first - 1));
    bypass.to_L = curve.position(draft.influence(bypass.last));
  }
  return bypasses;
}

Bypass joinOf(const Draft& draft)
{
  return {draft.fixed, draft.fixed, draft.points.col(draft.fixed - 1),
          draft.points.col(draft.fixed)};
}

Refinement refine(const StepContext& context, Draft draft, const std::vector<Bypass>& bypasses,
                  const std::vector<Eigen::Matrix3Xd>& guides)
{
  return Work(context, std::move(draft)).run(bypasses, guides);
}

}  // namespace slalom::global_planner
