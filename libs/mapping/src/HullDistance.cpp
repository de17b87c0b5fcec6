// SPDX-License-Identifier: BSD-3-Clause
#include "HullDistance.h"

#include <algorithm>
#include <cmath>

namespace slalom::mapping::detail
{
namespace
{
/* Proof, for the hull of b_0..b_3 about c = (b_0 + b_3) / 2 with radius r = max |b_j - c|.
 *
 *  One cube K, any point q outside it, k the point of K nearest to q, n = (q - k) / |q - k|:
 *  since K is convex, n (x - k) <= 0 on K. So any p has |p - x| >= n (p - x) >= n (p - k) for all
 *  x in K, and over the hull the linear n (p - k) is least at one of the b_j. Hence
 *    distance(hull, K) >= B_q(K) = min_j n (b_j - k).
 *  With q = c and D = |c - k|: B_c >= D - r, and distance(hull, K) <= D; for equal points B_c = D.
 *  Where B_c is too small, the point q of the chord b_0 b_3 that is about nearest to K does better
 *  (for a straight hull beside a face or an edge of K it is exact); the larger one counts.
 *
 *  The result is the least of `limit` and of all cubes. Let m be the least found so far: cubes
 *  with D >= m + r cannot lower it and are left out. The field prunes two more ways. A cell with
 *  the value v > 0 has no obstacle centre nearer than sqrt(v), in its own row either. And the
 *  nearest obstacle centre o of the cell next to c, whose centre is e, bounds the least D, hence
 *  the result, by |c - o| - 1/2 <= |c - e| + sqrt(v) - 1/2, as a cube holds a ball of half its
 *  edge. */
struct Search
{
  const int nx;
  const Eigen::Vector3d c;
  const Eigen::Matrix3d arms;  // b_0, b_1, b_2 from c; b_3 is opposite to b_0
  const double chord2;         // |b_0 - c|^2
  const double radius;
  double least = 0.0, reach = 0.0, reach2 = 0.0;

  void lowerTo(double value)
  {
    least = value;
    reach = least + radius;
    reach2 = reach * reach;
  }

  // B_q(K) for d = q - k and k seen from c.
  [[nodiscard]] double bound(const Eigen::Vector3d& d, const Eigen::Vector3d& k_c) const
  {
    const Eigen::Vector3d along = arms.transpose() * d;
    return (std::min({-std::abs(along[0]), along[1], along[2]}) - d.dot(k_c)) / d.norm();
  }

  // Takes the cube of a cell into account, d = c - k.
  void take(int x, int y, int z, const Eigen::Vector3d& d)
  {
    if (!(d.squaredNorm() > 0.0)) return lowerTo(-radius);
    double value = bound(d, -d);
    if (value >= least) return;
    if (chord2 > 0.0)
    {
      const double t = std::clamp(-d.dot(arms.col(0)) / chord2, -1.0, 1.0);
      const Eigen::Vector3d q_c = t * arms.col(0), low = Eigen::Vector3d(x, y, z) - c;
      const Eigen::Vector3d k_c = q_c.cwiseMax(low).cwiseMin(low + Eigen::Vector3d::Ones());
      if (q_c != k_c) value = std::max(value, bound(q_c - k_c, k_c));
    }
    if (value < least) lowerTo(value);
  }
};

// How far u is from the interval [cell, cell + 1], with its sign.
double gap(double u, int cell)
{
  const double below = u - cell;
  return below < 0.0 ? below : std::max(0.0, below - 1.0);
}

void searchRow(const std::int16_t* row, int own, int y, int z, double dy, double dz, Search& search)
{
  const double aside2 = dy * dy + dz * dz;
  // Cells of interest are nearer than sqrt(reach2 - aside2) + 1 from the cell `own`.
  if (row[own] >= search.reach2 - aside2 + 2.0 * search.reach + 1.0) return;
  for (const int step : {1, -1})
    for (int x = step > 0 ? own : own - 1; x >= 0 && x < search.nx; x += step)
    {
      const double dx = gap(search.c.x(), x);
      if (dx * dx + aside2 >= search.reach2) break;
      if (row[x] <= 0) search.take(x, y, z, {dx, dy, dz});
    }
}

}  // namespace

double distanceToCubes(const GridShape& shape, const std::int16_t* field, const core::Hull4& hull,
                       double limit, int saturation)
{
  const Eigen::Vector3d c = 0.5 * (hull.col(0) + hull.col(3));
  const Eigen::Matrix3d arms = hull.leftCols<3>().colwise() - c;
  Search search{shape.size.x(), c, arms, arms.col(0).squaredNorm(),
                std::sqrt(arms.colwise().squaredNorm().maxCoeff())};

  const Eigen::Array3d last = shape.size.cast<double>().array() - 1.0;
  const Eigen::Array3i own = c.array().floor().max(0.0).min(last).cast<int>();
  const int here = field[shape.row(own.y(), own.z()) + own.x()];
  if (here < saturation)
    limit = std::min(limit, (c.array() - own.cast<double>() - 0.5).matrix().norm() +
                                std::sqrt(std::max(0.0, static_cast<double>(here))) - 0.5);
  search.lowerTo(limit);
  if (!(limit > 0.0)) return 0.0;
  const Eigen::Array3i low = (c.array() - search.reach).floor().max(0.0).min(last).cast<int>();
  const Eigen::Array3i high = (c.array() + search.reach).floor().max(0.0).min(last).cast<int>();
  for (int z = low.z(); z <= high.z(); ++z)
  {
    const double dz = gap(c.z(), z);
    for (int y = low.y(); y <= high.y(); ++y)
    {
      const double dy = gap(c.y(), y);
      if (dz * dz + dy * dy < search.reach2)
        searchRow(field + shape.row(y, z), own.x(), y, z, dy, dz, search);
    }
  }
  return std::max(0.0, search.least);
}

}  // namespace slalom::mapping::detail
