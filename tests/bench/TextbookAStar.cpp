// SPDX-License-Identifier: BSD-3-Clause
#include "TextbookAStar.h"

#include <limits>
#include <queue>
#include <vector>

namespace slalom::bench
{
namespace
{
using Vec = Eigen::Vector3d;

double factor(double distance, const search::GridSearchConfig& config)
{
  const double span = config.preferred_clearance_m - config.clearance_m;
  if (span <= 0.0 || distance >= config.preferred_clearance_m) return 1.0;
  return 1.0 + config.proximity_weight * (config.preferred_clearance_m - distance) / span;
}
}  // namespace

TextbookResult textbookAStar(const core::DistanceField& field, const Vec& start_L,
                             const Vec& goal_L, const Eigen::AlignedBox3d& box_L,
                             const search::GridSearchConfig& config)
{
  const Eigen::AlignedBox3d region = box_L.intersection(field.bounds());
  const double r = field.resolution();
  const Eigen::Vector3i low =
      ((region.min() - start_L) / r - Vec::Constant(1e-9)).array().ceil().cast<int>();
  const Eigen::Vector3i high =
      ((region.max() - start_L) / r + Vec::Constant(1e-9)).array().floor().cast<int>();
  const Eigen::Vector3i size = high - low + Eigen::Vector3i::Ones();
  const auto index = [&](const Eigen::Vector3i& at)
  {
    const Eigen::Vector3i i = at - low;
    return static_cast<std::size_t>(i.x() + size.x() * (i.y() + size.y() * i.z()));
  };
  const auto place = [&](const Eigen::Vector3i& at) -> Vec
  { return start_L + r * at.cast<double>(); };
  const auto distance = [&](const Vec& p)
  { return field.distance(p, core::UnknownAs::Free).value_or(-1.0); };

  struct Entry
  {
    double priority, cost, length;
    Eigen::Vector3i at;
    bool goal;
    bool operator<(const Entry& other) const { return priority > other.priority; }
  };
  std::vector<double> best(static_cast<std::size_t>(size.prod()),
                           std::numeric_limits<double>::infinity());
  std::priority_queue<Entry> open;
  open.push({(goal_L - start_L).norm(), 0.0, 0.0, Eigen::Vector3i::Zero(), false});
  best[index(Eigen::Vector3i::Zero())] = 0.0;
  const double goal_factor = factor(distance(goal_L), config);
  while (!open.empty())
  {
    const Entry top = open.top();
    open.pop();
    if (top.goal) return {true, top.cost, top.length};
    if (top.cost > best[index(top.at)]) continue;
    const Vec here = place(top.at);
    const double here_factor = factor(distance(here), config);
    const double last = (goal_L - here).norm();
    if ((goal_L - here).cwiseAbs().maxCoeff() <= 1.001 * r &&
        search::segmentClear(field, here, goal_L, config.clearance_m))
    {
      const double cost = top.cost + last * 0.5 * (here_factor + goal_factor);
      open.push({cost, cost, top.length + last, top.at, true});
    }
    for (int n = 0; n < 27; ++n)
    {
      const Eigen::Vector3i next = top.at + Eigen::Vector3i(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
      if (n == 13 || ((next - low).array() < 0).any() || ((high - next).array() < 0).any())
        continue;
      const Vec there = place(next);
      const double d = distance(there);
      if (d < config.clearance_m) continue;
      const double length = (there - here).norm();
      const double cost = top.cost + length * 0.5 * (here_factor + factor(d, config));
      if (cost >= best[index(next)] ||
          !search::segmentClear(field, here, there, config.clearance_m))
        continue;
      best[index(next)] = cost;
      open.push({cost + (goal_L - there).norm(), cost, top.length + length, next, false});
    }
  }
  return {};
}
}  // namespace slalom::bench
