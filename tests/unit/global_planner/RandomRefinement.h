// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "RefinementInstances.h"
#include "slalom/core/Rng.h"
#include "slalom/global_planner/RefinementCost.h"

namespace slalom::global_planner::test
{
/// A window as the planner makes them: R hurries along a winding way, the start lies beside it, and
/// pushes pull at random points.
inline RefinementCost::Problem randomProblem(core::Rng& rng, int most_points = 40)
{
  RefinementCost::Problem problem;
  const Eigen::Index n = rng.integer(9, most_points);
  problem.points.resize(3, n);
  problem.reference.resize(3, n);
  problem.fit_weight.resize(n);
  Eigen::Vector3d p = rng.uniform3(-2.0, 2.0);
  for (Eigen::Index i = 0; i < n; ++i)
  {
    p += rng.uniform3(-0.4, 0.4);
    problem.reference.col(i) = p;
    problem.points.col(i) = p + rng.uniform3(-0.5, 0.5);
    problem.fit_weight[i] = rng.integer(0, 1);
  }
  problem.first_free = 4;
  problem.last_free = n - 4;
  problem.knot_span = rng.uniform(0.1, 0.4);
  problem.obstacle_gain = rng.uniform(1.0, 4.0);
  problem.tail = rng.integer(0, 3) == 0 ? HingeTail::Cubic : HingeTail::Quadratic;
  for (int k = rng.integer(0, 20); k > 0; --k)
  {
    const Eigen::Index i = rng.integer(4, static_cast<int>(n) - 4);
    problem.pushes.push_back({i, problem.points.col(i) + rng.uniform3(-1.5, 1.5), rng.direction()});
  }
  return problem;
}

/// The evaluation instances as problems of RefinementCost: their J_obs has the cube everywhere.
struct InstanceProblem
{
  explicit InstanceProblem(const slalom::test::RefinementInstance& instance)
  {
    config.lambda_smooth = config.lambda_feas = 0.2;
    config.lambda_obs = 0.6;
    config.lambda_fit = 0.0;
    config.clearance_m = 0.8;
    vehicle.max_speed_mps = 1.2;
    vehicle.max_acceleration_mps2 = 0.5;
    problem.points = problem.reference = instance.points;
    problem.fit_weight = Eigen::VectorXd::Zero(instance.points.cols());
    problem.first_free = 3;
    problem.last_free = instance.points.cols() - 4;
    problem.knot_span = 0.1;
    problem.tail = HingeTail::Cubic;
    for (const auto& pull : instance.pulls)
      problem.pushes.push_back({pull.point, pull.base, pull.direction});
    const Eigen::Index free = problem.last_free - problem.first_free + 1;
    lower = instance.lower.replicate(free, 1);
    upper = instance.upper.replicate(free, 1);
  }
  [[nodiscard]] RefinementCost cost() const { return {problem, config, vehicle}; }

  GlobalPlannerConfig config;
  core::Vehicle vehicle;
  RefinementCost::Problem problem;
  Eigen::VectorXd lower, upper;
};

}  // namespace slalom::global_planner::test
