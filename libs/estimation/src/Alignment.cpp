// SPDX-License-Identifier: BSD-3-Clause
#include "Alignment.h"

#include <algorithm>
#include <cmath>

#include "slalom/core/Math.h"

namespace slalom::estimation::detail
{
namespace
{
using Eigen::Vector3d;

constexpr double kGaugeWindow = 1.0;    // [s]
constexpr double kGaugeMinimum = 0.45;  // [s] of samples before a verdict
constexpr double kHysteresis = 0.7;     // of the minimum rate
constexpr double kImuPatience = 1.0;    // [s] how long a position waits for an IMU
constexpr double kMemory = 2.0;         // [s]
constexpr double kTiltWindow = 0.5;     // [s] to each side

constexpr double kTiltAtRest = 0.1;      // [rad]
constexpr double kTiltInFlight = 0.2;    // [rad]
constexpr double kQuietForce = 0.6;      // [m/s^2] rms about the mean
constexpr double kQuietRate = 0.05;      // [rad/s]
constexpr double kVelocityPrior = 10.0;  // [m/s] an airborne start may be fast

bool isPosition(const Aid& aid)
{
  return (aid.kind == AidKind::Position || aid.kind == AidKind::Pose) &&
         aid.sigma.array().isFinite().all();
}
}  // namespace

void ImuGauge::add(double t)
{
  times_.push_back(t);
  while (times_.front() < t - kGaugeWindow) times_.pop_front();
  const double span = t - times_.front();
  if (span < kGaugeMinimum)
  {
    // After a silence the old verdict says nothing.
    if (times_.size() == 1) adequate_ = false;
    return;
  }
  const double rate = static_cast<double>(times_.size() - 1) / span;
  adequate_ = rate >= config_.min_imu_rate_hz * (adequate_ ? kHysteresis : 1.0);
}

std::optional<Aid> gravityAt(double t, const std::deque<RatedImu>& samples)
{
  // Attitude relative to the first sample, and its value at t.
  std::vector<Eigen::Quaterniond> q;
  std::vector<const RatedImu*> used;
  for (const RatedImu& imu : samples)
  {
    if (std::abs(imu.sample.t - t) > kTiltWindow) continue;
    q.push_back(used.empty() ? Eigen::Quaterniond::Identity()
                             : q.back() * core::expSO3((imu.sample.t - used.back()->sample.t) *
                                                       imu.sample.w_B));
    used.push_back(&imu);
  }
  if (used.size() < 3) return std::nullopt;
  std::size_t now = 0;
  while (now + 1 < used.size() && used[now + 1]->sample.t <= t) ++now;

  Vector3d force = Vector3d::Zero();
  Vector3d rate = Vector3d::Zero();
  double square = 0.0;
  for (std::size_t i = 0; i < used.size(); ++i)
  {
    force += q[now].conjugate() * (q[i] * used[i]->sample.f_B);
    rate += used[i]->sample.w_B;
    square += used[i]->sample.f_B.squaredNorm();
  }
  const double n = static_cast<double>(used.size());
  force /= n;
  if (force.norm() < 0.2 * kGravity) return std::nullopt;  // free fall has no "up"
  const double scatter = std::sqrt(std::max(0.0, square / n - force.squaredNorm()));
  const bool quiet = scatter < kQuietForce && (rate / n).norm() < kQuietRate;

  Aid aid;
  aid.t = t;
  aid.kind = AidKind::Gravity;
  aid.slot = kSlots - 1;
  aid.z = force.normalized();
  aid.sigma.setConstant(quiet ? kTiltAtRest : kTiltInFlight);
  return aid;
}

void Alignment::add(const RatedImu& imu, bool adequate)
{
  if (!first_) first_ = imu.sample.t;
  newest_ = std::max(newest_, imu.sample.t);
  imu_.push_back(imu);
  has_gravity_ = adequate;
  trim();
}

void Alignment::add(const Aid& aid)
{
  if (!first_) first_ = aid.t;
  newest_ = std::max(newest_, aid.t);
  const auto later = std::upper_bound(aids_.begin(), aids_.end(), aid,
                                      [](const Aid& a, const Aid& b) { return a.t < b.t; });
  aids_.insert(later, aid);
  trim();
}

void Alignment::trim()
{
  while (!imu_.empty() && imu_.front().sample.t < newest_ - kMemory) imu_.pop_front();
  while (!aids_.empty() && aids_.front().t < newest_ - kMemory) aids_.pop_front();
}

std::optional<Start> Alignment::tryStart() const
{
  const auto fix = std::find_if(aids_.rbegin(), aids_.rend(), isPosition);
  if (fix == aids_.rend()) return std::nullopt;
  if (has_gravity_ && fix->t >= imu_.front().sample.t && fix->t <= imu_.back().sample.t)
    return startAt(*fix, true);
  if (!has_gravity_ && newest_ - *first_ >= kImuPatience) return startAt(*fix, false);
  return std::nullopt;
}

Start Alignment::startAt(const Aid& fix, bool inertial) const
{
  Start start;
  FilterState& s = start.state;
  s.t = fix.t;
  s.p = fix.z;
  s.P.setZero();
  // So wide that the fix itself, applied as the first event, decides.
  s.P.diagonal().segment<3>(kP).array() = std::pow(100.0 * (1.0 + fix.sigma.maxCoeff()), 2);
  s.P.diagonal().segment<3>(kV).array() = kVelocityPrior * kVelocityPrior;
  s.P.diagonal().segment<3>(kBg).array() = std::pow(config_.gyro_bias_sigma, 2);
  s.P.diagonal().segment<3>(kBa).array() = std::pow(config_.accel_bias_sigma, 2);
  double tilt_sigma = kTiltInFlight;
  if (const auto gravity = inertial ? gravityAt(fix.t, imu_) : std::nullopt)
  {
    s.q = Eigen::Quaterniond::FromTwoVectors(gravity->z, Vector3d::UnitZ());
    s.q = (core::fromYaw(-core::yawOf(s.q)) * s.q).normalized();
    tilt_sigma = gravity->sigma.x();
  }
  s.P.diagonal().segment<2>(kR).array() = tilt_sigma * tilt_sigma;
  if (inertial) s.last_imu = s.t;
  if (fix.kind == AidKind::Pose)
  {
    s.q = fix.q;
    start.heading_known = true;
  }

  for (const RatedImu& imu : imu_)
  {
    if (!inertial) break;
    if (imu.sample.t <= s.t)
      start.before = imu;
    else
      start.imu.push_back(imu);
  }
  for (const Aid& aid : aids_)
    if (aid.t >= s.t) start.aids.push_back(aid);
  return start;
}

}  // namespace slalom::estimation::detail
