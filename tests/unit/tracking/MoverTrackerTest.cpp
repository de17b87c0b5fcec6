// SPDX-License-Identifier: BSD-3-Clause
// How movers are found, followed and given up.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <stdexcept>

#include "MovingScene.h"
#include "slalom/tracking/MoverTracker.h"

namespace
{
using slalom::core::MovingObstacle;
using slalom::core::Ray;
using slalom::core::Rng;
using slalom::test::MovingBody;
using slalom::test::SpinningLidar;
using slalom::test::StaticScene;
using slalom::tracking::MoverTracker;
using slalom::tracking::TrackerOutput;
using slalom::tracking::TrackingConfig;
using Vec3 = Eigen::Vector3d;

constexpr double kHeight = 1.5;
const Vec3 kVehicleSpeed(0.5, 0.0, 0.0);

// Trees left and right of where the vehicle and the movers are.
StaticScene avenue(std::uint64_t seed)
{
  Rng rng(seed);
  StaticScene scene;
  for (int i = 0; i < 60; ++i)
  {
    const double side = rng.uniform() < 0.5 ? -1.0 : 1.0;
    scene.trunks.push_back({{rng.uniform(-15.0, 25.0), side * rng.uniform(5.0, 15.0)},
                            rng.uniform(0.1, 0.4),
                            0.0,
                            rng.uniform(2.0, 9.0)});
  }
  return scene;
}

using Step =
    std::function<void(double t, const TrackerOutput&, const std::vector<Ray>&, MoverTracker&)>;

void watch(std::uint64_t seed, const std::vector<MovingBody>& bodies, double duration,
           const Step& step, const StaticScene* given = nullptr)
{
  Rng rng(seed);
  const StaticScene scene = given ? *given : avenue(seed);
  SpinningLidar lidar;
  lidar.azimuths = 600;
  MoverTracker tracker{TrackingConfig{}};
  for (int k = -23; 0.1 * k < duration; ++k)
  {
    const double t = 0.1 * k;
    const Vec3 p = Vec3(0, 0, kHeight) + t * kVehicleSpeed;
    const auto rays = lidar.scan(scene, bodies, rng, t, p, kVehicleSpeed);
    step(t, tracker.update(t, p, rays, nullptr), rays, tracker);
  }
}

const MovingObstacle* near(const std::vector<MovingObstacle>& movers, const Vec3& p)
{
  for (const MovingObstacle& mover : movers)
    if ((mover.p_L - p).head<2>().norm() < 0.8) return &mover;
  return nullptr;
}

// Crossing, coming towards the vehicle, overtaking it.
MovingBody body(int way, double speed, bool person, double radius)
{
  MovingBody b;
  b.radius = person ? 0.2 : radius;
  b.half_height = person ? 0.9 : 0.0;
  const double z = person ? 0.9 : kHeight;
  if (way == 0) b.start = Vec3(4.5, -2.2 * speed, z), b.v = Vec3(0, speed, 0);
  if (way == 1) b.start = Vec3(4.0 + 2.0 * speed, 1.5, z), b.v = Vec3(-speed, 0, 0);
  if (way == 2) b.start = Vec3(-2.5, 1.5, z), b.v = kVehicleSpeed + Vec3(speed, 0, 0);
  return b;
}

struct Score
{
  int confirmed = 0, runs = 0, samples = 0, inside = 0, inside_later = 0, slow = 0;
  double delay = 0.0, error = 0.0;
};

// The body is seen from t = 0 on, by a tracker that has looked at the place for 2 s.
void observe(std::uint64_t seed, MovingBody b, double allowed_delay, Score& score)
{
  double confirmed = -1.0;
  b.appears = -0.05;
  watch(seed, {b}, 4.0,
        [&](double t, const TrackerOutput& out, const std::vector<Ray>&, MoverTracker& tracker)
        {
          EXPECT_LE(out.movers.size(), 1u);
          const Vec3 truth = b.at(t + 0.05);
          const MovingObstacle* mover = near(out.movers, truth);
          if (mover == nullptr) return;
          if (confirmed < 0.0) confirmed = t;
          // The part of the body at the height of flight.
          const auto holds = [&](const MovingObstacle& m, Vec3 at)
          {
            at.z() = kHeight;
            return (m.nearest(at, m.t) - at).norm() + b.radius <= m.radius_m + 2.0 * m.sigma_p_m;
          };
          // However tall, it is no wider than its body.
          if (b.half_height > 0.0)
          {
            EXPECT_LE(mover->radius_m, b.radius + 0.3);
          }
          ++score.samples;
          score.error += (mover->v_L - b.v).norm();
          score.inside += holds(*mover, truth);
          for (const MovingObstacle& later : tracker.at(t + 0.5))
            if (later.id == mover->id) score.inside_later += holds(later, b.at(t + 0.55));
        });
  ++score.runs;
  score.confirmed += confirmed >= 0.0;
  score.slow += confirmed > allowed_delay;
  score.delay += std::max(0.0, confirmed);
}

void expectGood(const Score& score)
{
  EXPECT_EQ(score.confirmed, score.runs);
  EXPECT_EQ(score.slow, 0);
  EXPECT_LT(score.error, 0.2 * score.samples);
  EXPECT_GE(score.inside, 0.95 * score.samples);
  EXPECT_GE(score.inside_later, 0.95 * score.samples);
}

TEST(MoverTracker, FindsSpheresThatCrossOncomeAndOvertake)
{
  for (const double speed : {0.3, 0.6, 1.0, 1.5})
    for (int way = 0; way < 3; ++way)
    {
      SCOPED_TRACE(testing::Message() << speed << " m/s, way " << way);
      Score score;
      for (std::uint64_t seed = 0; seed < 2; ++seed)
        observe(seed, body(way, speed, false, seed % 2 ? 0.3 : 0.5), speed < 0.5 ? 2.5 : 1.3,
                score);
      expectGood(score);
    }
}

TEST(MoverTracker, FindsPeopleThatCrossOncomeAndOvertake)
{
  for (const double speed : {0.3, 0.6, 1.0, 1.5})
    for (int way = 0; way < 3; ++way)
    {
      SCOPED_TRACE(testing::Message() << speed << " m/s, way " << way);
      Score score;
      for (std::uint64_t seed = 10; seed < 12; ++seed)
        observe(seed, body(way, speed, true, 0.0), speed < 0.5 ? 2.5 : 1.3, score);
      expectGood(score);
    }
}

TEST(MoverTracker, KeepsWhatIsHiddenForHalfASecond)
{
  for (std::uint64_t seed = 0; seed < 3; ++seed)
  {
    SCOPED_TRACE(seed);
    MovingBody b = body(0, 1.0, false, 0.4);
    std::vector<MovingBody> parts = {b, b};
    parts[0].vanishes = 2.2, parts[1].appears = 2.7;
    std::uint64_t id = 0;
    int hidden = 0, after = 0;
    watch(seed, parts, 4.0,
          [&](double t, const TrackerOutput& out, const std::vector<Ray>&, MoverTracker&)
          {
            const MovingObstacle* mover = near(out.movers, b.at(t + 0.05));
            if (t < 2.15 && mover) id = mover->id;
            if (t > 2.25 && t < 2.65) hidden += mover && mover->id == id;
            if (t > 2.85) after += mover && mover->id == id;
          });
    EXPECT_GT(id, 0u);
    EXPECT_EQ(hidden, 4);
    EXPECT_GE(after, 10);
  }
}

TEST(MoverTracker, ForgetsWhatVanishesAndLeavesWhatStopsToTheMap)
{
  for (std::uint64_t seed = 0; seed < 3; ++seed)
    for (const bool stops : {false, true})
    {
      SCOPED_TRACE(testing::Message() << seed << (stops ? " stops" : " vanishes"));
      MovingBody b = body(0, 1.0, seed == 1, 0.4);
      (stops ? b.stops : b.vanishes) = 2.2;
      int before = 0, after = 0, masked = 0;
      double sigma = 0.0;
      watch(seed, {b}, 6.0,
            [&](double t, const TrackerOutput& out, const std::vector<Ray>&, MoverTracker&)
            {
              before += t < 2.2 && out.movers.size() == 1;
              if (t > 2.25 && !stops && !out.movers.empty())
              {
                EXPECT_GT(out.movers[0].sigma_p_m, sigma);  // less sure with every scan
                sigma = out.movers[0].sigma_p_m;
              }
              if (t < 2.2 + (stops ? 2.5 : 1.5)) return;
              after += !out.movers.empty();
              masked += std::count(out.on_mover.begin(), out.on_mover.end(), 1) > 0;
            });
      EXPECT_GT(before, 3);
      EXPECT_EQ(after, 0);
      EXPECT_EQ(masked, 0);
    }
}

// Of a confirmed mover nearly all returns are marked, and nothing far from it ever is.
TEST(MoverTracker, MarksTheReturnsOfTheMoverAndNoOthers)
{
  for (int way = 0; way < 3; ++way)
    for (const bool person : {false, true})
    {
      SCOPED_TRACE(testing::Message() << way << person);
      const MovingBody b = body(way, 1.0, person, 0.4);
      int on = 0, marked = 0, elsewhere = 0;
      watch(5, {b}, 4.0,
            [&](double t, const TrackerOutput& out, const std::vector<Ray>& rays, MoverTracker&)
            {
              ASSERT_EQ(out.on_mover.size(), rays.size());
              const Vec3 c = b.at(t + 0.05);
              for (std::size_t i = 0; i < rays.size(); ++i)
              {
                const Vec3 d = rays[i].end_L.cast<double>() - c;
                const double off = d.head<2>().norm() - b.radius;
                const bool body_height = std::fabs(d.z()) < (person ? 0.8 : 0.4);
                if (near(out.movers, c) && off < 0.1 && body_height)
                  ++on, marked += out.on_mover[i];
                elsewhere += off > 0.8 && out.on_mover[i];
              }
            });
      EXPECT_GT(on, 300);
      EXPECT_GT(marked, 0.97 * on);
      EXPECT_EQ(elsewhere, 0);
    }
}

TEST(MoverTracker, IsDeterministicAlsoAfterReset)
{
  const MovingBody b = body(1, 1.0, true, 0.0);
  Rng rng(3);
  SpinningLidar lidar;
  lidar.azimuths = 400;
  const StaticScene scene = avenue(3);
  MoverTracker fresh{TrackingConfig{}}, used{TrackingConfig{}};
  std::vector<std::vector<Ray>> scans;
  for (int k = 0; k < 25; ++k)
    scans.push_back(lidar.scan(scene, {b}, rng, 0.1 * k, Vec3(0, 0, kHeight), Vec3::Zero()));
  for (int k = 0; k < 25; ++k)
    used.update(0.1 * k, Vec3(0, 0, kHeight), scans[static_cast<std::size_t>(24 - k)], nullptr);
  used.reset();
  EXPECT_TRUE(used.at(2.0).empty());
  std::size_t found = 0;
  for (int k = 0; k < 25; ++k)
  {
    const auto& rays = scans[static_cast<std::size_t>(k)];
    const TrackerOutput x = fresh.update(0.1 * k, Vec3(0, 0, kHeight), rays, nullptr);
    const TrackerOutput y = used.update(0.1 * k, Vec3(0, 0, kHeight), rays, nullptr);
    ASSERT_EQ(x.movers.size(), y.movers.size());
    EXPECT_EQ(x.on_mover, y.on_mover);
    for (std::size_t i = 0; i < x.movers.size(); ++i)
    {
      EXPECT_EQ(x.movers[i].p_L, y.movers[i].p_L);
      EXPECT_EQ(x.movers[i].v_L, y.movers[i].v_L);
    }
    found += x.movers.size();
  }
  EXPECT_GT(found, 3u);
}

TEST(MoverTracker, SurvivesNonsense)
{
  Rng rng(1);
  MoverTracker tracker{TrackingConfig{}};
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  double t = 0.0;
  for (int k = 0; k < 60; ++k)
  {
    std::vector<Ray> rays;
    for (int i = rng.integer(0, 300); i > 0; --i)
    {
      Ray ray{Eigen::Vector3f::Zero(), rng.uniform3(-5.0, 5.0).cast<float>()};
      if (rng.uniform() < 0.1) ray.end_L.x() = rng.uniform() < 0.5 ? nan : inf;
      if (rng.uniform() < 0.1) ray.origin_L.y() = rng.uniform() < 0.5 ? nan : -1e30f;
      if (rng.uniform() < 0.1) ray.end_L *= 1e20f;
      rays.push_back(ray);
    }
    const double at = rng.uniform() < 0.2 ? std::numeric_limits<double>::quiet_NaN() : t;
    const Vec3 p = rng.uniform() < 0.2 ? Vec3(0, 1e300, 0) : Vec3(0, 0, 1);
    const TrackerOutput out = tracker.update(at, p, rays, nullptr);
    EXPECT_EQ(out.on_mover.size(), rays.size());
    for (const MovingObstacle& mover : out.movers)
      EXPECT_TRUE(mover.p_L.allFinite() && mover.v_L.allFinite());
    t += rng.uniform(-0.05, 0.3);
  }
}

TEST(MoverTracker, RefusesConfigsAndCanBeSwitchedOff)
{
  TrackingConfig config;
  config.range_m = -1.0;
  EXPECT_THROW(MoverTracker{config}, std::invalid_argument);
  config = {};
  config.min_range_m = 4.0, config.range_m = 3.0;
  EXPECT_THROW(MoverTracker{config}, std::invalid_argument);
  config = {};
  config.evidence = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(MoverTracker{config}, std::invalid_argument);
  config = {};
  config.enabled = false;
  MoverTracker off(config);
  const std::vector<Ray> rays(5, Ray{Eigen::Vector3f::Zero(), Eigen::Vector3f::Ones()});
  EXPECT_EQ(off.update(0.0, Vec3::Zero(), rays, nullptr).on_mover.size(), 5u);
}

}  // namespace
