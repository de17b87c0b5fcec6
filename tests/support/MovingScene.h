// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "slalom/core/PointCloud.h"
#include "slalom/core/Rng.h"

namespace slalom::test
{
/// A sphere, or an upright cylinder, that moves on in a straight line while it exists.
struct MovingBody
{
  Eigen::Vector3d start;  ///< [m] centre at t = 0
  Eigen::Vector3d v;      ///< [m/s]
  double radius = 0.3;
  double half_height = 0.0;  ///< of a cylinder; 0 is a sphere
  double appears = -1e9, vanishes = 1e9;
  double stops = 1e9;  ///< [s] it stands from here on

  [[nodiscard]] Eigen::Vector3d at(double t) const { return start + std::min(t, stops) * v; }
  [[nodiscard]] bool exists(double t) const { return t >= appears && t < vanishes; }
  /// Radius of the ball around the centre that holds it.
  [[nodiscard]] double reach() const { return std::hypot(radius, half_height); }
};

/// Things at rest: upright cylinders, small balls, clouds of leaves that stop a ray anywhere,
/// ground.
struct StaticScene
{
  struct Trunk
  {
    Eigen::Vector2d centre;
    double radius, low = 0.0, high = 8.0;
  };
  struct Ball
  {
    Eigen::Vector3d centre;
    double radius;
  };
  struct Foliage
  {
    Eigen::Vector3d centre;
    double radius;
    double per_metre;  ///< probability of a return per metre inside
  };
  std::vector<Trunk> trunks;
  std::vector<Ball> balls;
  std::vector<Foliage> crowns;
  bool ground = true;  ///< at z = 0
};

/// Distances along a ray p + s d, |d| = 1, to the first intersection; infinity if there is none.
inline double raySphere(const Eigen::Vector3d& p, const Eigen::Vector3d& d,
                        const Eigen::Vector3d& centre, double radius, double* exit = nullptr)
{
  const double along = d.dot(centre - p);
  const double inside = radius * radius - (centre - p - along * d).squaredNorm();
  if (inside < 0.0 || along < 0.0) return std::numeric_limits<double>::infinity();
  if (exit) *exit = along + std::sqrt(inside);
  return along - std::sqrt(inside);
}
inline double rayCylinder(const Eigen::Vector3d& p, const Eigen::Vector3d& d,
                          const Eigen::Vector2d& centre, double radius, double low, double high)
{
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const Eigen::Vector2d to = centre - p.head<2>();
  const double planar = d.head<2>().squaredNorm();
  if (planar < 1e-12) return kNever;
  const double along = to.dot(d.head<2>()) / planar;
  const double inside = radius * radius - (to - along * d.head<2>()).squaredNorm();
  if (inside < 0.0 || along < 0.0) return kNever;
  const double s = along - std::sqrt(inside / planar);
  const double z = p.z() + s * d.z();
  if (z >= low && z <= high) return s;
  // Through the lid or the bottom.
  const double cap = d.z() < 0.0 ? high : low;
  if (std::fabs(d.z()) < 1e-12 || (d.z() < 0.0) != (z > high)) return kNever;
  const double through = (cap - p.z()) / d.z();
  const bool on_cap = (to - through * d.head<2>()).norm() <= radius;
  return on_cap && through > 0.0 ? through : kNever;
}

/** A spinning lidar with 16 rings 2 deg apart on a vehicle that moves during the turn. */
struct SpinningLidar
{
  int azimuths = 1800;
  double turn_s = 0.1;
  double sigma_range_m = 0.02;
  double sigma_position_m = 0.02;  ///< of the estimated vehicle position, per scan and axis
  double sigma_tilt_rad = 0.003;   ///< of the estimated roll and pitch, per scan
  double max_range_m = 60.0;

