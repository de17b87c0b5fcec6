// SPDX-License-Identifier: BSD-3-Clause
#include "Reachability.h"

#include <algorithm>
#include <cmath>

namespace slalom::spline::detail
{
void IntervalLimits::limitAcceleration(double along, double bend, double limit)
{
  if (std::abs(along) <= negligible_)
  {
    x_bend_ = std::min(x_bend_, limit / std::abs(bend));
    return;
  }
  const double per_along = 1.0 / along;
  band_[bands_++] = {limit * std::abs(per_along), -bend * per_along};
}

void IntervalLimits::limitSpeed(double along, double bend, double limit)
{
  ceiling_[ceilings_++] = {limit / along, -bend / along};
}

void IntervalLimits::capSpeed(double x_at_start, double x_at_end)
{
  x_start_ = std::min(x_start_, x_at_start);
  x_end_ = std::min(x_end_, x_at_end);
}

double IntervalLimits::capAtEnd(const Relief& relief) const
{
  return relief.speed ? x_hard_ : std::min(x_hard_, x_end_);
}

IntervalLimits::Line IntervalLimits::lowest(double x, const Relief& relief) const
{
  Line worst{0.0, 0.5 * (share_ - 1.0) / step_};
  double w = worst.at(x);
  for (int i = 0; i < bands_; ++i)
  {
    const Line line{-relief.acceleration * band_[i].offset, band_[i].slope};
    if (line.at(x) > w) w = line.at(x), worst = line;
  }
  return worst;
}

IntervalLimits::Line IntervalLimits::highest(double x, const Relief& relief) const
{
  Line worst{std::numeric_limits<double>::infinity(), 0.0};
  double w = worst.offset;
  for (int i = 0; i < bands_; ++i)
  {
    const Line line{relief.acceleration * band_[i].offset, band_[i].slope};
    if (line.at(x) < w) w = line.at(x), worst = line;
  }
  const int ceilings = relief.speed ? 0 : ceilings_;
  for (int i = 0; i < ceilings; ++i)
    if (ceiling_[i].at(x) < w) w = ceiling_[i].at(x), worst = ceiling_[i];
  return worst;
}

double IntervalLimits::largestX(double next, const Relief& relief) const
{
  double x = std::min(x_hard_, relief.acceleration * x_bend_);
  if (!relief.speed) x = std::min(x, x_start_);
  // The room between the lowest upper and the highest lower bound is concave in x and not negative
  // at 0: Newton from the right meets its zero after at most as many steps as there are lines.
  const Line arrive{0.5 * next / step_, -0.5 / step_};
  for (;;)
  {
    const Line lower = lowest(x, relief);
    Line upper = highest(x, relief);
    if (arrive.at(x) < upper.at(x)) upper = arrive;
    if (upper.at(x) >= lower.at(x)) return x;
    const double closed = (upper.offset - lower.offset) / (lower.slope - upper.slope);
    if (!(closed < x)) return x;
    x = std::max(0.0, closed);
  }
}

double IntervalLimits::fastest(double x, double wish, const Relief& relief) const
{
  const double wanted = std::min(highest(x, relief).at(x), 0.5 * (wish - x) / step_);
  const double w = std::max(lowest(x, relief).at(x), wanted);
  return std::clamp(x + 2.0 * step_ * w, 0.0, wish);
}

double IntervalLimits::slowest(double x, double wish, const Relief& relief) const
{
  const double wanted = std::max(lowest(x, relief).at(x), 0.5 * (wish - x) / step_);
  const double w = std::min(highest(x, relief).at(x), wanted);
  return std::max(x + 2.0 * step_ * w, 0.0);
}

double IntervalLimits::worstRatio(double x, double next) const
{
  const double w = 0.5 * (next - x) / step_;
  double acceleration = x / x_bend_, speed = std::max(x / x_start_, next / x_end_);
  for (int i = 0; i < bands_; ++i)
    acceleration = std::max(acceleration, std::abs(w - band_[i].slope * x) / band_[i].offset);
  for (int i = 0; i < ceilings_; ++i)
    speed = std::max(speed, (w - ceiling_[i].slope * x) / ceiling_[i].offset);
  return std::max(acceleration, std::sqrt(std::max(0.0, speed)));
}

std::vector<double> controllable(const std::vector<IntervalLimits>& intervals, double x_end,
                                 const Relief& relief)
{
  std::vector<double> x(intervals.size() + 1, x_end);
  for (std::size_t i = intervals.size(); i-- > 0;)
  {
    x[i + 1] = std::min(x[i + 1], intervals[i].capAtEnd(relief));
    x[i] = intervals[i].largestX(x[i + 1], relief);
  }
  return x;
}

std::vector<double> fastest(const std::vector<IntervalLimits>& intervals,
                            const std::vector<double>& reachable, double x_start)
{
  std::vector<double> x(reachable.size(), x_start);
  for (std::size_t i = 0; i < intervals.size(); ++i)
    x[i + 1] = intervals[i].fastest(x[i], reachable[i + 1], {});
  return x;
}

namespace
{
struct RelievedSet
{
  Relief relief;
  std::vector<double> reachable;
};

/** The controllable set with the smallest relief that holds x_start. Its front is concave in the
 * relief and 0 without any acceleration, so chords extended to the right never pass the solution.
 */
RelievedSet relieve(const std::vector<IntervalLimits>& intervals, double x_end, double x_start)
{
  constexpr int kChords = 50;
  constexpr double kNear = 1.0 - 1e-9;
  RelievedSet set{{1.0, true}, {}};
  double before = 0.0, x_before = 0.0;
  for (int i = 0; i < kChords; ++i)
  {
    set.reachable = controllable(intervals, x_end, set.relief);
    const double now = set.relief.acceleration, x = set.reachable.front();
    if (x >= kNear * x_start || !(x > x_before)) break;
    set.relief.acceleration += (x_start - x) * (now - before) / (x - x_before);
    before = now;
    x_before = x;
  }
  return set;
}
}  // namespace

Braking brake(const std::vector<IntervalLimits>& intervals, const std::vector<double>& reachable,
              double x_start)
{
  const RelievedSet set = relieve(intervals, reachable.back(), x_start);
  Braking braking{std::vector<double>(reachable.size(), x_start), 1.0};
  bool kept = false;
  for (std::size_t i = 0; i < intervals.size(); ++i)
  {
    const double x = braking.x[i];
    double& next = braking.x[i + 1];
    kept = kept || x <= reachable[i];
    if (kept)
    {
      next = intervals[i].fastest(x, reachable[i + 1], {});
      continue;
    }
    const double slowest = intervals[i].slowest(x, reachable[i + 1], set.relief);
    next = std::min(slowest, set.reachable[i + 1]);
    braking.ratio = std::max(braking.ratio, intervals[i].worstRatio(x, next));
  }
  return braking;
}

double passageTime(double x, double next, double step)
{
  const double sum = std::sqrt(x) + std::sqrt(next);
  return 2.0 * step / std::max(sum, std::numeric_limits<double>::min());
}

double passageDistance(double x, double next, double step, double time)
{
  const double rate = std::sqrt(x), whole = passageTime(x, next, step);
  const double change = (std::sqrt(next) - rate) / whole;
  return std::clamp(time * (rate + 0.5 * change * time), 0.0, step);
}

}  // namespace slalom::spline::detail
