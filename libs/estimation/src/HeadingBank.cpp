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
constexpr double kEachSigma = 0.35;       // [rad] neighbours overlap: nearly uniform in sum
constexpr double kUniform = 1.8;          // [rad] pi / sqrt(3)
constexpr double kNarrow = 0.35;          // [rad] one linearisation holds
constexpr double kNarrowKinematic = 0.7;  // [rad] all that a course can tell
constexpr double kWideGate = 3.0;         // a filter with a wrong heading pays, but is not deaf
constexpr double kOvertake = 1.1;         // [1] log of the weight ratio for a change of leader
constexpr double kMemory = 30.0;          // [s] old evidence fades: sensors are not white
constexpr double kPower = 0.5;            // tempered, for the same reason
constexpr double kCourseHint = 1.0;       // [1] concentration of "nose first" around the course

bool inertial(const FilterState& s)
{
  return s.t - s.last_imu < 1.0;
}

double velocitySigma(const FilterState& s)
{
  return std::sqrt(0.5 * (s.P(kV, kV) + s.P(kV + 1, kV + 1)));
}

// Body velocity shows the heading by speed, everything else by acceleration; either must stand out
// of its noise (for an acceleration that is mostly the tilt's).
bool telling(const FilterState& s, double accel_noise)
{
  const double speed = s.v.head<2>().norm();
  const bool moves = speed > std::max(0.3, 3.0 * velocitySigma(s));
  if (s.t - s.last_body_velocity < 1.0 && moves) return true;
  if (!inertial(s)) return moves;
  return s.manoeuvre2 > 0.06 + 2.0 * pretendedManoeuvre2(s, accel_noise * accel_noise);
}

double courseHint(const FilterState& s)
{
  const double speed = s.v.head<2>().norm();
  if (speed < std::max(0.3, 3.0 * velocitySigma(s))) return 0.0;
  return kCourseHint * std::cos(core::yawOf(s.q) - std::atan2(s.v.y(), s.v.x()));
}
}  // namespace

HeadingBank::HeadingBank(const FilterConfig& config, const Start& start)
    : config_(config), start_t_(start.state.t), faded_t_(start.state.t), heading_sigma_(kUniform)
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
  evidence_.assign(filters_.size(), 0.0);
  heard_.assign(filters_.size(), 0.0);
  for (const RatedImu& imu : start.imu) add(imu);
  for (const Aid& aid : start.aids) add(aid);
}

void HeadingBank::gatherEvidence()
{
  const FilterState& now = leader().newest();
  const double fade = std::exp(-(now.t - faded_t_) / kMemory);
  faded_t_ = now.t;
  double heading = last_heading_;
  for (const DelayedFilter& filter : filters_)
    heading = std::max(heading, filter.newest().last_heading);
  const bool counts = heading > last_heading_ || telling(now, config_.accel_noise);
  last_heading_ = heading;
  for (std::size_t i = 0; i < filters_.size(); ++i)
  {
    const double heard = filters_[i].newest().log_likelihood;
    evidence_[i] = fade * evidence_[i] + (counts ? kPower * (heard - heard_[i]) : 0.0);
    heard_[i] = heard;
  }
}

void HeadingBank::settle()
{
  if (filters_.size() == 1)
  {
    heading_sigma_ = std::min(kUniform, std::sqrt(leader().newest().P(kR + 2, kR + 2)));
    return;
  }
  gatherEvidence();
  std::vector<double> weights(filters_.size());
  for (std::size_t i = 0; i < weights.size(); ++i)
    weights[i] = evidence_[i] + courseHint(filters_[i].newest());
  const auto top = std::max_element(weights.begin(), weights.end());
  const auto best = static_cast<std::size_t>(top - weights.begin());
  const double lead = *top - weights[leader_];
  const double highest = *top;
  double total = 0.0;
  for (double& w : weights) w = std::exp(w - highest);
  for (const double w : weights) total += w;

  std::complex<double> mean = 0.0;
  for (std::size_t i = 0; i < filters_.size(); ++i)
  {
    const FilterState& s = filters_[i].newest();
    weights[i] /= total;
    // A normal heading of variance P has the mean direction shortened by exp(-P/2).
    mean += std::polar(weights[i] * std::exp(-0.5 * s.P(kR + 2, kR + 2)), core::yawOf(s.q));
  }
  heading_sigma_ = std::min(kUniform, std::sqrt(-2.0 * std::log(std::max(std::abs(mean), 1e-6))));
  if (heading_sigma_ < (inertial(leader().newest()) ? kNarrow : kNarrowKinematic))
  {
    follow(best);
    merge(weights);
  }
  else if (lead > kOvertake)
  {
    follow(best);
  }
}

void HeadingBank::follow(std::size_t best)
{
  if (best == leader_) return;
  filters_[best].adoptLocalFrame(filters_[leader_]);
  leader_ = best;
}

void HeadingBank::merge(const std::vector<double>& weights)
{
  std::vector<const DelayedFilter*> some;
  std::vector<double> shares;
  double total = 0.0;
  for (std::size_t i = 0; i < filters_.size(); ++i)
  {
    if (weights[i] < 1e-4) continue;
    some.push_back(&filters_[i]);
    shares.push_back(weights[i]);
    total += weights[i];
  }
  for (double& share : shares) share /= total;
  DelayedFilter merged = filters_[leader_];
  merged.blend(some, shares);
  merged.setGate(config_.gate);
  filters_.assign(1, std::move(merged));
  leader_ = 0;
}

}  // namespace slalom::estimation::detail
