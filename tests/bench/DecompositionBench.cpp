// SPDX-License-Identifier: BSD-3-Clause
/** Convex decomposition of six pieces of 1 m among 32 000 occupied voxels (forest, 0.1 m), for
 * several local boxes. "Textbook" is the published loop written plainly, in the same run: crop the
 * whole cloud per edge, shrink the ellipsoid to the closest point until none is inside, test every
 * remaining point per plane. */
#include <benchmark/benchmark.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "slalom/core/Rng.h"
#include "slalom/geometry/ConvexDecomposition.h"

namespace
{
using Cloud = std::vector<Eigen::Vector3d>;
using slalom::geometry::DecompositionConfig;
constexpr double kHalfDiagonal = 0.0866;

struct Scene
{
  Eigen::Matrix3Xd path;
  Cloud cloud;
};

/// Six pieces of 1 m through trunks of 0.1 m voxels that keep 0.6 m from the path.
Scene makeScene()
{
  Scene scene;
  scene.path.resize(3, 7);
  for (Eigen::Index i = 0; i < 7; ++i)
  {
    const double x = static_cast<double>(i) - 3.0;
    scene.path.col(i) << x, 0.3 * std::sin(2.0 * x), 1.2;
  }
  slalom::core::Rng rng(1);
  while (scene.cloud.size() < 32000)
  {
    const Eigen::Vector2d trunk(rng.uniform(-6.0, 6.0), rng.uniform(-6.0, 6.0));
    const double radius = rng.uniform(0.15, 0.4);
    for (double x = -0.45; x < 0.5; x += 0.1)
      for (double y = -0.45; y < 0.5; y += 0.1)
        for (double z = -1.0; z < 5.0; z += 0.1)
        {
          if (std::hypot(x, y) > radius) continue;
          const Eigen::Vector3d p(std::round((trunk.x() + x) * 10) / 10 + 0.05,
                                  std::round((trunk.y() + y) * 10) / 10 + 0.05, z + 0.05);
          double away = 1e9;
          for (double s = 0.0; s <= 6.0; s += 0.05)
          {
            const auto k = std::min<Eigen::Index>(5, static_cast<Eigen::Index>(s));
            const Eigen::Vector3d on =
                scene.path.col(k) +
                (s - static_cast<double>(k)) * (scene.path.col(k + 1) - scene.path.col(k));
            away = std::min(away, (p - on).head<2>().norm());
          }
          if (away > 0.6 && scene.cloud.size() < 32000) scene.cloud.push_back(p);
        }
  }
  return scene;
}

const Scene& scene()
{
  static const Scene instance = makeScene();
  return instance;
}

DecompositionConfig boxOf(const benchmark::State& state)
{
  return {static_cast<double>(state.range(0)), static_cast<double>(state.range(1)),
          static_cast<double>(state.range(2)), 0.35 + kHalfDiagonal};
}

std::vector<Cloud> collected(const DecompositionConfig& config)
{
  const Scene& s = scene();
  std::vector<Cloud> clouds(static_cast<std::size_t>(s.path.cols() - 1));
  for (std::size_t i = 0; i < clouds.size(); ++i)
  {
    const auto k = static_cast<Eigen::Index>(i);
    const Eigen::AlignedBox3d box =
        slalom::geometry::localBox(s.path.col(k), s.path.col(k + 1), config);
    for (const Eigen::Vector3d& p : s.cloud)
      if (box.contains(p)) clouds[i].push_back(p);
  }
  return clouds;
}

void count(benchmark::State& state, const std::vector<Cloud>& clouds,
           const std::vector<slalom::geometry::FreePolyhedron>& out)
{
  double points = 0.0, planes = 0.0, held = 0.0;
  for (const Cloud& cloud : clouds) points += static_cast<double>(cloud.size());
  for (const auto& free : out)
  {
    planes += static_cast<double>(free.set.rows());
    held += free.contains_seed ? 1.0 : 0.0;
  }
  state.counters["points_per_edge"] = points / static_cast<double>(clouds.size());
  state.counters["planes_per_edge"] = planes / static_cast<double>(clouds.size());
  state.counters["seeds_held"] = held;
}

/// Obstacles already collected in each edge's local box, as the planner does.
void Collected(benchmark::State& state)
{
  const DecompositionConfig config = boxOf(state);
  const std::vector<Cloud> clouds = collected(config);
  const int threads = static_cast<int>(state.range(3));
  std::vector<slalom::geometry::FreePolyhedron> out;
  for (auto _ : state)
    out = slalom::geometry::decomposeParallel(scene().path, clouds, config, threads);
  count(state, clouds, out);
}

/// Every edge is given all 32 000 points.
void WholeCloud(benchmark::State& state)
{
  const DecompositionConfig config = boxOf(state);
  const std::vector<Cloud> clouds(static_cast<std::size_t>(scene().path.cols() - 1), scene().cloud);
  const int threads = static_cast<int>(state.range(3));
  std::vector<slalom::geometry::FreePolyhedron> out;
  for (auto _ : state)
    out = slalom::geometry::decomposeParallel(scene().path, clouds, config, threads);
  count(state, clouds, out);
}

/// Number of tangent planes of one edge by the published loop.
std::size_t textbook(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Cloud& cloud,
                     const DecompositionConfig& config)
{
  const Eigen::Vector3d middle = 0.5 * (a + b), along = (b - a).normalized();
  const double f = 0.5 * (b - a).norm();
  Eigen::Matrix3d axes;
  axes.col(0) = along;
  axes.col(1) = Eigen::Vector3d::UnitZ().cross(along).normalized();
  axes.col(2) = along.cross(axes.col(1));
  const Eigen::Vector3d box =
      Eigen::Vector3d(f + config.along_m, config.lateral_m, config.vertical_m).array() +
      config.shrink_m;
  Cloud points;
  for (const Eigen::Vector3d& p : cloud)
    if (((axes.transpose() * (p - middle)).cwiseAbs() - box).maxCoeff() <= 0.0) points.push_back(p);

  Eigen::Vector3d semi = Eigen::Vector3d::Constant(f);
  Eigen::Matrix3d turn = axes;
  const auto metric = [&](const Eigen::Vector3d& p)
  { return (turn.transpose() * (p - middle)).cwiseQuotient(semi).squaredNorm(); };
  const auto closest = [&](const Cloud& from)
  {
    return *std::min_element(from.begin(), from.end(),
                             [&](const auto& p, const auto& q) { return metric(p) < metric(q); });
  };
  for (const bool third : {false, true})
  {
    if (third) semi.z() = f;
    for (;;)
    {
      Cloud inside;
      for (const Eigen::Vector3d& p : points)
        if (metric(p) < 1.0 - 1e-9) inside.push_back(p);
      if (inside.empty()) break;
      const Eigen::Vector3d p = axes.transpose() * (closest(inside) - middle);
      if (!third)
      {
        const double roll = std::atan2(p.z(), p.y());
        turn = axes * Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()).toRotationMatrix();
        semi.y() = semi.z() = std::hypot(p.y(), p.z()) / std::sqrt(1.0 - p.x() * p.x() / (f * f));
        continue;
      }
      const Eigen::Vector3d q = turn.transpose() * (axes * p);
      semi.z() =
          std::abs(q.z()) / std::sqrt(1.0 - std::pow(q.x() / f, 2) - std::pow(q.y() / semi.y(), 2));
    }
  }
  std::size_t planes = 0;
  while (!points.empty())
  {
    const Eigen::Vector3d d = closest(points);
    const Eigen::Vector3d local = turn.transpose() * (d - middle);
    const Eigen::Vector3d normal = (turn * local.cwiseQuotient(semi.cwiseAbs2())).normalized();
    Cloud left;
    for (const Eigen::Vector3d& p : points)
      if (normal.dot(p - d) < -1e-10) left.push_back(p);
    points.swap(left);
    ++planes;
  }
  return planes;
}

