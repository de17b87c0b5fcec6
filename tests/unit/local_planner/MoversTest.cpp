// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "ClosedLoop.h"
#include "KeepOuts.h"
#include "slalom/core/Rng.h"

namespace
{
using Eigen::Vector3d;
using slalom::core::MovingObstacle;
using slalom::core::Rng;
using slalom::core::Vehicle;
using namespace slalom::local_planner;
using slalom::test::ClosedLoop;
using slalom::test::fieldOf;
using slalom::test::straightReference;

MovingObstacle sphere(const Vector3d& p, const Vector3d& v, double radius)
{
  MovingObstacle mover;
  mover.p_L = p;
  mover.v_L = v;
  mover.radius_m = radius;
  return mover;
}

/// Least distance between the surfaces of vehicle and mover on a flight of 16 m along x.
double flyPast(const MovingObstacle& mover, bool warned)
{
  ClosedLoop loop(straightReference(Vector3d(0, 0, 1.5), Vector3d(1.0, 0, 0), 16.0), fieldOf({}));
  double least = 1e9;
  loop.input.movers.assign(warned ? 1 : 0, mover);
  loop.fly(18.0,
           [&](const auto& output)
           {
             EXPECT_TRUE(output.command.v_W.allFinite());
             const double gap = (loop.state.p_L - mover.at(loop.state.t)).norm() - mover.radius_m -
                                Vehicle{}.radius_m;
             least = std::min(least, gap);
           });
  if (warned)
  {
    EXPECT_GT(loop.state.p_L.x(), 12.0) << "goes on afterwards";
  }
  return least;
}

TEST(Movers, AreAvoidedCrossingOncomingAndOvertaken)
{
  int met = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const double speeds[] = {0.3, 0.6, 1.0, 1.5};
    const double speed = speeds[seed % 4], radius = rng.uniform(0.3, 0.5);
    // They meet at x = 6 after 6 s if nobody gives way.
    const double course = seed % 3 == 0   ? std::numbers::pi
                          : seed % 3 == 1 ? rng.uniform(0.9, 2.2) * (seed % 2 ? 1.0 : -1.0)
                                          : 0.0;
    const Vector3d v = speed * Vector3d(std::cos(course), std::sin(course), 0.0);
    const Vector3d meeting(6.0, rng.uniform(-0.3, 0.3), 1.5);
    if (seed % 3 == 2 && speed >= 0.9) continue;  // runs away
    const MovingObstacle mover = sphere(meeting - 6.0 * v, v, radius);
    met += flyPast(mover, false) < 0.0;
    EXPECT_GE(flyPast(mover, true), 0.05);
  }
  EXPECT_GE(met, 40) << "the encounters must be real";
}

/// Least altitude on a flight past a ball that comes from ahead and above, so that the way round it
/// is below.
double lowestPassing(double height, bool limited)
{
  ClosedLoop loop(straightReference(Vector3d(0, 0, 0.6), Vector3d(1.0, 0, 0), 16.0), fieldOf({}));
  loop.input.movers = {sphere(Vector3d(9.0, 0.0, height), Vector3d(-0.5, 0.0, 0.0), 0.5)};
  if (limited) loop.input.airspace_L.min().z() = 0.3;
  double lowest = 1e9;
  loop.fly(12.0, [&](const auto&) { lowest = std::min(lowest, loop.state.p_L.z()); });
  return lowest;
}

TEST(Movers, AreNotDodgedOutOfTheAirspace)
{
  int below = 0;
  for (const double height : {1.0, 1.2, 1.4, 1.6})
  {
    SCOPED_TRACE(height);
    below += lowestPassing(height, false) < 0.25;
    EXPECT_GE(lowestPassing(height, true), 0.3 - 0.01);
  }
  EXPECT_GE(below, 2) << "without a limit it must go lower";
}

/// Who walks is passed at the side, not above or below.
TEST(Movers, UprightOnesPushAsideOnly)
{
  for (std::uint64_t seed = 1; seed <= 100; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    LocalPlannerInput input;
    MovingObstacle mover = sphere(rng.uniform3(-2, 2), rng.uniform3(-1, 1), 0.4);
    mover.p_L.z() = mover.v_L.z() = 0.0;
    mover.half_axis_m = 0.9;
    input.movers = {mover};
    const LocalPlannerConfig config;
    Eigen::Matrix4Xd inputs = Eigen::Matrix4Xd::Zero(4, config.horizon);
    const auto expected = detail::rollOut(0.0, {}, inputs, detail::Model{Vehicle{}, config.step_s});
    for (const auto& stage : detail::keepOuts(input, expected, config, Vehicle{}).stages)
      for (const auto& row : stage) EXPECT_NEAR(row.normal.z(), 0.0, 1e-12);
  }
}

TEST(Movers, UncertaintyGrowsTheRoomAndIsBounded)
{
  MovingObstacle mover = sphere(Vector3d::Zero(), Vector3d::UnitX(), 0.4);
  const Vehicle vehicle;
  EXPECT_NEAR(detail::contactDistance(mover, 1.0, vehicle), 0.4 + vehicle.radius_m, 1e-12);
  mover.sigma_p_m = 0.1;
  mover.sigma_v_mps = 0.2;
  EXPECT_NEAR(detail::contactDistance(mover, 0.0, vehicle), 0.6 + vehicle.radius_m, 1e-12);
  EXPECT_GT(detail::contactDistance(mover, 0.5, vehicle),
            detail::contactDistance(mover, 0.0, vehicle));
  EXPECT_LE(detail::contactDistance(mover, 1e3, vehicle), 0.9 + vehicle.radius_m + 1e-12);
}

TEST(Movers, RowsPointAwayAndTouchTheSphereThatMoves)
{
  for (std::uint64_t seed = 1; seed <= 200; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    LocalPlannerConfig config;
    LocalPlannerInput input;
    input.state.t = rng.uniform(0.0, 50.0);
    MovingObstacle mover = sphere(rng.uniform3(-2, 2), rng.uniform3(-1, 1), rng.uniform(0.2, 0.6));
    mover.t = input.state.t - rng.uniform(0.0, 0.5);
    input.movers = {mover};
    const detail::Model model{Vehicle{}, config.step_s};
    Eigen::Matrix4Xd inputs(4, config.horizon);
    inputs.colwise() = Eigen::Vector4d(rng.uniform(-1, 1), rng.uniform(-1, 1), 0, 0);
    const auto expected = detail::rollOut(input.state.t, {}, inputs, model);
    const auto rows = detail::keepOuts(input, expected, config, Vehicle{});
    for (std::size_t k = 0; k < rows.stages.size(); ++k)
    {
      ASSERT_LE(rows.stages[k].size(), static_cast<std::size_t>(detail::mostRows(config)));
      for (const auto& row : rows.stages[k])
      {
        const double time = input.state.t + 0.1 * static_cast<double>(k + 1);
        EXPECT_NEAR(row.normal.norm(), 1.0, 1e-9);
        EXPECT_NEAR(row.offset - row.normal.dot(mover.at(time)),
                    detail::contactDistance(mover, time, Vehicle{}) + config.mover_margin_m, 1e-9);
      }
    }
  }
}

}  // namespace
