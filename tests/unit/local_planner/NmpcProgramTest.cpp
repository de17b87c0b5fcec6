// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "NlpCheck.h"
#include "NmpcProgram.h"
#include "slalom/core/Rng.h"

namespace
{
using Eigen::Vector4d;
using Eigen::VectorXd;
using slalom::core::Deadline;
using slalom::core::Rng;
using slalom::core::Vehicle;
using slalom::local_planner::LocalPlannerConfig;
using namespace slalom::local_planner::detail;

void randomise(NmpcProgram& program, Rng& rng)
{
  const auto vector = [&](double size) -> Vector4d
  { return Vector4d::NullaryExpr([&] { return rng.uniform(-size, size); }); };
  NmpcData& data = program.data;
  data.state = vector(20.0);
  data.last_input = vector(0.5);
  data.elapsed = 0.05;
  Vector4d at = data.state + vector(0.3);
  const Vector4d velocity = vector(1.0);
  for (int k = 0; k <= program.stages(); ++k)
  {
    data.state_reference.col(k) = at;
    if (k < program.stages()) data.input_reference.col(k) = velocity;
    at += 0.1 * velocity;
  }
  for (std::size_t i = 0; i < data.keep_outs.size(); ++i)
  {
    const Eigen::Vector3d p = data.state.head<3>();
    const Eigen::Vector3d normal = rng.direction();
    data.keep_outs[i] = {normal, normal.dot(p) + rng.uniform(-1.0, 0.3)};
  }
}

TEST(NmpcProgram, DerivativesAreExact)
{
  Rng rng(1);
  for (int rows = 0; rows <= 3; ++rows)
    for (int repeat = 0; repeat < 5; ++repeat)
    {
      SCOPED_TRACE(rows);
      LocalPlannerConfig config;
      config.horizon = 6;
      NmpcProgram program(config, Vehicle{}, rows);
      randomise(program, rng);
      const VectorXd x = VectorXd::NullaryExpr(program.variables(), [&] { return rng.normal(); });
      const VectorXd lambda =
          VectorXd::NullaryExpr(program.constraints(), [&] { return rng.normal(); });
      slalom::test::expectExactDerivatives(program, x, rng.uniform(0.0, 2.0), lambda);
    }
}

TEST(NmpcProgram, SolutionsObeyDynamicsLimitsAndObstacles)
{
  LocalPlannerConfig config;
  const Vehicle vehicle;
  std::vector<NmpcProgram> programs;
  for (int rows = 0; rows <= 2; ++rows) programs.emplace_back(config, vehicle, rows);
  slalom::optim::IpoptSolver solver({});
  for (std::uint64_t seed = 1; seed <= 100; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    NmpcProgram& program = programs[seed % 3];
    randomise(program, rng);
    const auto held = program.data.state.replicate(1, program.stages() + 1);
    slalom::optim::NlpPoint start;
    start.x = program.pack(held, Eigen::Matrix4Xd::Zero(4, program.stages()));
    const auto solution = solver.solve(program, start, Deadline::none());
    ASSERT_TRUE(solution.report.converged()) << solution.report.message;
    const Eigen::Matrix4Xd x = program.statesOf(solution.point.x);
    const Eigen::Matrix4Xd u = program.inputsOf(solution.point.x);
    EXPECT_EQ(x.col(0), program.data.state);
    Vector4d before = program.data.last_input;
    for (int k = 0; k < program.stages(); ++k)
    {
      EXPECT_LE((x.col(k + 1) - x.col(k) - 0.1 * u.col(k)).norm(), 1e-4);
      EXPECT_LE(u.col(k).head<3>().cwiseAbs().maxCoeff(), vehicle.max_speed_mps + 1e-9);
      EXPECT_LE(std::abs(u(3, k)), vehicle.max_yaw_rate_radps + 1e-9);
      const double dt = k == 0 ? program.data.elapsed : config.step_s;
      EXPECT_LE((u.col(k) - before).head<3>().cwiseAbs().maxCoeff(),
                vehicle.max_acceleration_mps2 * dt + 1e-4);
      before = u.col(k);
      for (int j = 0; j < program.rowsPerStage(); ++j)
      {
        const KeepOut& row = program.data.keep_outs[k * program.rowsPerStage() + j];
        EXPECT_GE(row.normal.dot(x.col(k + 1).head<3>()),
                  row.offset - program.worstSlack(solution.point.x) - 1e-4);
      }
    }
  }
}

}  // namespace
