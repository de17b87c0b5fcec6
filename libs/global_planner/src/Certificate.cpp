// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/global_planner/Certificate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

/* Proof of the certificate.
 *
 *  1. Enclosure. On a span the B-spline is a cubic polynomial; its Bezier points b_0..b_3 over a
 *     parameter interval hold the curve's piece in their convex hull (Bernstein weights are
 *     non-negative and sum to 1). De Casteljau's rule gives the Bezier points of both halves.
 *     A ball is convex, so the ball about c = (b_0 + b_3) / 2 of radius r = max_j |b_j - c| holds
 *     the hull.
 *  2. Acceptance. The distance D(p) to a fixed set of obstacle points changes by at most |p - q|
 *     from p to q. If B <= D(c) then every point q of the piece has D(q) >= B - r; the piece is
 *     accepted if B - r >= clearance, with B from DistanceField::boundEverywhere(). Short pieces
 *     are also accepted if DistanceField::hullBound(b_0..b_3), a proved bound on the distance from
 *     the hull itself, is at least the clearance.
 *  3. Union. Pieces are taken from left to right, are closed, and each begins where the last one
 *     ended; `until` is the end of the last accepted one. So [from, until] is covered.
 *  4. Rounding. A step a + t (b - a) errs by at most 5 units of rounding of the largest coordinate,
 *     so k divisions of three such steps each, and making the first Bezier points and the ball,
 *     stay below (16 + 8 k) machine epsilons of it; the radius is enlarged by that (roundingOf()).
 *     Times round to less than 1e-9 m of curve, by which voxel fields keep their bounds low. */

namespace slalom::global_planner
{
namespace
{
constexpr double kSmallest = 5e-5;    // [m] radius of a ball that is not divided further
constexpr double kShort = 1.0;        // [voxel] radius below which the hull itself is looked at
constexpr double kMostMargin = 0.05;  // [m] margin that the hull's bound is asked for
constexpr int kDeepest = 48;          // bisections of a span
constexpr int kPiecesPerSpan = 64;    // bound on the work: so many per span
constexpr int kPiecesOfAll = 20000;   // and so many for the hard places of the whole curve

struct Piece
{
  core::Hull4 bezier;
  double from, to;  // place in its span, in [0, 1]
  int depth;
};

// Splits at the share t of the piece, in (0, 1).
std::array<Piece, 2> split(const Piece& piece, double t)
{
  const auto mix = [t](const Eigen::Vector3d& a, const Eigen::Vector3d& b) -> Eigen::Vector3d
  { return a + t * (b - a); };
  const auto& b = piece.bezier;
  const Eigen::Vector3d b01 = mix(b.col(0), b.col(1)), b12 = mix(b.col(1), b.col(2)),
                        b23 = mix(b.col(2), b.col(3)), b012 = mix(b01, b12), b123 = mix(b12, b23),
                        middle = mix(b012, b123);
  std::array<Piece, 2> halves{piece, piece};
  halves[0].bezier << b.col(0), b01, b012, middle;
  halves[1].bezier << middle, b123, b23, b.col(3);
  halves[0].to = halves[1].from = piece.from + t * (piece.to - piece.from);
  halves[0].depth = halves[1].depth = piece.depth + 1;
  return halves;
}

// The part of a span between two places 0 <= from < to <= 1.
Piece pieceOf(const spline::UniformBSpline& curve, Eigen::Index span, double from, double to)
{
  const auto c = curve.controlPoints().middleCols<4>(span);
  Piece piece{{}, 0.0, 1.0, 0};
  piece.bezier << (c.col(0) + 4.0 * c.col(1) + c.col(2)) / 6.0, (2.0 * c.col(1) + c.col(2)) / 3.0,
      (c.col(1) + 2.0 * c.col(2)) / 3.0, (c.col(1) + 4.0 * c.col(2) + c.col(3)) / 6.0;
  if (to < 1.0) piece = split(piece, to)[0];
  if (from > 0.0) piece = split(piece, from / to)[1];
  piece.from = from;
  piece.to = to;
  piece.depth = 0;
  return piece;
}

class Prover
{
 public:
  Prover(const core::DistanceField& field, core::UnknownAs unknown, double clearance, int work)
      : field_(field),
        unknown_(unknown),
        clearance_(clearance),
        short_(kShort * field.resolution()),
        work_(work)
  {
  }

