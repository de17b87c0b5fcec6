// SPDX-License-Identifier: BSD-3-Clause
#include "KeepOuts.h"

#include <algorithm>
#include <cmath>

#include "CloseObstacles.h"

namespace slalom::local_planner::detail
{
namespace
{
using core::MovingObstacle;
using Eigen::Vector3d;

constexpr double kReach = 1.0;  // [m] beyond the asked-for distance, how far obstacles matter
constexpr int kMostMovers = 4;  // per stage, the nearest
constexpr int kAxes = 3;        // sides of the airspace per stage: the nearer one of each axis
constexpr double kSight = 0.5;  // [m] how far from a side of the airspace it matters

Vector3d across(const Vector3d& v, const Vector3d& direction)
{
  return v - v.dot(direction) * direction;
}

/// Horizontal direction in which to leave the way of something that is met.
Vector3d aside(const Vector3d& away, const Vector3d& v, const MovingObstacle& mover)
{
  constexpr double kBehind = 0.3;  // [m] a miss by less than this may change sides
  const Vector3d closing = v - mover.v_L;
  if (closing.norm() < 1e-3) return away.norm() > 1e-6 ? away.normalized() : Vector3d::UnitX();
  const Vector3d along = closing.normalized();
  Vector3d side = across(away, along);
  if (mover.v_L.norm() > 1e-3) side += kBehind * across(-mover.v_L.normalized(), along);
  side.z() = 0.0;
  if (side.norm() < 1e-3) side = Vector3d(-along.y(), along.x(), 0.0);
  return side.norm() > 1e-6 ? side.normalized() : Vector3d::UnitX();
}

void addMap(const core::DistanceField& field, const Plan& expected,
            const LocalPlannerConfig& config, const core::Vehicle& vehicle, KeepOuts& rows)
{
  const Eigen::Index n = expected.inputs.cols();
  const double asked = vehicle.radius_m + config.min_clearance_margin_m;
  const double stop_s = vehicle.velocity_lag_s +
                        0.5 * expected.velocities.col(n).norm() / vehicle.max_acceleration_mps2;
  Eigen::Matrix3Xd path(3, n + 2);
  path << expected.positions, expected.positions.col(n) + stop_s * expected.velocities.col(n);
  CloseObstacles close = collectCloseObstacles(field, path, vehicle.radius_m, asked + kReach);
  rows.finite = close.finite;
  for (Eigen::Index k = 1; k <= n + 1 && close.finite; ++k)
  {
    const Vector3d anchor = close.anchors.col(k);
    for (const Vector3d& point :
         nearestAround(anchor, close.points_L, config.obstacles_per_stage, asked + kReach))
    {
      const Vector3d normal = (anchor - point).normalized();
      rows.stages[static_cast<std::size_t>(std::min(k, n) - 1)].push_back(
          {normal, k > n ? stop_s : 0.0, normal.dot(point) + asked});
    }
  }
  rows.points_L = std::move(close.points_L);
}

void addMover(const MovingObstacle& mover, double t, const Plan& expected,
              const LocalPlannerConfig& config, const core::Vehicle& vehicle, KeepOuts& rows)
{
  for (std::size_t k = 0; k < rows.stages.size(); ++k)
  {
    const double time = t + static_cast<double>(k + 1) * config.step_s;
    const auto column = static_cast<Eigen::Index>(k) + 1;
    const Vector3d place = mover.nearest(expected.positions.col(column), time);
    const Vector3d away = expected.positions.col(column) - place;
    const double asked = contactDistance(mover, time, vehicle) + config.mover_margin_m;
    if (away.norm() > asked + kReach) continue;
    const Vector3d normal = away.norm() < asked
                                ? aside(away, expected.velocities.col(column), mover)
                                : Vector3d(away.normalized());
    rows.stages[k].push_back({normal, 0.0, normal.dot(place) + asked});
  }
}

/// The sides of the airspace; at the last stage for where braking would end.
void addAirspace(const Eigen::AlignedBox3d& airspace, const Plan& expected,
                 const core::Vehicle& vehicle, KeepOuts& rows)
{
  const std::size_t n = rows.stages.size();
  for (std::size_t k = 0; k < n; ++k)
  {
    const auto column = static_cast<Eigen::Index>(k) + 1;
    const Vector3d p = expected.positions.col(column), v = expected.velocities.col(column);
    const double lead =
        k + 1 < n ? 0.0 : vehicle.velocity_lag_s + 0.5 * v.norm() / vehicle.max_acceleration_mps2;
    for (int axis = 0; axis < kAxes; ++axis)
    {
      const double low = p[axis] - airspace.min()[axis], high = airspace.max()[axis] - p[axis];
      if (!(std::min(low, high) < kSight)) continue;
      if (low <= high)
        rows.stages[k].push_back({Vector3d::Unit(axis), lead, airspace.min()[axis]});
      else
        rows.stages[k].push_back({-Vector3d::Unit(axis), lead, -airspace.max()[axis]});
    }
  }
}
}  // namespace

int mostRows(const LocalPlannerConfig& config)
{
  return 2 * config.obstacles_per_stage + kMostMovers + kAxes;
}

double contactDistance(const MovingObstacle& mover, double time, const core::Vehicle& vehicle)
{
  return vehicle.radius_m + mover.radius_m + mover.uncertainty(time, 2.0);
}

KeepOuts keepOuts(const LocalPlannerInput& input, const Plan& expected,
                  const LocalPlannerConfig& config, const core::Vehicle& vehicle)
{
  KeepOuts rows;
  rows.stages.resize(static_cast<std::size_t>(config.horizon));
  if (input.field && config.obstacles_per_stage > 0)
    addMap(*input.field, expected, config, vehicle, rows);
  addAirspace(input.airspace_L, expected, vehicle, rows);
  std::vector<MovingObstacle> movers = input.movers;
  const auto distance = [&](const MovingObstacle& m)
  { return (m.nearest(input.state.p_L, input.state.t) - input.state.p_L).norm(); };
  std::sort(movers.begin(), movers.end(),
            [&](const MovingObstacle& a, const MovingObstacle& b)
            { return distance(a) < distance(b); });
  if (movers.size() > kMostMovers) movers.resize(kMostMovers);
  for (const MovingObstacle& mover : movers)
  {
    if (mover.p_L.allFinite() && mover.v_L.allFinite())
      addMover(mover, input.state.t, expected, config, vehicle, rows);
    else
      rows.finite = false;
  }
  return rows;
}

}  // namespace slalom::local_planner::detail
