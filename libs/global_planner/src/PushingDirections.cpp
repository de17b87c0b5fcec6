// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/global_planner/PushingDirections.h"

#include <algorithm>
#include <cmath>

#include "PushingProgram.h"
#include "slalom/geometry/ConvexDecomposition.h"

namespace slalom::global_planner
{
namespace
{
using core::HalfSpaces;

/// Cuts every edge into equal pieces not longer than `longest`.
Eigen::Matrix3Xd cutIntoPieces(const Eigen::Matrix3Xd& path, double longest)
{
  std::vector<Eigen::Vector3d> points{path.col(0)};
  for (Eigen::Index k = 0; k + 1 < path.cols(); ++k)
  {
    const Eigen::Vector3d edge = path.col(k + 1) - path.col(k);
    const int pieces = std::max(1, static_cast<int>(std::ceil(edge.norm() / longest)));
    for (int i = 1; i <= pieces; ++i) points.push_back(path.col(k) + edge * (double(i) / pieces));
  }
  Eigen::Matrix3Xd cut(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) cut.col(static_cast<Eigen::Index>(i)) = points[i];
  return cut;
}

std::vector<HalfSpaces> decomposeAlong(const core::DistanceField& field,
                                       const Eigen::Matrix3Xd& pieces, double shrink,
                                       const GlobalPlannerConfig& config)
{
  geometry::DecompositionConfig shape;
  shape.along_m = config.box_along_m;
  shape.lateral_m = config.box_lateral_m;
  shape.vertical_m = config.box_vertical_m;
  shape.shrink_m = shrink;
  std::vector<std::vector<Eigen::Vector3d>> obstacles(static_cast<std::size_t>(pieces.cols() - 1));
  for (Eigen::Index k = 0; k + 1 < pieces.cols(); ++k)
    field.collectObstacles(geometry::localBox(pieces.col(k), pieces.col(k + 1), shape),
                           core::UnknownAs::Free, obstacles[static_cast<std::size_t>(k)]);
  std::vector<geometry::FreePolyhedron> free =
      geometry::decomposeParallel(pieces, obstacles, shape, config.threads);
  std::vector<HalfSpaces> sets;
  sets.reserve(free.size());
  for (std::size_t k = 0; k < free.size(); ++k)
  {
    if (!free[k].contains_seed)
    {
      // The guide keeps its clearance, but a tangent plane may be steeper than the way to the
      // nearest obstacle: move the offending planes back to the seed so that the program stays
      // feasible.
      HalfSpaces& set = free[k].set;
      for (Eigen::Index row = 0; row < set.rows(); ++row)
        set.b[row] = std::max({set.b[row], set.A.row(row).dot(pieces.col(Eigen::Index(k))),
                               set.A.row(row).dot(pieces.col(Eigen::Index(k) + 1))});
    }
    sets.push_back(std::move(free[k].set));
  }
  return sets;
}

/// Point j of n belongs to the piece at its share of the arc length, named first; near a joint it
/// belongs to both neighbours.
std::vector<std::vector<const HalfSpaces*>> assign(const Eigen::VectorXd& s, Eigen::Index points,
                                                   const std::vector<HalfSpaces>& sets)
{
  std::vector<std::vector<const HalfSpaces*>> assigned(static_cast<std::size_t>(points));
  const double spacing = s[s.size() - 1] / static_cast<double>(points - 1);
  for (Eigen::Index j = 0; j < points; ++j)
  {
    const double at = spacing * static_cast<double>(j);
    for (std::size_t k = 0; k < sets.size(); ++k)
    {
      const double lo = s[Eigen::Index(k)], hi = s[Eigen::Index(k) + 1];
      if (at < lo - 0.5 * spacing || at > hi + 0.5 * spacing) continue;
      auto& of_point = assigned[std::size_t(j)];
      of_point.insert(at >= lo && at <= hi ? of_point.begin() : of_point.end(), &sets[k]);
    }
  }
  return assigned;
}

/// A guide that starts or ends too near to obstacles begins or ends with a straight leg.
class Legs
{
 public:
  Legs(const core::DistanceField& field, const Eigen::Matrix3Xd& guide, double hard_clearance)
      : guide_(guide)
  {
    const auto tooNear = [&](Eigen::Index k)
    {
      const auto distance = field.distance(guide.col(k), core::UnknownAs::Free);
      return distance && *distance < hard_clearance;
    };
    const Eigen::Index n = guide.cols();
    if (n > 2 && tooNear(0)) retreat_m = (guide.col(1) - guide.col(0)).norm();
    if (n > (retreat_m > 0.0 ? 3 : 2) && tooNear(n - 1))
      approach_m = (guide.col(n - 1) - guide.col(n - 2)).norm();
  }
  double retreat_m = 0.0, approach_m = 0.0;

