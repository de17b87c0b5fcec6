// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/engine/Mission.h"

#include <cstdio>
#include <stdexcept>
#include <string>

#include "slalom/engine/EngineConfig.h"

namespace slalom::engine
{
namespace
{
constexpr Eigen::Index kMostWaypoints = 10000;
constexpr double kFarthest_m = 1e6;
constexpr double kMostSpans = 1e6;

std::string text(double value)
{
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.7g", value);
  return digits;
}

void require(bool holds, const std::string& rule)
{
  if (!holds) throw std::invalid_argument(rule);
}
}  // namespace

void check(const Mission& mission, const EngineConfig& config)
{
  const Eigen::Matrix3Xd& points = mission.waypoints_W;
  const Eigen::Index count = points.cols();
  require(count > 0, "a mission needs at least one waypoint");
  require(count <= kMostWaypoints, "a mission of " + std::to_string(count) +
                                       " waypoints, at most " + std::to_string(kMostWaypoints) +
                                       " can be flown");
  for (Eigen::Index i = 0; i < count; ++i)
    require((points.col(i).array().abs() <= kFarthest_m).all(),
            "waypoint " + text(points(0, i)) + "," + text(points(1, i)) + "," + text(points(2, i)) +
                ": coordinates must be finite and within +-" + text(kFarthest_m) + " m");
  const double length =
      (points.rightCols(count - 1) - points.leftCols(count - 1)).colwise().norm().sum();
  require(length <= config.mission.max_length_m,
          "a mission of " + text(length) +
              " m, at most mission.max_length_m = " + text(config.mission.max_length_m) + " m");
  const double spans = length / config.planned().max_speed_mps / config.mission.knot_span_s;
  require(spans <= kMostSpans,
          "a mission of " + text(length) + " m at vehicle.max_speed_mps x mission.speed_share = " +
              text(config.planned().max_speed_mps) + " m/s takes " + text(spans) +
              " spans of mission.knot_span_s = " + text(config.mission.knot_span_s) +
              " s, at most " + text(kMostSpans) + " can be flown");
}

}  // namespace slalom::engine
