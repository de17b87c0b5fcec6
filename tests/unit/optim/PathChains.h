// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/QR>
#include <algorithm>
#include <deque>
#include <vector>

#include "slalom/core/Rng.h"
#include "slalom/optim/PathQp.h"
#include "slalom/optim/PathSocp.h"

/// Generated chains of points in polyhedra, and the geometry of their optimality conditions.
namespace slalom::optim::test
{
using core::HalfSpaces;
using core::Rng;
using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Random half-spaces that all hold `inside` with at least `room` to spare.
inline HalfSpaces around(Rng& rng, const Vector3d& inside, int rows, double room)
{
  HalfSpaces set;
  set.A.resize(rows, 3);
  set.b.resize(rows);
  for (int i = 0; i < rows; ++i)
  {
    const Vector3d normal = rng.direction();
    set.A.row(i) = normal.transpose();
    set.b[i] = normal.dot(inside) + rng.uniform(room, room + 0.6);
  }
  return set;
}

/// A winding guide with polyhedra shared by neighbouring points, as the global planner makes them.
struct Chain
{
  explicit Chain(std::uint64_t seed, int most_points = 30)
  {
    Rng rng(seed);
    qp.points = rng.integer(2, most_points);
    qp.margin = rng.integer(0, 2) == 0 ? 0.0 : rng.uniform(0.05, 0.8);
    qp.w_bend = rng.integer(0, 3) == 0 ? 0.0 : rng.uniform(0.1, 3.0);
    qp.w_length = rng.uniform(0.2, 2.0);
    qp.w_slack = rng.uniform(1.0, 30.0);
    qp.sets.resize(qp.points);
    Vector3d guide = rng.uniform3(-50.0, 50.0), heading = rng.direction();
    qp.first = guide;
    for (Index k = 0; k < qp.points; ++k)
    {
      if (k == 0 || rng.integer(0, 3) == 0)
        polyhedra.push_back(around(rng, guide, rng.integer(3, 12), 0.05));
      // Sharing is only promised as far as the set holds the guide.
      if (!polyhedra.back().contains(guide, -0.02))
        polyhedra.push_back(around(rng, guide, rng.integer(3, 12), 0.05));
      qp.sets[k].push_back(&polyhedra.back());
      if (rng.integer(0, 4) == 0)
      {
        polyhedra.push_back(around(rng, guide, 4, 0.05));
        qp.sets[k].push_back(&polyhedra.back());
      }
      heading = (heading + 0.7 * rng.direction()).normalized();
      if (k + 1 < qp.points) guide += 0.3 * heading;
    }
    qp.last = guide;
  }
  /// The same points and sets in the paper's norms.
  [[nodiscard]] PathSocp socp() const
  {
    PathSocp q;
    q.first = qp.first;
    q.last = qp.last;
    q.points = qp.points;
    q.sets = qp.sets;
    return q;
  }
  PathQp qp;
  std::deque<HalfSpaces> polyhedra;
};

inline HalfSpaces halfSpace(const Vector3d& normal, double b)
{
  HalfSpaces set;
  set.A = normal.transpose();
  set.b = VectorXd::Constant(1, b);
  return set;
}

/// Distance of v from the cone of the columns of N: by Caratheodory three columns suffice.
inline double distanceFromCone(const Vector3d& v, const Matrix3Xd& N)
{
  double best = v.norm();
  const Index m = N.cols();
  for (Index a = 0; a < m; ++a)
    for (Index b = a; b < m; ++b)
      for (Index c = b; c < m; ++c)
      {
        std::vector<Index> pick{a};
        if (b > a) pick.push_back(b);
        if (c > b) pick.push_back(c);
        const Eigen::MatrixXd basis = N(Eigen::all, pick);
        const VectorXd weight = basis.colPivHouseholderQr().solve(v);
        if ((weight.array() >= 0.0).all()) best = std::min(best, (basis * weight - v).norm());
      }
  return best;
}

/// Largest A p - b.
inline double violation(const PathSets& sets, const Matrix3Xd& p)
{
  double worst = -1e300;
  for (std::size_t k = 0; k < sets.size(); ++k)
    for (const HalfSpaces* set : sets[k])
      worst = std::max(worst, set->violation(p.col(static_cast<Index>(k))));
  return worst;
}

}  // namespace slalom::optim::test