  /// Proves a piece from its start on. @return the place in the span up to which it is proved.
  double prove(const Piece& whole)
  {
    const double rounding = roundingOf(whole);
    std::array<Piece, kDeepest + 1> waiting;  // right halves; the last one is next
    std::size_t count = 0;
    waiting[count++] = whole;
    while (count > 0)
    {
      const Piece piece = waiting[--count];
      const Eigen::Vector3d centre = 0.5 * (piece.bezier.col(0) + piece.bezier.col(3));
      const double radius =
          std::sqrt((piece.bezier.colwise() - centre).colwise().squaredNorm().maxCoeff()) +
          rounding;
      if (accept(piece.bezier, centre, radius, rounding)) continue;
      if (radius - rounding <= kSmallest || piece.depth == kDeepest || --work_ < 0)
        return piece.from;
      const auto halves = split(piece, 0.5);
      waiting[count++] = halves[1];
      waiting[count++] = halves[0];
    }
    return whole.to;
  }

  /// Proved margin of a single point [m].
  [[nodiscard]] double marginAt(const Eigen::Vector3d& p) const
  {
    return field_.hullBound(p.replicate<1, 4>(), unknown_, clearance_ + kMostMargin) - clearance_;
  }

  /// Least margin of all pieces accepted so far [m]; infinite if there are none.
  [[nodiscard]] double margin() const { return margin_; }

 private:
  [[nodiscard]] static double roundingOf(const Piece& whole)
  {
    constexpr double kEpsilons = 16.0 + 8.0 * (kDeepest + 2);
    return kEpsilons * std::numeric_limits<double>::epsilon() * whole.bezier.cwiseAbs().maxCoeff();
  }

  bool accept(const core::Hull4& bezier, const Eigen::Vector3d& centre, double radius,
              double rounding)
  {
    double bound = field_.boundEverywhere(centre, unknown_) - radius;
    if (!(bound >= clearance_) && radius <= short_)
      bound = field_.hullBound(bezier, unknown_, clearance_ + kMostMargin) - rounding;
    if (!(bound >= clearance_)) return false;
    margin_ = std::min(margin_, bound - clearance_);
    return true;
  }

  const core::DistanceField& field_;
  core::UnknownAs unknown_;
  double clearance_;
  double short_;  // [m] radius below which the price of the hull's bound is paid
  int work_;
  double margin_ = std::numeric_limits<double>::infinity();
};

void check(double from, double to, double clearance_m)
{
  if (!(clearance_m > 0.0) || !std::isfinite(clearance_m))
    throw std::invalid_argument("certify: clearance " + std::to_string(clearance_m) +
                                " m, must be positive and finite");
  if (!std::isfinite(from) || !std::isfinite(to))
    throw std::invalid_argument("certify: stretch [" + std::to_string(from) + ", " +
                                std::to_string(to) + "] s is not finite");
}

}  // namespace

Certificate certify(const spline::UniformBSpline& curve, double from, double to,
                    const core::DistanceField& field, core::UnknownAs unknown, double clearance_m)
{
  check(from, to, clearance_m);
  to = std::max(from, to);
  const double first = std::clamp(from, curve.start(), curve.end());
  const double last = std::clamp(to, curve.start(), curve.end());
  const Eigen::Index span_first = curve.spanAt(first), span_last = curve.spanAt(last);
  const double work =
      kPiecesOfAll + kPiecesPerSpan * static_cast<double>(span_last - span_first + 1);
  Prover prover(field, unknown, clearance_m, static_cast<int>(std::min(work, 1e9)));
  const auto timeOf = [&](Eigen::Index span, double u)
  { return curve.start() + curve.knotSpan() * (static_cast<double>(span) + u); };
  const auto placeOf = [&](Eigen::Index span, double t)
  {
    return std::clamp((t - curve.start()) / curve.knotSpan() - static_cast<double>(span), 0.0, 1.0);
  };

  double until = first;
  bool whole = true;
  for (Eigen::Index span = span_first; span <= span_last && whole; ++span)
  {
    const double u_first = span == span_first ? placeOf(span, first) : 0.0;
    const double u_last = span == span_last ? placeOf(span, last) : 1.0;
    if (!(u_first < u_last)) continue;
    const double proved = prover.prove(pieceOf(curve, span, u_first, u_last));
    whole = proved >= u_last;
    until = std::clamp(timeOf(span, proved), until, last);
  }
  const double start_margin = prover.margin() < std::numeric_limits<double>::infinity()
                                  ? prover.margin()
                                  : prover.marginAt(curve.position(first));
  if (start_margin < 0.0) return {from, start_margin};
  return {whole ? to : std::max(from, until), start_margin};
}

}  // namespace slalom::global_planner
