// SPDX-License-Identifier: BSD-3-Clause
#include "StateSource.h"

#include <algorithm>
#include <type_traits>

namespace slalom::engine
{
namespace
{
using Kind = StateSourceKind;

template <class... Types>
bool isOneOf(const core::Measurement& measurement)
{
  return (std::holds_alternative<Types>(measurement) || ...);
}

}  // namespace

StateSource::StateSource(const StateConfig& config, const estimation::FilterConfig& filter)
    : config_(config), estimator_(filter), kind_(config.source)
{
}

void StateSource::add(const core::Measurement& measurement)
{
  if (kind_ == Kind::Auto || (onlyAssumed() && isOneOf<core::PositionFix>(measurement)))
    decide(measurement);
  if (kind_ == Kind::Static) newest_ = std::max(newest_, core::timeOf(measurement));
  if (isOneOf<core::RangeScan>(measurement)) return;
  if (kind_ == Kind::Auto)
    undecided_.push_back(measurement);
  else
    feed(measurement);
}

void StateSource::decide(const core::Measurement& measurement)
{
  constexpr double kPreferFusion_s = 1.0;  // a pose source may speak before the first GPS fix does
  const double t = core::timeOf(measurement);
  if (!first_) first_ = t;
  const bool poses = std::any_of(undecided_.begin(), undecided_.end(),
                                 [](const auto& m) { return isOneOf<core::PoseFix>(m); });
  was_assumed_ = onlyAssumed();
  if (isOneOf<core::PositionFix>(measurement))
    kind_ = Kind::Fusion;
  else if (poses && t - *first_ > kPreferFusion_s)
    kind_ = Kind::PoseObservation;
  else if (t - *first_ > config_.wait_s)
    kind_ = Kind::Static;
  if (kind_ == Kind::Auto) return;
  for (const core::Measurement& earlier : undecided_) feed(earlier);
  undecided_.clear();
}

void StateSource::feed(const core::Measurement& measurement)
{
  const bool poses = kind_ == Kind::PoseObservation || kind_ == Kind::Truth;
  std::visit(
      [&](const auto& m)
      {
        using M = std::decay_t<decltype(m)>;
        if constexpr (std::is_same_v<M, core::PoseFix>)
        {
          if (poses) estimator_.add(m);
        }
        else if constexpr (std::is_same_v<M, core::ImuSample>)
        {
          if (kind_ == Kind::Fusion || poses) estimator_.add(m);
        }
        else if constexpr (!std::is_same_v<M, core::RangeScan>)
        {
          if (kind_ == Kind::Fusion) estimator_.add(m);
        }
      },
      measurement);
  if (const auto state = estimator_.state()) followFrame(*state);
}

void StateSource::followFrame(const core::VehicleState& state)
{
  constexpr double kJump_m = 5.0;  // no vehicle moves this far between two measurements
  newest_ = state.t;
  const bool jumped = last_ && (state.p_L - last_->p_L).norm() >
                                   kJump_m + state.v_W.norm() * std::max(0.0, state.t - last_->t);
  if (jumped) ++frame_epoch_;
  // A vehicle that was assumed to stand at the origin goes on from there, so that its map stays
  // good.
  if (!origin_L_ || jumped)
    origin_L_ = was_assumed_ && !jumped ? Eigen::Vector3d(-state.p_L)
                                        : Eigen::Vector3d(state.p_W - state.p_L);
  last_ = state;
}

std::optional<core::VehicleState> StateSource::placed(std::optional<core::VehicleState> state) const
{
  if (state && origin_L_) state->p_L += *origin_L_;
  return state;
}

std::optional<core::VehicleState> StateSource::state(double t) const
{
  if (kind_ == Kind::Auto) return std::nullopt;
  if (kind_ != Kind::Static)
    if (auto exact = estimator_.stateAt(t)) return placed(exact);
  if (kind_ == Kind::Static)
  {
    core::VehicleState still;
    still.t = t;
    return still;
  }
  return placed(estimator_.state());
}

std::optional<core::VehicleState> StateSource::stateAt(double t) const
{
  return kind_ == Kind::Static ? state(t) : placed(estimator_.stateAt(t));
}

std::string StateSource::name() const
{
  switch (kind_)
  {
    case Kind::Auto:
      return "undecided";
    case Kind::Fusion:
      return "fusion";
    case Kind::PoseObservation:
      return "pose_observation";
    case Kind::Static:
      return "static";
    case Kind::Truth:
      return "truth";
  }
  return "?";
}

}  // namespace slalom::engine