  /** The rays that the tracker would be given.
   *  @param p, v     vehicle at time t, and its velocity
   *  @param tilt     true roll and pitch
   *  @param first, last  part of the turn, in shares of it */
  [[nodiscard]] std::vector<core::Ray> scan(const StaticScene& scene,
                                            const std::vector<MovingBody>& bodies, core::Rng& rng,
                                            double t, const Eigen::Vector3d& p,
                                            const Eigen::Vector3d& v,
                                            const Eigen::Vector2d& tilt = {0, 0},
                                            double first = 0.0, double last = 1.0) const
  {
    const Candidates near(scene, p);
    const Eigen::Vector3d offset = rng.normal3(sigma_position_m);
    const Eigen::Matrix3d wrong =
        (Eigen::AngleAxisd(sigma_tilt_rad * rng.normal(), Eigen::Vector3d::UnitX()) *
         Eigen::AngleAxisd(sigma_tilt_rad * rng.normal(), Eigen::Vector3d::UnitY()))
            .toRotationMatrix();
    const Eigen::Matrix3d attitude = (Eigen::AngleAxisd(tilt.x(), Eigen::Vector3d::UnitX()) *
                                      Eigen::AngleAxisd(tilt.y(), Eigen::Vector3d::UnitY()))
                                         .toRotationMatrix();
    std::vector<core::Ray> rays;
    rays.reserve(static_cast<std::size_t>(azimuths) * 16);
    for (int k = static_cast<int>(first * azimuths); k < static_cast<int>(last * azimuths); ++k)
    {
      const double fired = turn_s * k / azimuths;
      const Eigen::Vector3d from = p + fired * v;
      const double a = 2.0 * std::numbers::pi * k / azimuths;
      for (int ring = 0; ring < 16; ++ring)
      {
        const double e = (2 * ring - 15) * std::numbers::pi / 180.0;
        const Eigen::Vector3d d =
            attitude *
            Eigen::Vector3d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
        double s = near.cast(scene, rng, from, d);
        for (const MovingBody& body : bodies) s = std::min(s, cast(body, t + fired, from, d));
        if (!(s < max_range_m)) continue;
        const Eigen::Vector3d seen = wrong * d * (s + sigma_range_m * rng.normal());
        rays.push_back({(from + offset).cast<float>(), (from + offset + seen).cast<float>()});
      }
    }
    return rays;
  }

 private:
  static double cast(const MovingBody& body, double t, const Eigen::Vector3d& from,
                     const Eigen::Vector3d& d)
  {
    if (!body.exists(t)) return std::numeric_limits<double>::infinity();
    const Eigen::Vector3d c = body.at(t);
    if (body.half_height <= 0.0) return raySphere(from, d, c, body.radius);
    return rayCylinder(from, d, c.head<2>(), body.radius, c.z() - body.half_height,
                       c.z() + body.half_height);
  }

  // Things by the degree in which they may be met, as seen from near p.
  struct Candidates
  {
    struct Item
    {
      int kind, index;
    };
    std::array<std::vector<Item>, 360> by_degree;

    Candidates(const StaticScene& scene, const Eigen::Vector3d& p)
    {
      const auto put = [&](const Eigen::Vector2d& centre, double radius, Item item)
      {
        const Eigen::Vector2d to = centre - p.head<2>();
        const double wide = radius + 0.3;  // the vehicle moves during a turn, and tilts
        const double half = to.norm() <= wide ? 180.0 : std::asin(wide / to.norm()) * 57.2958 + 1.5;
        const double middle = std::atan2(to.y(), to.x()) * 57.2958;
        for (int degree = static_cast<int>(std::floor(middle - half));
             degree <= static_cast<int>(std::floor(middle + half)); ++degree)
          by_degree[static_cast<std::size_t>((degree + 720) % 360)].push_back(item);
      };
      for (int i = 0; i < static_cast<int>(scene.trunks.size()); ++i)
        put(scene.trunks[static_cast<std::size_t>(i)].centre,
            scene.trunks[static_cast<std::size_t>(i)].radius, {0, i});
      for (int i = 0; i < static_cast<int>(scene.balls.size()); ++i)
        put(scene.balls[static_cast<std::size_t>(i)].centre.head<2>(),
            scene.balls[static_cast<std::size_t>(i)].radius, {1, i});
      for (int i = 0; i < static_cast<int>(scene.crowns.size()); ++i)
        put(scene.crowns[static_cast<std::size_t>(i)].centre.head<2>(),
            scene.crowns[static_cast<std::size_t>(i)].radius, {2, i});
    }

