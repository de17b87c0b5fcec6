// SPDX-License-Identifier: BSD-3-Clause
#include "HeadingBank.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "slalom/core/Math.h"

namespace slalom::estimation::detail
{
namespace
{
constexpr int kFilters = 12;
constexpr double kSpacing = 2.0 * std::numbers::pi / kFilters;
constexpr double kEachSigma = 0.35;     // [rad] neighbours overlap: nearly uniform in sum
constexpr double kUniform = 1.8;        // [rad] pi / sqrt(3)
constexpr double kNarrow = 0.35;        // [rad] one linearisation holds
constexpr double kNarrowKinematic = 0.7;  // [rad] all that a course can tell
constexpr double kWideGate = 3.0;       // a filter with a wrong heading pays, but is not deaf
constexpr double kOvertake = 1.1;       // [1] log of the weight ratio for a change of leader

bool inertial(const FilterState& s) { return s.t - s.last_imu < 1.0; }
}  // namespace

HeadingBank::HeadingBank(const FilterConfig& config, const Start& start)
    : config_(config), start_t_(start.state.t), heading_sigma_(kUniform)
{
  const int count = start.heading_known ? 1 : kFilters;
  for (int i = 0; i < count; ++i)
  {
    FilterState state = start.state;
    state.q = (core::fromYaw(i * kSpacing) * state.q).normalized();
    const double sigma = count == 1 ? kUniform : kEachSigma;
    state.P(kR + 2, kR + 2) = sigma * sigma;
    const double gate = count == 1 ? config.gate : kWideGate * config.gate;
    filters_.emplace_back(config, state, start.before, gate);
  }
  for (const RatedImu& imu : start.imu) add(imu);
  for (const Aid& aid : start.aids) add(aid);
}

void HeadingBank::settle()
{
  if (filters_.size() == 1)
  {
    heading_sigma_ = std::min(kUniform, std::sqrt(leader().newest().P(kR + 2, kR + 2)));
    return;
  }
  std::size_t best = 0;
  for (std::size_t i = 1; i < filters_.size(); ++i)
    if (filters_[i].newest().log_likelihood > filters_[best].newest().log_likelihood) best = i;
  const double top = filters_[best].newest().log_likelihood;

  std::complex<double> mean = 0.0;
  double total = 0.0;
  for (const DelayedFilter& filter : filters_)
  {
    const FilterState& s = filter.newest();
    const double weight = std::exp(s.log_likelihood - top);
    // A normal heading of variance P has the mean direction shortened by exp(-P/2).
    mean += std::polar(weight * std::exp(-0.5 * s.P(kR + 2, kR + 2)), core::yawOf(s.q));
    total += weight;
  }
  const double length = std::max(std::abs(mean) / total, 1e-6);
  heading_sigma_ = std::min(kUniform, std::sqrt(-2.0 * std::log(length)));

  const bool narrow = heading_sigma_ < (inertial(leader().newest()) ? kNarrow : kNarrowKinematic);
  if (narrow || top - leader().newest().log_likelihood > kOvertake)
  {
    filters_[best].adoptLocalFrame(filters_[leader_]);
    leader_ = best;
  }
  if (!narrow) return;
  const double off = core::wrapAngle(std::arg(mean) - core::yawOf(leader().newest().q));
  filters_[leader_].doubtHeading(std::hypot(heading_sigma_, off));
  keepOnlyLeader();
}

void HeadingBank::keepOnlyLeader()
{
  DelayedFilter kept = std::move(filters_[leader_]);
  filters_.clear();
  filters_.push_back(std::move(kept));
  filters_.front().setGate(config_.gate);
  leader_ = 0;
}

}  // namespace slalom::estimation::detail
