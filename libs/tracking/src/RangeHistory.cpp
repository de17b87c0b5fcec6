// SPDX-License-Identifier: BSD-3-Clause
#include "RangeHistory.h"

#include <algorithm>
#include <cmath>

namespace slalom::tracking::detail
{
namespace
{
constexpr double kSlotDuration = 0.09;  // [s] a little less than a turn of the lidar

// 0..4 around the circle, like an angle.
float pseudoAngle(float x, float y)
{
  const float along = y / (std::fabs(x) + std::fabs(y) + 1e-9f);
  return x < 0.0f ? 2.0f - along : (along < 0.0f ? 4.0f + along : along);
}

}  // namespace

RangeHistory::RangeHistory(const TrackingConfig& config)
    : margin_m_(static_cast<float>(config.free_margin_m)),
      width_m_(static_cast<float>(config.free_width_m)),
      min_range_m_(static_cast<float>(config.min_range_m)),
      slots_(kSlots)
{
  for (Panorama& slot : slots_) slot.range.assign(kColumns * kRows, kEmpty);
}

void RangeHistory::add(double t, const Eigen::Vector3f& origin_L, std::span<const core::Ray> rays)
{
  if (size_ == 0 || t - slot(0).t >= kSlotDuration)
  {
    newest_ = (newest_ + 1) % kSlots;
    size_ = std::min(size_ + 1, kSlots);
    Panorama& fresh = slots_[static_cast<std::size_t>(newest_)];
    fresh.t = t;
    fresh.origin_L = origin_L;
    std::fill(fresh.range.begin(), fresh.range.end(), kEmpty);
  }
  Panorama& now = slots_[static_cast<std::size_t>(newest_)];
  const Eigen::Vector3f o = now.origin_L;
  const float closest = std::max(1.0f, 100.0f * min_range_m_);
  constexpr float kLowest = -0.5f * kRows;
  for (const core::Ray& ray : rays)
  {
    const float x = ray.end_L.x() - o.x(), y = ray.end_L.y() - o.y(), z = ray.end_L.z() - o.z();
    const float planar = x * x + y * y;
    const float row = z / (kRowSlope * std::sqrt(planar + 1e-9f)) - kLowest;
    const float range = 100.0f * std::sqrt(planar + z * z);
    // Written so that a comparison with NaN fails.
    if (!(row >= 0.0f && row < kRows && range >= closest && range < 1e6f)) continue;
    const int column = std::min(kColumns - 1, static_cast<int>(kQuadrant * pseudoAngle(x, y)));
    std::uint16_t& bin =
        now.range[static_cast<std::size_t>(static_cast<int>(row) * kColumns + column)];
    bin = std::min(bin, static_cast<std::uint16_t>(std::min(range, kEmpty - 1.0f)));
  }
}

Seen RangeHistory::look(int age, const Eigen::Vector3f& p_L) const
{
  const Panorama& from = slot(age);
  const Eigen::Vector3f d = p_L - from.origin_L;
  const float planar = d.head<2>().norm(), range = d.norm();
  const float row = d.z() / (kRowSlope * (planar + 1e-9f)) + 0.5f * kRows;
  if (!(planar > 0.3f) || !(row >= 1.0f && row < kRows - 1.0f)) return Seen::Nothing;

  // The pseudo-angle never turns faster than the angle.
  const float angle = width_m_ / planar;
  const int across = 1 + static_cast<int>(angle * kQuadrant);
  const int up = std::max(1, static_cast<int>(std::lround(angle / kRowSlope)));
  const int column = static_cast<int>(kQuadrant * pseudoAngle(d.x(), d.y()));
  std::uint16_t nearest = kEmpty;
  for (int y = std::max(0, static_cast<int>(row) - up);
       y <= std::min(kRows - 1, static_cast<int>(row) + up); ++y)
    for (int x = column - across; x <= column + across; ++x)
      nearest = std::min(nearest,
                         from.range[static_cast<std::size_t>(y * kColumns + (x & (kColumns - 1)))]);
  if (nearest == kEmpty) return Seen::Nothing;
  const float beyond = 0.01f * static_cast<float>(nearest) - range;
  if (beyond > margin_m_) return Seen::Free;
  return beyond < -margin_m_ ? Seen::Hidden : Seen::Surface;
}

}  // namespace slalom::tracking::detail
