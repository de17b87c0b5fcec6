// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <functional>
#include <memory>

#include "AnalyticField.h"
#include "slalom/core/Rng.h"
#include "slalom/core/VelocityResponse.h"
#include "slalom/safety/OutputGate.h"

namespace slalom::test
{
/// A vehicle behind the gate, and what it came nearest to.
struct GateFlight
{
  core::Vehicle vehicle;  ///< as the gate knows it
  double true_lag_s = vehicle.velocity_lag_s;
  double period_s = 0.05;
  std::shared_ptr<const AnalyticField> field;

  double t = 0.0;
  core::Motion motion;
  core::VelocityCommand last, delayed;
  double least_clearance_m = 1e9;  ///< true distance less the radius

  [[nodiscard]] safety::GateInput input() const
  {
    safety::GateInput in;
    in.t = in.state.t = t;
    in.state.p_L = in.state.p_W = motion.p;
    in.state.v_W = motion.v;
    in.plan_age_s = 0.0;
    in.field = field;
    in.last = last;
    in.dt = period_s;
    return in;
  }

  /// Obeys a command for one period, after the delay.
  void obey(const core::VelocityCommand& command)
  {
    constexpr int kParts = 10;
    core::Vehicle truth = vehicle;
    truth.velocity_lag_s = true_lag_s;
    for (int part = 0; part < kParts; ++part)
    {
      const bool early = (part + 0.5) * period_s / kParts < vehicle.command_delay_s;
      motion = core::held(motion, early ? last : command, period_s / kParts, truth);
      if (field)
        least_clearance_m =
            std::min(least_clearance_m, field->signedDistance(motion.p) - vehicle.radius_m);
    }
    last = command;
    t += period_s;
  }
};

inline constexpr double kForestSize = 8.0;  // [m] half the edge

/// Trunks on a plot of 16 m with a free place of 1 m in the middle; the plot ends are known free.
inline std::shared_ptr<const AnalyticField> makeForest(core::Rng& rng, int trunks, double radius_m)
{
  std::vector<Obstacle> obstacles;
  while (trunks > 0)
  {
    const Eigen::Vector2d centre(rng.uniform(-8, 8), rng.uniform(-8, 8));
    const double radius = rng.uniform(0.08, 0.4);
    if (centre.norm() - radius < radius_m + 0.3) continue;
    obstacles.push_back(VerticalCylinder{centre, radius});
    --trunks;
  }
  return std::make_shared<const AnalyticField>(
      std::move(obstacles),
      Eigen::AlignedBox3d(Eigen::Vector3d(-8, -8, -2), Eigen::Vector3d(8, 8, 2)));
}

}  // namespace slalom::test
