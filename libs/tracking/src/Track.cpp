// SPDX-License-Identifier: BSD-3-Clause
#include "Track.h"

#include <algorithm>
#include <cmath>

namespace slalom::tracking::detail
{
namespace
{
constexpr double kFirstSpeed = 1.2;        // [m/s] standard deviation before anything is known
constexpr double kClimb = 0.25;            // share of the acceleration that is expected in height
constexpr double kRingGap = 0.0175;        // [1] half the slope between rings of a 16-ring lidar
constexpr double kFootprintPeriod = 0.09;  // [s]
constexpr double kReach = 0.4;             // [m] that a mover has to go to uncover its place
constexpr double kShrink = 0.2;            // [m/s] at which a size once seen is given up
constexpr int kInformative = 6;            // looks that a share needs

// Shares of looks at points.
struct Tally
{
  int free = 0, all = 0;
  void add(Seen seen)
  {
    free += seen == Seen::Free;
    all += seen != Seen::Nothing;
  }
  [[nodiscard]] double share() const { return all > 0 ? static_cast<double>(free) / all : 0.0; }
};

// What several panoramas say together: one that saw a surface outweighs all that did not.
Seen judge(const RangeHistory& history, std::span<const int> ages, const Eigen::Vector3f& p_L)
{
  Seen verdict = Seen::Nothing;
  for (const int age : ages)
  {
    const Seen seen = history.look(age, p_L);
    if (seen == Seen::Surface) return Seen::Surface;
    if (seen == Seen::Free || verdict == Seen::Nothing) verdict = seen;
  }
  return verdict;
}

}  // namespace

void Track::Covariance::predict(double dt, double sigma_acceleration)
{
  // White acceleration of that standard deviation over one second.
  const double q = sigma_acceleration * sigma_acceleration;
  pp += 2.0 * dt * pv + dt * dt * vv + q * dt * dt * dt / 3.0;
  pv += dt * vv + 0.5 * q * dt * dt;
  vv += q * dt;
}

std::pair<double, double> Track::Covariance::correct(double variance)
{
  const double k = pp / (pp + variance), l = pv / (pp + variance);
  vv -= l * pv;
  pv -= l * pp;
  pp -= k * pp;
  return {k, l};
}

Track::Track(std::uint64_t number, const TrackingConfig& config, double time, const Object& object)
    : id(number),
      t(time),
      seen(time),
      last_fast(time),
      p_L(object.centre_L),
      half_width_m(object.half_width_m),
      half_height_m(object.half_height_m),
      tallest_m_(object.half_height_m),
      config_(config),
      plane_{config.sigma_position_m * config.sigma_position_m, 0.0, kFirstSpeed * kFirstSpeed},
      height_{plane_.pp, 0.0, 0.25 * plane_.vv}
{
}

void Track::predict(double time)
{
  const double dt = time - t;
  p_L += dt * v_L;
  plane_.predict(dt, config_.sigma_acceleration);
  height_.predict(dt, kClimb * config_.sigma_acceleration);
  t = time;
}

void Track::correct(const Object& object, double range_m)
{
  // A change of the visible size means that something hides a part: the centre is then less sure.
  const double other = std::fabs(object.half_width_m - half_width_m) / std::max(half_width_m, 0.1);
  const double sigma = config_.sigma_position_m * (1.0 + 4.0 * std::min(other, 1.0));
  ring_gap_m_ = kRingGap * range_m;
  const double sigma_z = sigma + ring_gap_m_;

  const Eigen::Vector3d error = object.centre_L - p_L;
  const auto [k, l] = plane_.correct(sigma * sigma);
  p_L.head<2>() += k * error.head<2>();
  v_L.head<2>() += l * error.head<2>();
  const auto [kz, lz] = height_.correct(sigma_z * sigma_z);
  p_L.z() += kz * error.z();
  v_L.z() += lz * error.z();

  const double shrunk = kShrink * (t - seen);
  half_width_m = std::max(object.half_width_m, half_width_m - shrunk);
  half_height_m = std::max(object.half_height_m, half_height_m - shrunk);
  // From nearby a lidar sees but a part of it: it is as tall as it once was.
  tallest_m_ = std::max(half_height_m, tallest_m_);
  seen = t;
}

void Track::remember(std::span<const core::Ray> rays, const Object& object)
{
  if (stored_ > 0 && t - footprint(0).t < kFootprintPeriod) return;
  newest_ = (newest_ + 1) % kFootprints;
  stored_ = std::min(stored_ + 1, kFootprints);
  Footprint& now = footprints_[static_cast<std::size_t>(newest_)];
  now.t = t;
  now.centre_L = object.centre_L;
  now.half_width_m = object.half_width_m;
  now.half_height_m = object.half_height_m;
  now.count = std::min(object.rays.size(), Footprint::kEnds);
  for (std::size_t i = 0; i < now.count; ++i)
    now.ends_L[i] = rays[object.rays[i * object.rays.size() / now.count]].end_L;
}

std::optional<double> Track::evidence(const RangeHistory& history, std::span<const core::Ray> rays,
                                      const Object& object) const
{
  constexpr int kLooks = 4;
  constexpr double kApart = 0.4;  // [s] between the panoramas that are asked
  std::array<int, kLooks> ages;
  std::size_t count = 0;
  double before = t - lag();
  for (int age = 0; age < history.size() && count < kLooks; ++age)
  {
    if (history.time(age) > before + 1e-6) continue;
    ages[count++] = age;
    before = history.time(age) - kApart;
  }

  // Twigs and leaves are missed by one panorama, hardly by several.
  constexpr std::size_t kEnough = 3;
  if (count < kEnough) return std::nullopt;

  constexpr std::size_t kSample = 64;
  Tally entered, left;
  const std::size_t looks = std::min(object.rays.size(), kSample);
  for (std::size_t i = 0; i < looks; ++i)
    entered.add(judge(history, std::span(ages).first(count),
                      rays[object.rays[i * object.rays.size() / looks]].end_L));
  if (const Footprint* former = footprintBefore(t - lag()))
    for (std::size_t i = 0; i < former->count; ++i) left.add(history.look(0, former->ends_L[i]));

  if (entered.all < kInformative && left.all < kInformative) return std::nullopt;
  return (entered.all < kInformative ? 0.0 : entered.share()) +
         (left.all < kInformative ? 0.0 : left.share());
}

bool Track::fastEnough() const
{
  if (speed() < config_.min_speed_mps) return false;
  const Footprint* former = footprintBefore(t - lag());
  if (former == nullptr) return false;
  const Eigen::Vector2d way = (p_L - former->centre_L).head<2>();
  constexpr double kSameWay = 0.7;  // cosine
  const double sigma = std::sqrt(plane_.pp + config_.sigma_position_m * config_.sigma_position_m);
  return way.norm() >= std::max(config_.min_displacement_m, config_.significance * sigma) &&
         way.dot(v_L.head<2>()) >= kSameWay * way.norm() * speed();
}

double Track::lag() const
{
  return std::clamp(std::max(kReach, half_width_m) / std::max(speed(), 1e-3), 0.4, 1.7);
}

const Footprint* Track::footprintBefore(double time) const
{
  for (int age = 0; age < stored_; ++age)
    if (footprint(age).t <= time + 1e-6) return &footprint(age);
  return nullptr;
}

double Track::gate() const
{
  return std::min(1.0, 0.3 + 2.0 * std::sqrt(plane_.pp));
}

core::MovingObstacle Track::at(double time) const
{
  Covariance plane = plane_;
  plane.predict(std::max(0.0, time - t), config_.sigma_acceleration);
  core::MovingObstacle mover;
  mover.id = id;
  mover.t = time;
  mover.p_L = p_L + (time - t) * v_L;
  mover.v_L = v_L;
  // The lowest capsule that holds an upright cylinder: its caps reach into the rim.
  const double margin = config_.radius_margin_m;
  mover.radius_m = half_width_m + margin;
  mover.half_axis_m =
      std::max(0.0, tallest_m_ + ring_gap_m_ - std::sqrt(margin * (2.0 * half_width_m + margin)));
  mover.sigma_p_m = std::sqrt(plane.pp);
  mover.sigma_v_mps = std::sqrt(plane.vv);
  return mover;
}

}  // namespace slalom::tracking::detail
