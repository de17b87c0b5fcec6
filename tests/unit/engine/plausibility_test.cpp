// SPDX-License-Identifier: BSD-3-Clause
#include "Plausibility.h"

#include <gtest/gtest.h>

#include <numbers>

#include "AnalyticField.h"
#include "slalom/core/Rng.h"

namespace slalom::engine
{
namespace
{
using Trees = std::vector<test::Obstacle>;

Trees randomTrees(core::Rng& rng)
{
  Trees trees;
  while (trees.size() < 12)
  {
    const Eigen::Vector2d c(rng.uniform(-6.0, 6.0), rng.uniform(-6.0, 6.0));
    if (c.norm() > 1.5) trees.push_back(test::VerticalCylinder{c, 0.3});
  }
  return trees;
}

/// What a vehicle at the origin sees of `world`; `mirrored`: with left and right exchanged.
MapJob look(const test::AnalyticField& world, bool mirrored = false, double yaw_error = 0.0)
{
  MapJob scan;
  for (int a = 0; a < 360; ++a)
  {
    const double azimuth = a * std::numbers::pi / 180.0;
    const Eigen::Vector3d d(std::cos(azimuth), std::sin(azimuth), 0.0);
    double range = 0.0;
    for (double step = 1.0; range < 12.0 && step > 1e-3; range += step)
      step = world.signedDistance(range * d);
    Eigen::Vector3d end = core::fromYaw(yaw_error) * (range * d);
    if (mirrored) end.y() *= -1.0;
    scan.rays.push_back({Eigen::Vector3f::Zero(), end.cast<float>()});
  }
  return scan;
}

TEST(Contradiction, IsAMirroredScanAndNotAnHonestOne)
{
  int mirrored = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    const test::AnalyticField world(randomTrees(rng));
    EXPECT_FALSE(contradicts(look(world), world));
    EXPECT_FALSE(contradicts(look(world, false, 0.05), world)) << "3 degrees off";
    mirrored += contradicts(look(world, true), world);
  }
  EXPECT_GE(mirrored, 24) << "of 30; trees may happen to stand opposite each other";
}

TEST(Contradiction, IsNothingThatAppearsOrGoesAway)
{
  for (std::uint64_t seed = 1; seed <= 30; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    Trees trees = randomTrees(rng);
    const test::AnalyticField world(trees);
    trees.push_back(
        Eigen::AlignedBox3d(Eigen::Vector3d(1.2, -3.0, -3.0), Eigen::Vector3d(1.5, 3.0, 3.0)));
    const test::AnalyticField walled(trees);
    EXPECT_FALSE(contradicts(look(walled), world)) << "a wall where there was none";
    EXPECT_FALSE(contradicts(look(world), walled)) << "no wall where there was one";
    EXPECT_FALSE(contradicts(look(test::AnalyticField({})), world)) << "all gone";
    EXPECT_FALSE(contradicts(MapJob{}, world)) << "nothing seen";
  }
}

TEST(StandstillWatch, NoticesWhatStaysWhereItIsAndOnlyThat)
{
  const core::VelocityCommand go{{1.0, 0.0, 0.0}, 0.0};
  const auto fly = [](const core::VelocityCommand& command, double true_speed, double noise_m)
  {
    core::Rng rng(3);
    StandstillWatch watch;
    for (int k = 0; k < 40; ++k)
    {
      core::VehicleState state;
      state.t = 0.05 * k;
      state.p_L = Eigen::Vector3d(true_speed * state.t, 0.0, 0.0) + rng.normal3(noise_m);
      watch.update(state, command, 0.05);
    }
    return watch;
  };
  EXPECT_FALSE(fly(go, 1.0, 0.0).stuck());
  EXPECT_FALSE(fly(go, 0.0, 0.01).stuck()) << "a source that lives";
  EXPECT_FALSE(fly({}, 0.0, 0.0).stuck()) << "nobody told it to move";
  StandstillWatch watch = fly(go, 0.0, 0.0);
  EXPECT_TRUE(watch.stuck());
  core::VehicleState state;
  watch.update(state, {}, 0.05);
  EXPECT_TRUE(watch.stuck()) << "braking does not end it";
  state.p_L.x() = 0.02;
  watch.update(state, {}, 0.05);
  EXPECT_FALSE(watch.stuck());
}

}  // namespace
}  // namespace slalom::engine
