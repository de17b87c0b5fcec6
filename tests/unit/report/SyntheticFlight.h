// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "slalom/core/CycleRecord.h"

namespace slalom::test
{
/** Knowledge of a forest of round trunks as a vehicle at `here` with a sensor of 6 m would have it:
 * a window of 16 m, unknown where trunks hide it or the sensor does not reach. */
class SeenForest final : public core::DistanceField
{
 public:
  struct Trunk
  {
    Eigen::Vector2d centre;
    double radius;
  };
  SeenForest(std::shared_ptr<const std::vector<Trunk>> trunks, const Eigen::Vector3d& here,
             std::uint64_t sequence);

  [[nodiscard]] core::Occupancy occupancy(const Eigen::Vector3d& p_L) const override;
  [[nodiscard]] std::optional<core::DistanceSample> sample(const Eigen::Vector3d& p_L,
                                                           core::UnknownAs) const override;
  [[nodiscard]] std::optional<double> lowerBound(const Eigen::Vector3d& p_L,
                                                 core::UnknownAs) const override;
  void collectObstacles(const Eigen::AlignedBox3d&, core::UnknownAs,
                        std::vector<Eigen::Vector3d>&) const override
  {
  }
  [[nodiscard]] Eigen::AlignedBox3d bounds() const override { return bounds_; }
  [[nodiscard]] double resolution() const override { return 0.2; }
  [[nodiscard]] double maxDistance() const override { return 3.0; }
  [[nodiscard]] std::uint64_t sequence() const override { return sequence_; }

 private:
  [[nodiscard]] bool hidden(const Eigen::Vector2d& p) const;

  std::shared_ptr<const std::vector<Trunk>> trunks_;  ///< near the window
  Eigen::Vector2d here_;
  Eigen::AlignedBox3d bounds_;
  std::uint64_t sequence_;
};

/** A made-up flight through a forest in which every part of a record is filled: 10 cycles per
 * second, R along a gentle S over 40 m, trunks on R that the refined reference avoids. The
 * planners' parts are geometry with the right look, not results of a planner. */
class SyntheticFlight
{
 public:
  explicit SyntheticFlight(std::uint64_t seed = 1);

  [[nodiscard]] int cycles() const { return 300; }
  [[nodiscard]] core::CycleRecord cycle(int index) const;
  [[nodiscard]] core::TimedPose truth(double t) const;

 private:
  [[nodiscard]] Eigen::Vector3d referenceAt(double s) const;
  [[nodiscard]] Eigen::Vector3d refinedAt(double s) const;
  void fillRefinement(core::CycleRecord& record, double s) const;
  void fillHorizon(core::CycleRecord& record, double s) const;

  std::shared_ptr<std::vector<SeenForest::Trunk>> trunks_;
  std::vector<double> blocked_at_;  ///< [s] parameters of trunks that stand on R
};

}  // namespace slalom::test