    [[nodiscard]] double cast(const StaticScene& scene, core::Rng& rng, const Eigen::Vector3d& from,
                              const Eigen::Vector3d& d) const
    {
      double s =
          scene.ground && d.z() < 0.0 ? -from.z() / d.z() : std::numeric_limits<double>::infinity();
      const int degree = static_cast<int>(std::floor(std::atan2(d.y(), d.x()) * 57.2958)) + 360;
      for (const Item& item : by_degree[static_cast<std::size_t>(degree % 360)])
      {
        const std::size_t i = static_cast<std::size_t>(item.index);
        if (item.kind == 0)
        {
          const StaticScene::Trunk& trunk = scene.trunks[i];
          s = std::min(s, rayCylinder(from, d, trunk.centre, trunk.radius, trunk.low, trunk.high));
        }
        else if (item.kind == 1)
          s = std::min(s, raySphere(from, d, scene.balls[i].centre, scene.balls[i].radius));
        else
        {
          double exit = 0.0;
          const StaticScene::Foliage& crown = scene.crowns[i];
          const double enter = raySphere(from, d, crown.centre, crown.radius, &exit);
          if (!(enter < s)) continue;
          const double depth = -std::log(1.0 - rng.uniform()) / crown.per_metre;
          if (std::max(enter, 0.0) + depth < exit) s = std::min(s, std::max(enter, 0.0) + depth);
        }
      }
      return s;
    }
  };
};

/** A forest at rest with everything that has deceived trackers: thin poles, trunks behind trunks,
 *  bushes of balls, crowns and shrubs that stop rays at random depths, branches one ring thick. */
[[nodiscard]] inline StaticScene difficultForest(std::uint64_t seed, double half_length,
                                                 double half_width, double trees_per_m2 = 0.12)
{
  core::Rng rng(seed);
  StaticScene scene;
  const double area = 4.0 * half_length * half_width;
  const auto place = [&](double free)
  {
    Eigen::Vector2d c;
    do c = {rng.uniform(-half_length, half_length), rng.uniform(-half_width, half_width)};
    while (std::fabs(c.y()) < free);
    return c;
  };
  for (int i = 0; i < trees_per_m2 * area; ++i)
  {
    const double height = rng.uniform() < 0.3 ? rng.uniform(1.0, 3.0) : rng.uniform(4.0, 10.0);
    scene.trunks.push_back({place(0.9), rng.uniform(0.1, 0.35), 0.0, height});
  }
  for (int i = 0; i < 0.04 * area; ++i)
    scene.trunks.push_back({place(0.8), rng.uniform(0.015, 0.05), 0.0, rng.uniform(1.0, 4.0)});
  for (int i = 0; i < 0.02 * area; ++i)
  {
    const Eigen::Vector2d c = place(1.5);
    const double radius = rng.uniform(0.3, 1.0);
    scene.crowns.push_back({{c.x(), c.y(), rng.uniform(0.5, 3.0)}, radius, rng.uniform(0.5, 4.0)});
  }
  for (int i = 0; i < 0.02 * area; ++i)
  {
    const Eigen::Vector2d c = place(1.5);
    const Eigen::Vector3d centre(c.x(), c.y(), rng.uniform(0.5, 3.0));
    for (int k = 0; k < 25; ++k)
      scene.balls.push_back({centre + rng.uniform3(-0.6, 0.6), rng.uniform(0.03, 0.08)});
  }
  for (int i = 0; i < 0.01 * area; ++i)
  {
    const Eigen::Vector2d c = place(2.0);
    const Eigen::Vector3d centre(c.x(), c.y(), rng.uniform(1.0, 2.5));
    Eigen::Vector3d along = rng.direction();
    along.z() *= 0.2;
    for (int k = -12; k <= 12; ++k)
      scene.balls.push_back({centre + 0.06 * k * along.normalized(), 0.04});
  }
  return scene;
}

}  // namespace slalom::test
