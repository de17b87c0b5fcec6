// SPDX-License-Identifier: BSD-3-Clause
#include "MotionPredictor.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slalom::engine
{
namespace
{
constexpr double kMemory_s = 1.0;
constexpr double kObserver_s =
    2.5;  // slow against the loop: a delay not known must not look like a gust
constexpr double kLargest_mps2 = 2.0;

core::Motion motionOf(const core::VehicleState& state)
{
  return {state.p_L, state.v_W, 0.0, (state.q_WB * state.w_B).z()};
}

bool finite(const core::VehicleState& state)
{
  return std::isfinite(state.t) && state.p_L.allFinite() && state.v_W.allFinite() &&
         state.q_WB.coeffs().allFinite() && state.w_B.allFinite();
}

}  // namespace

void MotionPredictor::sent(double t, const core::VelocityCommand& command)
{
  if (!std::isfinite(t)) return;
  sent_.push_back({effectOf(t), command});
  while (sent_.size() > 1 && sent_[1].effect_t <= t - kMemory_s) sent_.pop_front();
}

void MotionPredictor::forget()
{
  sent_.clear();
  last_.reset();
  disturbance_W_.setZero();
}

core::Motion MotionPredictor::moved(core::Motion motion, double from, double to) const
{
  const Eigen::Vector3d push = vehicle_.velocity_lag_s * disturbance_W_;
  auto next = sent_.begin();
  while (next != sent_.end() && next->effect_t <= from) ++next;
  for (double t = from; t < to;)
  {
    const double until = next == sent_.end() ? to : std::min(to, next->effect_t);
    core::VelocityCommand command;
    if (next == sent_.begin())
      command = {motion.v, motion.yaw_rate};
    else
    {
      command = std::prev(next)->command;
      command.v_W += push;
    }
    motion = core::held(motion, command, until - t, vehicle_);
    t = until;
    if (next != sent_.end()) ++next;
  }
  return motion;
}

core::VelocityCommand MotionPredictor::inEffect(double t) const
{
  for (auto sent = sent_.rbegin(); sent != sent_.rend(); ++sent)
    if (sent->effect_t <= t) return sent->command;
  return {};
}

core::VehicleState MotionPredictor::at(const core::VehicleState& state, double t) const
{
  if (!(t > state.t) || !finite(state)) return state;
  const core::Motion there = moved(motionOf(state), state.t, t);
  core::VehicleState predicted = state;
  predicted.t = t;
  predicted.p_L = there.p;
  predicted.p_W += there.p - state.p_L;
  predicted.v_W = there.v;
  predicted.q_WB = core::fromYaw(there.yaw) * state.q_WB;
  predicted.w_B = predicted.q_WB.conjugate() * Eigen::Vector3d(0.0, 0.0, there.yaw_rate);
  return predicted;
}

void MotionPredictor::observe(const core::VehicleState& state)
{
  if (vehicle_.velocity_lag_s <= 0.0 || !finite(state)) return;
  if (last_ && state.t <= last_->t) return;
  const bool known = last_ && !sent_.empty() && sent_.front().effect_t <= last_->t &&
                     state.t - last_->t < kMemory_s;
  if (known)
  {
    const double dt = state.t - last_->t;
    const core::Motion expected = moved(motionOf(*last_), last_->t, state.t);
    // What a constant push would have done to the velocity in this time, per m/s^2.
    const double response = -vehicle_.velocity_lag_s * std::expm1(-dt / vehicle_.velocity_lag_s);
    disturbance_W_ += -std::expm1(-dt / kObserver_s) * (state.v_W - expected.v) / response;
    const double size = disturbance_W_.norm();
    if (size > kLargest_mps2) disturbance_W_ *= kLargest_mps2 / size;
  }
  last_ = state;
}

}  // namespace slalom::engine
