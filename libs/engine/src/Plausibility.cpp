// SPDX-License-Identifier: BSD-3-Clause
#include "Plausibility.h"

#include <algorithm>
#include <cmath>

namespace slalom::engine
{
namespace
{
constexpr double kReach_m = 5.0;   // farther away a small error of attitude moves returns too much
constexpr double kApart_m = 0.6;   // surely not the same obstacle
constexpr double kHeight_m = 0.5;  // floor and ceiling look the same from everywhere
constexpr std::size_t kRays = 400;
constexpr int kFewest = 20;
constexpr double kShare = 0.4;

constexpr double kMoverMargin_m = 0.2;

constexpr double kStill_m = 0.005;  // below the noise of any source that lives
constexpr double kAsked_m = 0.5;

/// How far along the ray the map has its first obstacle [m]; nullopt: none within reach.
std::optional<double> mappedRange(const Eigen::Vector3d& origin_L, const Eigen::Vector3d& direction,
                                  const core::DistanceField& map)
{
  const double voxel = map.resolution();
  for (double along = kHeight_m; along < kReach_m;)
  {
    const auto distance = map.distance(origin_L + along * direction, core::UnknownAs::Free);
    if (!distance) return std::nullopt;
    if (*distance < 0.5 * voxel) return along;
    along += std::max(*distance, 0.5 * voxel);
  }
  return std::nullopt;
}

/// How many of how many rays disagree.
struct Tally
{
  int seen = 0, wrong = 0;
  void add(bool disagrees) { ++seen, wrong += disagrees; }
  [[nodiscard]] bool bad() const { return seen >= kFewest && wrong > kShare * seen; }
};

}  // namespace

bool contradicts(const MapJob& scan, const core::DistanceField& map,
                 std::span<const core::MovingObstacle> movers)
{
  const auto on_mover = [&](const Eigen::Vector3d& end)
  {
    return std::any_of(movers.begin(), movers.end(),
                       [&](const core::MovingObstacle& mover)
                       {
                         return (mover.nearest(end, scan.t) - end).norm() <
                                mover.radius_m + mover.uncertainty(scan.t, 2.0) + kMoverMargin_m;
                       });
  };
  Tally appeared, vanished;
  const std::size_t echoes = scan.rays.size() - scan.silent;
  const std::size_t stride = std::max<std::size_t>(1, echoes / kRays);
  for (std::size_t i = 0; i < echoes; i += stride)
  {
    const Eigen::Vector3d origin = scan.rays[i].origin_L.cast<double>();
    const Eigen::Vector3d end = scan.rays[i].end_L.cast<double>();
    const double range = (end - origin).norm();
    if (!std::isfinite(range) || range < kHeight_m || on_mover(end)) continue;
    const auto level = [&scan](double z) { return std::abs(z - scan.p_L.z()) < kHeight_m; };
    if (range < kReach_m && level(end.z()) && map.occupancy(end) != core::Occupancy::Unknown)
      appeared.add(map.distance(end, core::UnknownAs::Free).value_or(0.0) > kApart_m);
    const Eigen::Vector3d direction = (end - origin) / range;
    if (const auto expected = mappedRange(origin, direction, map);
        expected && level(origin.z() + *expected * direction.z()))
      vanished.add(range > *expected + kApart_m);
  }
  return appeared.bad() && vanished.bad();
}

void StandstillWatch::update(const core::VehicleState& state, const core::VelocityCommand& flown,
                             double dt)
{
  if (!anchor_L_ || !((state.p_L - *anchor_L_).norm() < kStill_m))
  {
    anchor_L_ = state.p_L;
    asked_m_ = 0.0;
  }
  else
    asked_m_ += dt * flown.v_W.norm();
}

bool StandstillWatch::stuck() const
{
  return asked_m_ > kAsked_m;
}

}  // namespace slalom::engine
