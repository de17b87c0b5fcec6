// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <variant>
#include <vector>

#include "FilterState.h"
#include "Prediction.h"
#include "Update.h"
#include "slalom/core/VehicleState.h"

namespace slalom::estimation::detail
{
/** A filter on a time line. Events (IMU samples and aids) are kept in the order of their own time,
 * each with the state after it; an event that arrives late is inserted where it belongs and the
 * line is replayed from there. The result depends on the order of times, not of arrival.
 *
 *  Aids newer than the newest IMU sample wait for the next one (one sampling interval), so that the
 * interval around them is integrated with the samples on both sides; they stop waiting when the IMU
 * has been silent for `imuGap`.
 *
 *  The local position is the exception: it is integrated once, when an event first becomes part of
 * the line, and never recomputed, hence continuous. */
class DelayedFilter
{
 public:
  /// @param start  state at start.t  @param before  newest IMU sample at or before it, if any
  DelayedFilter(const FilterConfig& config, const FilterState& start,
                const std::optional<RatedImu>& before, double gate);

  void add(const RatedImu& imu);
  void add(const Aid& aid);

  /// False if `t` lies before the kept part of the line.
  [[nodiscard]] bool reaches(double t) const { return t >= nodes_.front().state.t; }
  [[nodiscard]] const FilterState& newest() const { return nodes_[processed_ - 1].state; }
  [[nodiscard]] core::VehicleState newestVehicle() const;
  [[nodiscard]] std::optional<core::VehicleState> at(double t) const;
  [[nodiscard]] std::uint64_t gated() const { return gated_; }
  [[nodiscard]] std::uint64_t undefined() const { return undefined_; }

  void setGate(double gate) { gate_ = gate; }
  /// Puts the origin of the local frame under the vehicle.
  void startLocalFrame();
  /// Continues the local path of another filter that has seen the same events.
  void adoptLocalFrame(const DelayedFilter& other);
  /** Becomes the normal distribution with the mean and covariance of a weighted sum of filters that
   * have seen the same events (itself included), at every event of the kept line.
   *  @param weights  sum 1 */
  void blend(const std::vector<const DelayedFilter*>& others, const std::vector<double>& weights);

  /// An IMU silent for longer is not bridged by integration [s].
  [[nodiscard]] static double imuGap(const FilterConfig& config)
  {
    return 4.0 / config.min_imu_rate_hz;
  }

 private:
  struct Node
  {
    std::variant<std::monostate, RatedImu, Aid> event;
    FilterState state;
    Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
    Eigen::Vector3d v_L = Eigen::Vector3d::Zero();  ///< last published velocity of this instant
    bool has_p_L = false;
    std::optional<Outcome> outcome;
    double t = 0.0;
  };

  void insert(Node node);
  void advance();
  void step(std::size_t index);
  void move(FilterState& state, std::size_t index) const;
  void correct(Node& node);
  void placeLocally(std::size_t index);
  void count(const std::optional<Outcome>& outcome, std::int64_t change);
  /// The velocity that is about to be published is the one from which the local path goes on.
  void tell();
  void prune();
  [[nodiscard]] const RatedImu* imuUpTo(std::size_t index) const;
  [[nodiscard]] const RatedImu* imuFrom(std::size_t index) const;
  [[nodiscard]] core::VehicleState vehicle(const Node& node) const;

  FilterConfig config_;
  double gate_;
  std::deque<Node> nodes_;
  std::size_t processed_ = 1;
  std::optional<RatedImu> before_;  // IMU sample that precedes the kept line
  double last_imu_ = kNever;
  std::uint64_t gated_ = 0;
  std::uint64_t undefined_ = 0;
};

}  // namespace slalom::estimation::detail