  [[nodiscard]] Eigen::Matrix3Xd clearPart() const
  {
    const Eigen::Index before = retreat_m > 0.0, behind = approach_m > 0.0;
    return guide_.middleCols(before, guide_.cols() - before - behind);
  }
  /// A leg has its share of `points` by length, at least one.
  void share(double clear_length, Eigen::Index points)
  {
    const double edges = static_cast<double>(points - 1);
    const double whole = clear_length + retreat_m + approach_m;
    const auto part = [&](double leg)
    {
      return leg > 0.0 ? static_cast<Eigen::Index>(std::max(1.0, std::round(leg / whole * edges)))
                       : 0;
    };
    before_ = part(retreat_m);
    behind_ = part(approach_m);
  }
  [[nodiscard]] Eigen::Index shared() const { return before_ + behind_; }
  [[nodiscard]] Eigen::Matrix3Xd around(const Eigen::Matrix3Xd& path) const
  {
    Eigen::Matrix3Xd whole(3, before_ + path.cols() + behind_);
    whole.middleCols(before_, path.cols()) = path;
    const auto place = [&](Eigen::Index from, Eigen::Index to, Eigen::Index i, Eigen::Index edges)
    {
      const double u = static_cast<double>(i) / static_cast<double>(edges);
      return ((1.0 - u) * guide_.col(from) + u * guide_.col(to)).eval();
    };
    const Eigen::Index last = guide_.cols() - 1;
    for (Eigen::Index i = 0; i < before_; ++i) whole.col(i) = place(0, 1, i, before_);
    for (Eigen::Index i = 0; i < behind_; ++i)
      whole.col(whole.cols() - 1 - i) = place(last, last - 1, i, behind_);
    return whole;
  }

 private:
  const Eigen::Matrix3Xd& guide_;
  Eigen::Index before_ = 0, behind_ = 0;  // points of the legs
};

}  // namespace

std::string_view toString(PushingMethod method)
{
  switch (method)
  {
    case PushingMethod::Program:
      return "Program";
    case PushingMethod::ProjectedAndSmoothed:
      return "ProjectedAndSmoothed";
    case PushingMethod::Projected:
      return "Projected";
  }
  return "?";
}

PushingPath pushAlong(const core::DistanceField& field, const Eigen::Matrix3Xd& guide,
                      Eigen::Index points, double hard_clearance, const GlobalPlannerConfig& config)
{
  PushingPath result;
  result.guide = guide;
  Legs legs(field, guide, hard_clearance);
  result.retreat_m = legs.retreat_m;
  result.approach_m = legs.approach_m;
  const Eigen::Matrix3Xd pieces = cutIntoPieces(legs.clearPart(), config.piece_m);
  // Obstacles are voxel centres, the clearance counts from their surface.
  result.polyhedra =
      decomposeAlong(field, pieces, hard_clearance + 0.5 * field.resolution(), config);

  const Eigen::VectorXd s = arcLength(pieces);
  legs.share(s[s.size() - 1], points);
  PushingProgram program;
  program.points = resample(pieces, s, std::max<Eigen::Index>(2, points - legs.shared()));
  program.sets = assign(s, program.points.cols(), result.polyhedra);
  program.margin = std::max(0.0, config.clearance_m - hard_clearance);
  program.form = config.pushing;
  const PushingProgramSolution solution = solvePushing(program);
  result.solve = solution.solve;
  result.method = solution.method;
  result.recovered = solution.method != PushingMethod::Program;
  if (result.recovered)
    result.reason = "pushing program " + std::string(toString(solution.solve.termination)) + ": " +
                    std::string(toString(solution.method));
  result.path = legs.around(solution.path);
  return result;
}

}  // namespace slalom::global_planner
