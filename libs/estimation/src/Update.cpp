// SPDX-License-Identifier: BSD-3-Clause
#include "Update.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "slalom/core/Math.h"

namespace slalom::estimation::detail
{
namespace
{
using Eigen::Matrix3d;
using Eigen::Vector3d;

// Up to three scalar measurements, without heap.
template <int Cols>
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Cols, Cols == 1 ? 0 : Eigen::RowMajor, 3, Cols>;
using SquareMax3 = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3>;
using Gain = Eigen::Matrix<double, 15, Eigen::Dynamic, 0, 15, 3>;

/// Residual r = H dx + noise, over the first nine states.
struct Innovation
{
  Rows<1> residual;
  Rows<9> H;
  Rows<1> variance;
};

constexpr double kWorstChi2 = 25.0;    // one outlier may not decide between hypotheses
constexpr double kAidMemory = 1.0;     // [s] a source heard this recently is healthy
constexpr double kLostVelocity = 3.0;  // [m/s] after a run of rejects
constexpr double kLostTilt = 0.1;      // [rad]
constexpr double kLostYaw = 0.35;      // [rad]

double gateFor(double gate3, Eigen::Index dimension)
{
  // 99 % quantiles of the chi-square distribution with 1, 2, 3 degrees of freedom.
  constexpr std::array<double, 4> kQuantile{0.0, 6.635, 9.210, 11.345};
  return gate3 * kQuantile[static_cast<std::size_t>(dimension)] / kQuantile[3];
}

Innovation keepMeasured(const Vector3d& residual, const Eigen::Matrix<double, 3, 9>& H,
                        const Vector3d& sigma)
{
  Innovation kept;
  const Eigen::Index n = sigma.array().isFinite().count();
  kept.residual.resize(n);
  kept.H.resize(n, 9);
  kept.variance.resize(n);
  for (Eigen::Index axis = 0, row = 0; axis < 3; ++axis)
  {
    if (!std::isfinite(sigma[axis])) continue;
    kept.residual[row] = residual[axis];
    kept.H.row(row) = H.row(axis);
    kept.variance[row++] = sigma[axis] * sigma[axis];
  }
  return kept;
}

void inject(FilterState& s, const Vector15& dx)
{
  s.p += dx.segment<3>(kP);
  s.v += dx.segment<3>(kV);
  s.q = (core::expSO3(dx.segment<3>(kR)) * s.q).normalized();
  s.bg += dx.segment<3>(kBg);
  s.ba += dx.segment<3>(kBa);
}

void addEvidence(FilterState& s, double chi2, double log_det)
{
  s.log_likelihood -= 0.5 * (std::min(chi2, kWorstChi2) + log_det);
}

/// Joseph form (I - K H) P (I - K H)^T + K R K^T, using that H is thin.
bool correct(FilterState& s, const Innovation& in, double gate)
{
  const Gain PHt = s.P.leftCols<9>() * in.H.transpose();
  SquareMax3 S = in.H * PHt.topRows<9>();
  S.diagonal() += in.variance;
  const Eigen::LLT<SquareMax3> factor(S);
  const double chi2 = in.residual.dot(factor.solve(in.residual));
  addEvidence(s, chi2, 2.0 * factor.matrixLLT().diagonal().array().log().sum());
  if (!(chi2 <= gateFor(gate, in.residual.size()))) return false;

  const Gain K = factor.solve(PHt.transpose()).transpose();
  Matrix15 M = s.P;
  M.noalias() -= K * PHt.transpose();
  const Gain MHt = M.leftCols<9>() * in.H.transpose();
  M.noalias() -= MHt * K.transpose();
  M.noalias() += K * in.variance.asDiagonal() * K.transpose();
  s.P = 0.5 * (M + M.transpose());
  inject(s, K * in.residual);
  return true;
}

Innovation positionInnovation(const FilterState& s, const Aid& aid)
{
  const Vector3d lever_W = s.q * aid.lever_B;
  Eigen::Matrix<double, 3, 9> H = Eigen::Matrix<double, 3, 9>::Zero();
  H.middleCols<3>(kP).setIdentity();
  H.middleCols<3>(kR) = -core::skew(lever_W);
  return keepMeasured(aid.z - s.p - lever_W, H, aid.sigma);
}

Innovation velocityInnovation(const FilterState& s, const Aid& aid)
{
  Eigen::Matrix<double, 3, 9> H = Eigen::Matrix<double, 3, 9>::Zero();
  H.middleCols<3>(kV).setIdentity();
  return keepMeasured(aid.z - s.v, H, aid.sigma);
}

/// A world vector u_W seen in body axes; `moving` if it is the velocity state itself.
Innovation bodyVectorInnovation(const FilterState& s, const Aid& aid, const Vector3d& u_W,
                                bool moving)
{
  const Matrix3d R_BW = s.q.toRotationMatrix().transpose();
  Eigen::Matrix<double, 3, 9> H = Eigen::Matrix<double, 3, 9>::Zero();
  if (moving) H.middleCols<3>(kV) = R_BW;
  H.middleCols<3>(kR) = R_BW * core::skew(u_W);
  return keepMeasured(aid.z - R_BW * u_W, H, aid.sigma);
}

Innovation yawInnovation(const FilterState& s, double yaw, double sigma)
{
  const Vector3d x_W = s.q * Vector3d::UnitX();
  const double horizontal2 = x_W.head<2>().squaredNorm();
  Eigen::Matrix<double, 3, 9> H = Eigen::Matrix<double, 3, 9>::Zero();
  H(0, kR) = -x_W.x() * x_W.z() / horizontal2;
  H(0, kR + 1) = -x_W.y() * x_W.z() / horizontal2;
  H(0, kR + 2) = 1.0;
  constexpr double kNot = std::numeric_limits<double>::infinity();
  // A vertical nose has no heading.
  const double usable = horizontal2 > 0.1 ? sigma : kNot;
  return keepMeasured({core::wrapAngle(yaw - core::yawOf(s.q)), 0.0, 0.0}, H, {usable, kNot, kNot});
}

Innovation rotationInnovation(const FilterState& s, const Aid& aid)
{
  const Eigen::AngleAxisd error((aid.q * s.q.conjugate()).normalized());
  Eigen::Matrix<double, 3, 9> H = Eigen::Matrix<double, 3, 9>::Zero();
  H.middleCols<3>(kR).setIdentity();
  return keepMeasured(error.angle() * error.axis(), H, Vector3d::Constant(aid.sigma_rotation));
}

Innovation innovation(const FilterState& s, const Aid& aid)
{
  switch (aid.kind)
  {
    case AidKind::Position:
    case AidKind::Pose:
      return positionInnovation(s, aid);
    case AidKind::Velocity:
      return velocityInnovation(s, aid);
    case AidKind::BodyVelocity:
      return bodyVectorInnovation(s, aid, s.v, true);
    case AidKind::Yaw:
      return yawInnovation(s, aid.z.x(), aid.sigma.x());
    case AidKind::Gravity:
      break;
  }
  return bodyVectorInnovation(s, aid, Vector3d::UnitZ(), false);
}

void forget(Matrix15& P, int i, double sigma)
{
  P.row(i).setZero();
  P.col(i).setZero();
  P(i, i) = sigma * sigma;
}

void atLeast(Matrix15& P, int i, double sigma)
{
  P(i, i) = std::max(P(i, i), sigma * sigma);
}

void doubtAttitude(Matrix15& P)
{
  atLeast(P, kR, kLostTilt);
  atLeast(P, kR + 1, kLostTilt);
  atLeast(P, kR + 2, kLostYaw);
}

void takePosition(FilterState& s, const Aid& aid)
{
  const Vector3d p = aid.z - s.q * aid.lever_B;
  const bool velocity_healthy = s.t - s.last_velocity < kAidMemory;
  for (int i = 0; i < 3; ++i)
  {
    if (!std::isfinite(aid.sigma[i])) continue;
    s.p[i] = p[i];
    forget(s.P, kP + i, aid.sigma[i]);
    if (!velocity_healthy) atLeast(s.P, kV + i, kLostVelocity);
  }
  if (!velocity_healthy) doubtAttitude(s.P);
}

void takeVelocity(FilterState& s, const Aid& aid, const Vector3d& v_W)
{
  // With an axis missing only a wide guess is left.
  const double worst = aid.sigma.array().isFinite().all() ? aid.sigma.maxCoeff() : kLostVelocity;
  for (int i = 0; i < 3; ++i)
  {
    s.v[i] = v_W[i];
    forget(s.P, kV + i, worst);
  }
  doubtAttitude(s.P);
}

Vector3d measuredOr(const Aid& aid, const Vector3d& other)
{
  return aid.sigma.array().isFinite().select(aid.z, other);
}

void reinitialise(FilterState& s, const Aid& aid)
{
  switch (aid.kind)
  {
    case AidKind::Position:
      takePosition(s, aid);
      break;
    case AidKind::Velocity:
      takeVelocity(s, aid, measuredOr(aid, s.v));
      break;
    case AidKind::BodyVelocity:
      takeVelocity(s, aid, s.q * measuredOr(aid, s.q.conjugate() * s.v));
      break;
    case AidKind::Yaw:
      s.q = (core::fromYaw(aid.z.x() - core::yawOf(s.q)) * s.q).normalized();
      forget(s.P, kR + 2, aid.sigma.x());
      break;
    case AidKind::Pose:
      takePosition(s, aid);
      s.q = aid.q;
      for (int i = 0; i < 3; ++i) forget(s.P, kR + i, aid.sigma_rotation);
      break;
    case AidKind::Gravity:
      doubtAttitude(s.P);
      break;
  }
  ++s.resets;
}

void remember(FilterState& s, AidKind kind)
{
  if (kind == AidKind::Position || kind == AidKind::Pose) s.last_position = s.t;
  if (kind == AidKind::Velocity || kind == AidKind::BodyVelocity) s.last_velocity = s.t;
  if (kind == AidKind::BodyVelocity) s.last_body_velocity = s.t;
  if (kind == AidKind::Yaw || kind == AidKind::Pose) s.last_heading = s.t;
  if (kind == AidKind::Pose) s.last_rotation = s.t;
}

/// Position and rotation of a pose are believed together or not at all.
bool correctPose(FilterState& s, const Aid& aid, const Innovation& position, double gate)
{
  const FilterState before = s;
  if (correct(s, position, gate) && correct(s, rotationInnovation(s, aid), gate)) return true;
  const double evidence = s.log_likelihood;
  s = before;
  s.log_likelihood = evidence;
  return false;
}
}  // namespace

Outcome applyAid(FilterState& s, const Aid& aid, const FilterConfig& config, double gate)
{
  const Innovation first = innovation(s, aid);
  if (first.residual.size() == 0) return Outcome::Undefined;

  const bool accepted =
      aid.kind == AidKind::Pose ? correctPose(s, aid, first, gate) : correct(s, first, gate);
  std::uint16_t& rejects = s.rejects[static_cast<std::size_t>(aid.slot)];
  if (!accepted)
  {
    if (++rejects < config.max_rejects) return Outcome::Gated;
    reinitialise(s, aid);
  }
  rejects = 0;
  remember(s, aid.kind);
  return Outcome::Accepted;
}

void applyCourse(FilterState& s, const FilterConfig& config)
{
  constexpr double kSlow = 1.0;  // [m/s]
  constexpr double kCrab = 0.5;  // [rad] between nose and course
  const double speed = s.v.head<2>().norm();
  const double sigma_v = std::sqrt(0.5 * (s.P(kV, kV) + s.P(kV + 1, kV + 1)));
  if (speed < kSlow || speed < 2.0 * sigma_v) return;
  const double sigma = std::hypot(kCrab, sigma_v / speed);
  const Innovation in = yawInnovation(s, std::atan2(s.v.y(), s.v.x()), sigma);
  if (in.residual.size() == 1) correct(s, in, 1e3 * config.gate);
  // A vehicle that flies sideways does so for long: many courses know no more than one.
  atLeast(s.P, kR + 2, kCrab);
}

}  // namespace slalom::estimation::detail
