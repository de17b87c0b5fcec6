// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <limits>
#include <vector>

namespace slalom::spline::detail
{
/** How far limits give way to a start that cannot keep them. */
struct Relief
{
  double acceleration = 1.0;  ///< factor on every acceleration limit, >= 1
  bool speed = false;         ///< speed limits are dropped
};

/** Limits on one interval of a grid along a curve with parameter q.
 *
 *  With x = (dq/dt)^2 and w = d2q/dt2, constant on the interval, x is linear in q and every limit
 * is linear in w and x at the start of the interval. No limit forbids w = x = 0, so the x for which
 * a w exists are an interval [0, largest]. */
class IntervalLimits
{
 public:
  /** @param step length of the interval in q
   *  @param negligible factors of w up to this are taken as 0
   *  @param x_max bound on x that holds under every relief */
  IntervalLimits(double step, double negligible,
                 double x_max = std::numeric_limits<double>::infinity())
      : step_(step), negligible_(negligible), x_hard_(x_max)
  {
  }

  /// |along w + bend x| <= limit: an acceleration. At most nine.
  void limitAcceleration(double along, double bend, double limit);
  /// along w + bend x <= limit with along > 0, bend >= 0: a squared speed. At most twelve.
  void limitSpeed(double along, double bend, double limit);
  /// x <= bound at the start and at the end of the interval: squared speeds too.
  void capSpeed(double x_at_start, double x_at_end);
  /** x at the end is at least `share` of x at the start, share in [0, 1]. Keeps the passage from
   * standing still where a single interval could just about stop a pace that is too high. */
  void keepShare(double share) { share_ = share; }

  [[nodiscard]] double step() const { return step_; }
  /// Largest x at the end of the interval.
  [[nodiscard]] double capAtEnd(const Relief& relief) const;
  /// Largest x at the start from which some w leads to at most `next` at the end.
  [[nodiscard]] double largestX(double next, const Relief& relief) const;
  /// x at the end: as large as the limits allow from x at the start, at most `wish`.
  [[nodiscard]] double fastest(double x, double wish, const Relief& relief) const;
  /// x at the end: as small as the limits allow, at least `wish`.
  [[nodiscard]] double slowest(double x, double wish, const Relief& relief) const;
  /// Largest ratio of an acceleration, or of a speed, to its limit when x becomes `next`.
  [[nodiscard]] double worstRatio(double x, double next) const;

 private:
  struct Line  ///< a bound on w at x: offset + slope x
  {
    double offset, slope;
    [[nodiscard]] double at(double x) const { return offset + slope * x; }
  };
  [[nodiscard]] Line lowest(double x, const Relief& relief) const;
  [[nodiscard]] Line highest(double x, const Relief& relief) const;

  double step_, negligible_, x_hard_, share_ = 0.0;
  double x_bend_ = std::numeric_limits<double>::infinity();  ///< accelerations that w cannot change
  double x_start_ = std::numeric_limits<double>::infinity();
  double x_end_ = std::numeric_limits<double>::infinity();
  int bands_ = 0, ceilings_ = 0;
  std::array<Line, 9> band_;      ///< slope x - offset <= w <= slope x + offset
  std::array<Line, 12> ceiling_;  ///< w <= offset + slope x
};

/** Largest x per node of the grid from which at most x_end can be reached at its end (backward pass
 * of the reachability analysis; Pham and Pham 2018). Above 0 everywhere before the end.
 *  @return intervals + 1 values */
[[nodiscard]] std::vector<double> controllable(const std::vector<IntervalLimits>& intervals,
                                               double x_end, const Relief& relief = {});

/** Forward pass: takes the largest w that stays controllable.
 *  @param x_start at most reachable.front()
 *  @return x per node */
[[nodiscard]] std::vector<double> fastest(const std::vector<IntervalLimits>& intervals,
                                          const std::vector<double>& reachable, double x_start);

/// A passage that leaves the controllable set at its start, and what it costs.
struct Braking
{
  std::vector<double> x;  ///< per node
  double ratio = 1.0;     ///< largest acceleration or speed relative to its limit
};

/** Where x_start is not controllable: accelerations give way by the smallest common factor that
 * makes it so, speeds as long as they must; once controllable, as `fastest`. */
[[nodiscard]] Braking brake(const std::vector<IntervalLimits>& intervals,
                            const std::vector<double>& reachable, double x_start);

/// Time from the start of an interval to its end.
[[nodiscard]] double passageTime(double x, double next, double step);
/// Distance from the start of an interval, a time after it.
[[nodiscard]] double passageDistance(double x, double next, double step, double time);

}  // namespace slalom::spline::detail
