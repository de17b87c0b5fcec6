// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "Alignment.h"
#include "DelayedFilter.h"

namespace slalom::estimation::detail
{
/** Filters that differ in their idea of the heading only, a Gaussian sum around the circle. All
 * hear every event; each is weighed by the likelihood of its innovations. When the weighted heading
 * is narrow enough for one linearisation, the sum is replaced by one filter. Whatever tells the
 * heading (manoeuvres against velocity or position, body velocity against displacement, a compass)
 * tells it through the likelihood; until then the course only suggests one, weakly.
 *
 *  Evidence counts only while there is something to compare: two noises agree or disagree about a
 * direction just as loudly as two signals, so a hovering vehicle would slowly invent a heading. */
class HeadingBank
{
 public:
  HeadingBank(const FilterConfig& config, const Start& start);

  void add(const RatedImu& imu)
  {
    for (DelayedFilter& filter : filters_) filter.add(imu);
    settle();
  }
  void add(const Aid& aid)
  {
    for (DelayedFilter& filter : filters_) filter.add(aid);
    settle();
  }

  [[nodiscard]] const DelayedFilter& leader() const { return filters_[leader_]; }
  [[nodiscard]] bool headingKnown() const { return filters_.size() == 1; }
  [[nodiscard]] double startTime() const { return start_t_; }
  /// Standard deviation of the heading over all filters [rad], at most 1.8 (uniform).
  [[nodiscard]] double headingSigma() const { return heading_sigma_; }
  void startLocalFrame() { filters_[leader_].startLocalFrame(); }

 private:
  void settle();
  void gatherEvidence();
  void follow(std::size_t best);
  void merge(const std::vector<double>& weights);

  FilterConfig config_;
  std::vector<DelayedFilter> filters_;
  std::vector<double> evidence_;  // log weight of each filter
  std::vector<double> heard_;     // its log likelihood at the last look
  std::size_t leader_ = 0;
  double start_t_;
  double faded_t_;
  double last_heading_ = kNever;  // newest compass or pose in the evidence
  double heading_sigma_;
};

}  // namespace slalom::estimation::detail
