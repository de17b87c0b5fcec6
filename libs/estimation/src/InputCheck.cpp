// SPDX-License-Identifier: BSD-3-Clause
#include "InputCheck.h"

#include <algorithm>
#include <cmath>

namespace slalom::estimation::detail
{
namespace
{
using Eigen::Vector3d;

// Nothing that flies under this filter comes near; such values are damaged or in the wrong unit.
constexpr double kForceLimit = 1000.0;    // [m/s^2]
constexpr double kRateLimit = 100.0;      // [rad/s]
constexpr double kPositionLimit = 1e6;    // [m]
constexpr double kVelocityLimit = 200.0;  // [m/s]
constexpr double kLeverLimit = 100.0;     // [m]
constexpr double kSigmaFloor = 1e-3;
constexpr double kUselessSigma = 1e4;

const char* defect(double t, const Vector3d& value, double limit)
{
  if (!std::isfinite(t) || !value.allFinite()) return "non_finite";
  return value.norm() > limit ? "out_of_range" : nullptr;
}

const char* defectOfSigma(const Vector3d& sigma)
{
  return (sigma.array() >= 0.0).all() ? nullptr : "bad_sigma";  // false for NaN
}

Vector3d usableSigma(const Vector3d& sigma)
{
  constexpr double kNotMeasured = std::numeric_limits<double>::infinity();
  return sigma.unaryExpr([](double s)
                         { return s > kUselessSigma ? kNotMeasured : std::max(s, kSigmaFloor); });
}
}  // namespace

const char* defect(const core::ImuSample& sample)
{
  const char* force = defect(sample.t, sample.f_B, kForceLimit);
  return force ? force : defect(sample.t, sample.w_B, kRateLimit);
}

const char* defect(const core::PositionFix& fix)
{
  if (const char* position = defect(fix.t, fix.p_W, kPositionLimit)) return position;
  if (const char* lever = defect(fix.t, fix.lever_B, kLeverLimit)) return lever;
  return defectOfSigma(fix.sigma);
}

const char* defect(const core::VelocityFix& fix)
{
  // The value of an axis that is not measured may be anything.
  const Vector3d measured = fix.sigma.array().isInf().select(Vector3d::Zero(), fix.v);
  const char* velocity = defect(fix.t, measured, kVelocityLimit);
  return velocity ? velocity : defectOfSigma(fix.sigma);
}

const char* defect(const core::YawFix& fix)
{
  if (!std::isfinite(fix.t) || !std::isfinite(fix.yaw)) return "non_finite";
  return fix.sigma >= 0.0 ? nullptr : "bad_sigma";
}

const char* defect(const core::PoseFix& fix)
{
  if (const char* position = defect(fix.t, fix.T_WB.translation(), kPositionLimit)) return position;
  const Eigen::Matrix3d R = fix.T_WB.linear();
  if (!R.allFinite()) return "non_finite";
  if (!R.isUnitary(1e-3) || R.determinant() < 0.0) return "out_of_range";
  return fix.sigma_position >= 0.0 && fix.sigma_rotation >= 0.0 ? nullptr : "bad_sigma";
}

Aid toAid(const core::PositionFix& fix, int slot)
{
  Aid aid;
  aid.t = fix.t;
  aid.kind = AidKind::Position;
  aid.slot = slot;
  aid.z = fix.p_W;
  aid.sigma = usableSigma(fix.sigma);
  aid.lever_B = fix.lever_B;
  return aid;
}

Aid toAid(const core::VelocityFix& fix, int slot)
{
  Aid aid;
  aid.t = fix.t;
  aid.kind = fix.in_body ? AidKind::BodyVelocity : AidKind::Velocity;
  aid.slot = slot;
  aid.z = fix.v;
  aid.sigma = usableSigma(fix.sigma);
  return aid;
}

Aid toAid(const core::YawFix& fix, int slot)
{
  Aid aid;
  aid.t = fix.t;
  aid.kind = AidKind::Yaw;
  aid.slot = slot;
  aid.z.x() = fix.yaw;
  aid.sigma = usableSigma(Vector3d::Constant(fix.sigma));
  return aid;
}

Aid toAid(const core::PoseFix& fix, int slot)
{
  Aid aid;
  aid.t = fix.t;
  aid.kind = AidKind::Pose;
  aid.slot = slot;
  aid.z = fix.T_WB.translation();
  aid.sigma = usableSigma(Vector3d::Constant(fix.sigma_position));
  aid.q = Eigen::Quaterniond(fix.T_WB.linear()).normalized();
  aid.sigma_rotation = std::clamp(fix.sigma_rotation, kSigmaFloor, 3.0);
  return aid;
}

}  // namespace slalom::estimation::detail
