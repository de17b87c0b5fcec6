// SPDX-License-Identifier: BSD-3-Clause
// What panoramas may say of a point.
#include <gtest/gtest.h>

#include <limits>

#include "MovingScene.h"
#include "RangeHistory.h"

namespace
{
using slalom::core::Ray;
using slalom::core::Rng;
using slalom::test::SpinningLidar;
using slalom::test::StaticScene;
using slalom::tracking::TrackingConfig;
using slalom::tracking::detail::RangeHistory;
using slalom::tracking::detail::Seen;
using Vec3 = Eigen::Vector3d;

// A point on a trunk is never free for whom the trunk was in view, from wherever it is looked at
// later; a point well in front of everything is never anything else.
TEST(RangeHistory, SurfacesAreNeverFreeAndFreeSpaceIs)
{
  for (std::uint64_t seed = 0; seed < 6; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    StaticScene scene;
    scene.ground = false;
    for (int i = 0; i < 16; ++i)
    {
      const double a = rng.uniform(0.0, 6.28), r = rng.uniform(2.0, 8.0);
      scene.trunks.push_back({{r * std::cos(a), r * std::sin(a)}, rng.uniform(0.03, 0.3), -9, 9});
    }
    SpinningLidar lidar;
    lidar.azimuths = 900;
    RangeHistory history{TrackingConfig{}};
    int surfaces = 0, wrong = 0, open = 0, missed = 0;
    for (int k = 0; k < 12; ++k)
    {
      const Vec3 p(0.1 * k - 0.6, 0.02 * k, 0.1 * std::sin(k));
      const auto rays = lidar.scan(scene, {}, rng, 0.1 * k, p, Vec3(1.0, 0.2, 0.0));
      history.add(0.1 * k, p.cast<float>(), rays);
      for (std::size_t i = 0; i < rays.size(); i += 13)
      {
        if ((rays[i].end_L - rays[i].origin_L).norm() < 1.5f) continue;
        for (int age = 0; age < history.size(); ++age)
        {
          ++surfaces;
          wrong += history.look(age, rays[i].end_L) == Seen::Free;
        }
        const Eigen::Vector3f before =
            rays[i].end_L - 0.6f * (rays[i].end_L - rays[i].origin_L).normalized();
        ++open;
        missed += history.look(0, before) != Seen::Free;
      }
    }
    EXPECT_GT(surfaces, 5000);
    EXPECT_LT(wrong, surfaces / 200);
    EXPECT_LT(missed, open / 4);  // the rest is beside something nearer
  }
}

TEST(RangeHistory, PartsOfATurnAreOnePanoramaAndNonsenseIsNoRay)
{
  RangeHistory history{TrackingConfig{}};
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  const Eigen::Vector3f o = Eigen::Vector3f::Zero();
  history.add(0.0, o, std::vector<Ray>{{o, {5, 0, 0}}, {o, {nan, 0, 0}}, {o, {inf, 0, 0}}});
  history.add(0.05, o, std::vector<Ray>{{o, {0, 5, 0}}, {o, {0, 0, 5}}, {o, o}});
  ASSERT_EQ(history.size(), 1);
  EXPECT_EQ(history.look(0, {3, 0, 0}), Seen::Free);
  EXPECT_EQ(history.look(0, {0, 3, 0}), Seen::Free);
  EXPECT_EQ(history.look(0, {5.05f, 0, 0}), Seen::Surface);
  EXPECT_EQ(history.look(0, {7, 0, 0}), Seen::Hidden);
  EXPECT_EQ(history.look(0, {-3, 0, 0}), Seen::Nothing);
  EXPECT_EQ(history.look(0, {nan, 0, 0}), Seen::Nothing);
  history.add(0.1, o, {});
  EXPECT_EQ(history.size(), 2);
  EXPECT_EQ(history.look(0, {3, 0, 0}), Seen::Nothing);
  EXPECT_EQ(history.look(1, {3, 0, 0}), Seen::Free);
}

}  // namespace
