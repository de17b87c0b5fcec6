// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/geometry/ConvexDecomposition.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <stdexcept>
#include <string>
#include <thread>

#include "FreeSpace.h"

namespace slalom::geometry
{
namespace
{
void check(const DecompositionConfig& config)
{
  const auto positive = [](double value, const char* name)
  {
    if (!(value > 0.0) || !std::isfinite(value))
      throw std::invalid_argument(std::string("DecompositionConfig: ") + name + " = " +
                                  std::to_string(value) + " m, must be positive and finite");
  };
  positive(config.along_m, "along_m");
  positive(config.lateral_m, "lateral_m");
  positive(config.vertical_m, "vertical_m");
  if (!(config.shrink_m >= 0.0) || !std::isfinite(config.shrink_m))
    throw std::invalid_argument("DecompositionConfig: shrink_m = " +
                                std::to_string(config.shrink_m) + " m, must be >= 0 and finite");
}
}  // namespace

FreePolyhedron decompose(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                         const std::vector<Eigen::Vector3d>& obstacles_L,
                         const DecompositionConfig& config)
{
  check(config);
  if (!a.allFinite() || !b.allFinite())
    throw std::invalid_argument("decompose: an end of the segment is not finite");
  detail::Scratch scratch;
  return detail::freePolyhedron(a, b, obstacles_L, config, scratch);
}

Eigen::AlignedBox3d localBox(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                             const DecompositionConfig& config)
{
  const detail::SegmentFrame frame(a, b, config);
  const Eigen::Vector3d reach = frame.half_box.array() + config.shrink_m;
  const Eigen::Vector3d half = frame.axes.cwiseAbs() * reach;
  return {frame.middle - half, frame.middle + half};
}

std::vector<FreePolyhedron> decomposeParallel(
    const Eigen::Matrix3Xd& path,
    const std::vector<std::vector<Eigen::Vector3d>>& obstacles_per_edge,
    const DecompositionConfig& config, int threads)
{
  check(config);
  const std::size_t edges = path.cols() > 0 ? static_cast<std::size_t>(path.cols() - 1) : 0;
  if (obstacles_per_edge.size() != edges)
    throw std::invalid_argument("decomposeParallel: " + std::to_string(obstacles_per_edge.size()) +
                                " obstacle lists for " + std::to_string(edges) + " edges");
  if (!path.allFinite()) throw std::invalid_argument("decomposeParallel: path is not finite");
  if (threads < 1)
    throw std::invalid_argument("decomposeParallel: " + std::to_string(threads) + " threads");

  std::vector<FreePolyhedron> out(edges);
  std::atomic<std::size_t> next{0};
  const auto work = [&]
  {
    detail::Scratch scratch;
    for (std::size_t i = next++; i < edges; i = next++)
    {
      const auto k = static_cast<Eigen::Index>(i);
      out[i] = detail::freePolyhedron(path.col(k), path.col(k + 1), obstacles_per_edge[i], config,
                                      scratch);
    }
  };
  std::vector<std::jthread> helpers;
  for (std::size_t i = 1; i < std::min(edges, static_cast<std::size_t>(threads)); ++i)
    helpers.emplace_back(work);
  work();
  helpers.clear();  // joins: every result is written before it is returned
  return out;
}

}  // namespace slalom::geometry
