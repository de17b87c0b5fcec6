// SPDX-License-Identifier: BSD-3-Clause
#include "ScanAssembler.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace slalom::engine
{
namespace
{
constexpr double kPoseStep_s =
    1e-3;  // 2 m/s and 1 rad/s move a return at 10 m by less than 1 cm between two poses
constexpr double kPatience_s = 0.25;
constexpr double kFuture_s = 1.0;

/// Poses of the sensor every millisecond of the scan; nullopt if the vehicle's path is not known
/// over all of it.
std::optional<std::vector<Eigen::Isometry3f>> sensorPath(const core::RangeScan& scan,
                                                         const StateSource& source)
{
  const auto count = static_cast<std::size_t>(std::ceil(scan.duration / kPoseStep_s)) + 1;
  std::vector<Eigen::Isometry3f> path;
  path.reserve(count);
  for (std::size_t i = 0; i < count; ++i)
  {
    const auto state = source.stateAt(scan.t + std::min(scan.duration, kPoseStep_s * double(i)));
    if (!state) return std::nullopt;
    const Eigen::Isometry3d T_LB = Eigen::Translation3d(state->p_L) * state->q_WB;
    path.push_back((T_LB * scan.T_BS).cast<float>());
  }
  return path;
}

}  // namespace

/// A sensor that hears next to nothing is covered or broken, it does not look into the open.
bool ScanAssembler::believesSilence(const core::RangeScan& scan) const
{
  constexpr double kLeastEchoes = 0.02;
  const double echoes = double(scan.points.size()), all = echoes + double(scan.silent.size());
  return config_.no_return == mapping::NoReturn::Free && echoes >= kLeastEchoes * all;
}

std::vector<MapJob> ScanAssembler::take(const StateSource& source, double now,
                                        std::map<std::string, std::uint64_t>& dropped)
{
  std::vector<MapJob> jobs;
  while (!pending_.empty())
  {
    const core::RangeScan& scan = pending_.front();
    const double end = scan.t + scan.duration;
    if (scan.t > now + kFuture_s)
    {
      ++dropped["scan from the future"];
      pending_.pop_front();
      continue;
    }
    if (source.kind() != StateSourceKind::Static && source.newest() < end &&
        now < end + kPatience_s)
      break;
    const auto path = sensorPath(scan, source);
    const auto vehicle = source.stateAt(end);
    if (path && vehicle)
    {
      MapJob job{end, vehicle->p_L, {}};
      job.rays.reserve(scan.points.size() + scan.silent.size());
      const auto poseAt = [&](float dt) -> const Eigen::Isometry3f&
      {
        const long last = static_cast<long>(path->size()) - 1;
        return (*path)[static_cast<std::size_t>(
            std::clamp(std::lround(double(dt) / kPoseStep_s), 0L, last))];
      };
      for (const core::ScanPoint& point : scan.points)
        job.rays.push_back({poseAt(point.dt).translation(), poseAt(point.dt) * point.p_S});
      // Near the sensor silence may be an obstacle inside its least range.
      constexpr float kDeaf_m = 1.0f;
      const float far = static_cast<float>(config_.update_range_m);
      if (believesSilence(scan))
        for (const core::ScanPoint& ray : scan.silent)
          job.rays.push_back(
              {poseAt(ray.dt) * (kDeaf_m * ray.p_S), poseAt(ray.dt) * (far * ray.p_S)});
      job.silent = job.rays.size() - scan.points.size();
      jobs.push_back(std::move(job));
    }
    else
      ++dropped["scan without pose"];
    pending_.pop_front();
  }
  return jobs;
}

}  // namespace slalom::engine
