// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/simulation/FlownPath.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace slalom::simulation
{
FlownPath::FlownPath(double step, double memory, const MotionSample& start)
    : step_(step), states_{start}
{
  if (!(step > 0.0) || !(memory >= step) || !std::isfinite(memory))
    throw std::invalid_argument("FlownPath: step " + std::to_string(step) + " s, memory " +
                                std::to_string(memory) + " s");
  remembered_ = static_cast<std::size_t>(std::ceil(memory / step)) + 2;
}

void FlownPath::append(const MotionSample& next)
{
  states_.push_back(next);
  if (states_.size() <= remembered_) return;
  states_.pop_front();
  ++forgotten_;
}

double FlownPath::end() const
{
  return step_ * static_cast<double>(forgotten_ + static_cast<std::int64_t>(states_.size()) - 1);
}

FlownPath::Interval FlownPath::around(double t) const
{
  const double last = static_cast<double>(states_.size() - 1);
  const double place = std::clamp(t / step_ - static_cast<double>(forgotten_), 0.0, last);
  // At a state itself: that state, to the last bit.
  const double nearest = std::round(place);
  const double exact = std::abs(place - nearest) < 1e-9 ? nearest : place;
  const auto from = static_cast<std::size_t>(exact);
  const std::size_t to = std::min(from + 1, states_.size() - 1);
  return {states_[from], states_[to], exact - static_cast<double>(from)};
}

Eigen::Isometry3d FlownPath::pose(double t) const
{
  const auto [a, b, s] = around(t);
  if (s == 0.0)
  {
    Eigen::Isometry3d pose(a.q_WB);
    pose.translation() = a.p_W;
    return pose;
  }
  const double r = 1.0 - s;
  Eigen::Isometry3d pose(a.q_WB.slerp(s, b.q_WB));
  pose.translation() = r * r * (1.0 + 2.0 * s) * a.p_W + s * s * (3.0 - 2.0 * s) * b.p_W +
                       step_ * s * r * (r * a.v_W - s * b.v_W);
  return pose;
}

MotionSample FlownPath::at(double t) const
{
  const auto [a, b, s] = around(t);
  if (s == 0.0) return a;
  MotionSample between;
  const Eigen::Isometry3d here = pose(t);
  between.p_W = here.translation();
  between.q_WB = a.q_WB.slerp(s, b.q_WB);
  between.v_W = a.v_W + s * (b.v_W - a.v_W);
  between.a_W = a.a_W + s * (b.a_W - a.a_W);
  between.w_B = a.w_B + s * (b.w_B - a.w_B);
  return between;
}

}  // namespace slalom::simulation
