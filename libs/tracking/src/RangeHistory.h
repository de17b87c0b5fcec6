// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "slalom/core/PointCloud.h"
#include "slalom/tracking/TrackingConfig.h"

namespace slalom::tracking::detail
{
/// What rays near a point say of it.
enum class Seen : std::uint8_t
{
  Nothing,  ///< no ray passed near it
  Free,     ///< all of them went on beyond it
  Surface,  ///< the first of them ended there
  Hidden    ///< the first of them ended before it
};

/** The scans of the last seconds, each as a panorama of the nearest ranges.
 *
 *  Columns are equal steps of the pseudo-angle y / (|x| + |y|), rows of the slope z / |xy|: both
 * cost no trigonometry. A column is 0.45 to 0.9 deg wide; slopes beyond +-48 deg are not kept. Of
 * the rays in a bin the shortest counts, so "free" is never said where one of them stopped. */
class RangeHistory
{
 public:
  explicit RangeHistory(const TrackingConfig& config);

  /// Adds the rays of a scan; what follows within 0.09 s shares a panorama.
  void add(double t, const Eigen::Vector3f& origin_L, std::span<const core::Ray> rays);

  /// Number of panoramas, newest first.
  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] double time(int age) const { return slot(age).t; }

  /// What panorama number `age` says of a point.
  [[nodiscard]] Seen look(int age, const Eigen::Vector3f& p_L) const;

  void clear() { size_ = 0; }

 private:
  static constexpr int kSlots = 32, kQuadrant = 128, kColumns = 4 * kQuadrant, kRows = 64;
  static constexpr float kRowSlope = 0.035f;
  static constexpr std::uint16_t kEmpty = 65535;  // ranges are in centimetres

  struct Panorama
  {
    double t = 0.0;
    Eigen::Vector3f origin_L = Eigen::Vector3f::Zero();
    std::vector<std::uint16_t> range;
  };
  [[nodiscard]] const Panorama& slot(int age) const
  {
    return slots_[static_cast<std::size_t>((newest_ - age + kSlots) % kSlots)];
  }

  float margin_m_, width_m_, min_range_m_;
  int newest_ = 0, size_ = 0;
  std::vector<Panorama> slots_;
};

}  // namespace slalom::tracking::detail
