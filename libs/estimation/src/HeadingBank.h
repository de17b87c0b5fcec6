// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "Alignment.h"
#include "DelayedFilter.h"

namespace slalom::estimation::detail
{
/** Filters that differ in their idea of the heading only, a Gaussian sum around the circle. All hear
 * every event; each is weighed by the likelihood of its innovations. When the weighted heading is
 * narrow enough for one linearisation, the best filter goes on alone. No course, manoeuvre or
 * compass is required in particular: whatever tells the heading, tells it through the likelihood.
 */
class HeadingBank
{
 public:
  HeadingBank(const FilterConfig& config, const Start& start);

  template <class Event>
  void add(const Event& event)
  {
    for (DelayedFilter& filter : filters_) filter.add(event);
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
  void keepOnlyLeader();

  FilterConfig config_;
  std::vector<DelayedFilter> filters_;
  std::size_t leader_ = 0;
  double start_t_;
  double heading_sigma_;
};

}  // namespace slalom::estimation::detail