void Textbook(benchmark::State& state)
{
  const DecompositionConfig config = boxOf(state);
  std::size_t planes = 0;
  for (auto _ : state)
  {
    planes = 0;
    for (Eigen::Index k = 0; k + 1 < scene().path.cols(); ++k)
      planes += textbook(scene().path.col(k), scene().path.col(k + 1), scene().cloud, config);
    benchmark::DoNotOptimize(planes);
  }
  state.counters["planes_per_edge"] = 6.0 + static_cast<double>(planes) / 6.0;
}

/// The dead-zone problem [Paper Eq. (5)]: 40 points onto one polyhedron, most of them outside.
void Project40(benchmark::State& state)
{
  const DecompositionConfig config{2.0, 2.0, 1.0, 0.35 + kHalfDiagonal};
  const Eigen::Vector3d a = scene().path.col(2), b = scene().path.col(3);
  const auto free = slalom::geometry::decompose(a, b, scene().cloud, config);
  slalom::core::Rng rng(2);
  Cloud points;
  int outside = 0;
  while (points.size() < 40)
  {
    const Eigen::Vector3d p = a + rng.uniform3(-1.2, 1.2);
    outside += free.set.contains(p) ? 0 : 1;
    points.push_back(p);
  }
  for (auto _ : state)
    for (const Eigen::Vector3d& p : points)
      benchmark::DoNotOptimize(slalom::geometry::project(p, free.set));
  state.counters["outside"] = outside;
  state.counters["planes"] = static_cast<double>(free.set.rows());
}

void boxes(benchmark::internal::Benchmark* b)
{
  b->Unit(benchmark::kMillisecond)->ArgNames({"along", "side", "up", "threads"})->UseRealTime();
  for (const auto& box : {std::array{1, 1, 1}, {2, 2, 1}, {2, 2, 2}, {4, 4, 2}})
    b->Args({box[0], box[1], box[2], 1});
}

BENCHMARK(Collected)->Apply(boxes)->Args({2, 2, 1, 2})->Args({4, 4, 2, 2});
BENCHMARK(WholeCloud)->Apply(boxes)->Args({2, 2, 1, 2});
BENCHMARK(Textbook)->Apply(boxes);
BENCHMARK(Project40)->Unit(benchmark::kMillisecond);
}  // namespace
