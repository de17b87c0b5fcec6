// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numeric>

#include "Figures.h"
#include "slalom/core/TextTable.h"

namespace slalom::experiment
{
namespace
{
double distanceToSegment(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                         const Eigen::Vector3d& b)
{
  const Eigen::Vector3d along = b - a;
  const double length2 = along.squaredNorm();
  const double s = length2 > 0.0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (p - a - s * along).norm();
}

std::size_t firstNotBefore(const Path& path, double t)
{
  return static_cast<std::size_t>(std::lower_bound(path.t.begin(), path.t.end(), t) -
                                  path.t.begin());
}
}  // namespace

Path readPath(const std::filesystem::path& tum)
{
  Path path;
  if (!std::filesystem::exists(tum)) return path;
  for (const core::TextRow& row : core::readRows(tum, 0))
  {
    path.t.push_back(core::numberAt(tum, row, 0));
    path.points.emplace_back(core::numberAt(tum, row, 1), core::numberAt(tum, row, 2),
                             core::numberAt(tum, row, 3));
  }
  return path;
}

std::vector<double> distancesToLine(const Path& path, const Path& reference, double window_s)
{
  std::vector<double> distances;
  if (reference.t.empty()) return distances;
  for (std::size_t i = 0; i < path.t.size(); ++i)
  {
    const double t = path.t[i];
    if (t < reference.t.front() || t > reference.t.back()) continue;
    const std::size_t begin = firstNotBefore(reference, t - window_s);
    const std::size_t end = std::min(firstNotBefore(reference, t + window_s), reference.t.size());
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = begin; k < end; ++k)
      nearest = std::min(nearest, distanceToSegment(path.points[i], reference.points[k],
                                                    reference.points[std::min(k + 1, end - 1)]));
    if (std::isfinite(nearest)) distances.push_back(nearest);
  }
  return distances;
}

std::vector<double> distancesInTime(const Path& path, const Path& targets)
{
  std::vector<double> distances;
  for (std::size_t i = 0; i < targets.t.size(); ++i)
  {
    const std::size_t after = firstNotBefore(path, targets.t[i]);
    if (after == path.t.size() || (after == 0 && path.t[0] > targets.t[i])) continue;
    const std::size_t before = after == 0 ? 0 : after - 1;
    const double span = path.t[after] - path.t[before];
    const double s = span > 0.0 ? (targets.t[i] - path.t[before]) / span : 0.0;
    const Eigen::Vector3d p = (1.0 - s) * path.points[before] + s * path.points[after];
    distances.push_back((p - targets.points[i]).norm());
  }
  return distances;
}

std::optional<ErrorFigures> errorFigures(std::vector<double> samples)
{
  if (samples.empty()) return std::nullopt;
  std::sort(samples.begin(), samples.end());
  const double n = static_cast<double>(samples.size());
  const auto rank = static_cast<std::size_t>(std::ceil(0.95 * n)) - 1;
  return ErrorFigures{std::accumulate(samples.begin(), samples.end(), 0.0) / n, samples[rank],
                      samples.back()};
}

}  // namespace slalom::experiment
