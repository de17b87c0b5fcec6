// SPDX-License-Identifier: BSD-3-Clause
#include "SyntheticFlight.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "slalom/core/Rng.h"

namespace slalom::test
{
namespace
{
constexpr double kDuration = 30.0, kSpeed = 1.35;

double rayDistance(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c)
{
  const Eigen::Vector2d d = b - a;
  const double share = std::clamp(d.dot(c - a) / std::max(d.squaredNorm(), 1e-9), 0.0, 1.0);
  return (a + share * d - c).norm();
}
}  // namespace

SeenForest::SeenForest(std::shared_ptr<const std::vector<Trunk>> trunks,
                       const Eigen::Vector3d& here, std::uint64_t sequence)
    : here_(here.head<2>()), sequence_(sequence)
{
  auto near = std::make_shared<std::vector<Trunk>>();
  for (const Trunk& trunk : *trunks)
    if ((trunk.centre - here_).norm() < 14.0) near->push_back(trunk);
  trunks_ = near;
  // Snapped to voxels, as a rolling map window is.
  const Eigen::Vector3d middle = (here / resolution()).array().round() * resolution();
  bounds_ = {middle - Eigen::Vector3d(7.0, 7.0, 3.0), middle + Eigen::Vector3d(7.0, 7.0, 3.0)};
}

bool SeenForest::hidden(const Eigen::Vector2d& p) const
{
  if ((p - here_).norm() > 6.0) return true;
  return std::any_of(trunks_->begin(), trunks_->end(),
                     [&](const Trunk& trunk)
                     {
                       const bool behind = (trunk.centre - here_).norm() < (p - here_).norm();
                       return behind && rayDistance(here_, p, trunk.centre) < trunk.radius - 0.1 &&
                              (p - trunk.centre).norm() > trunk.radius;
                     });
}

core::Occupancy SeenForest::occupancy(const Eigen::Vector3d& p_L) const
{
  if (!bounds_.contains(p_L) || hidden(p_L.head<2>())) return core::Occupancy::Unknown;
  return sample(p_L, core::UnknownAs::Free)->distance <= 0.0 ? core::Occupancy::Occupied
                                                             : core::Occupancy::Free;
}

std::optional<core::DistanceSample> SeenForest::sample(const Eigen::Vector3d& p_L,
                                                       core::UnknownAs) const
{
  if (!bounds_.contains(p_L)) return std::nullopt;
  core::DistanceSample here;
  here.distance = maxDistance();
  for (const Trunk& trunk : *trunks_)
  {
    if ((trunk.centre - here_).norm() > 6.5) continue;  // not seen yet
    const Eigen::Vector2d away = p_L.head<2>() - trunk.centre;
    const double distance = away.norm() - trunk.radius;
    if (distance >= here.distance) continue;
    here.distance = distance;
    here.gradient.head<2>() = away.normalized();
  }
  return here;
}

std::optional<double> SeenForest::lowerBound(const Eigen::Vector3d& p_L, core::UnknownAs u) const
{
  const auto here = sample(p_L, u);
  return here ? std::optional(here->distance) : std::nullopt;
}

SyntheticFlight::SyntheticFlight(std::uint64_t seed)
    : trunks_(std::make_shared<std::vector<SeenForest::Trunk>>())
{
  core::Rng rng(seed);
  for (const double s : {6.0, 13.5, 21.0})
  {
    blocked_at_.push_back(s);
    trunks_->push_back({referenceAt(s).head<2>() + Eigen::Vector2d(0.0, 0.1), 0.45});
  }
  while (trunks_->size() < 90)
  {
    const Eigen::Vector2d p(rng.uniform(-8.0, 50.0), rng.uniform(-14.0, 14.0));
    double nearest = 1e9;
    for (double s = 0.0; s <= kDuration; s += 0.2)
      nearest = std::min(
          {nearest, (referenceAt(s).head<2>() - p).norm(), (refinedAt(s).head<2>() - p).norm()});
    const double radius = rng.uniform(0.15, 0.5);
    if (nearest > radius + 0.9) trunks_->push_back({p, radius});
  }
}

Eigen::Vector3d SyntheticFlight::referenceAt(double s) const
{
  const double u = std::clamp(s, 0.0, kDuration);
  return {kSpeed * u, 3.0 * std::sin(0.25 * u), 1.5 + 0.3 * std::sin(0.2 * u)};
}

Eigen::Vector3d SyntheticFlight::refinedAt(double s) const
{
  Eigen::Vector3d p = referenceAt(s);
  for (const double blocked : blocked_at_)
    p.y() += 1.35 * std::exp(-std::pow((s - blocked) / 1.1, 2));
  return p;
}

void SyntheticFlight::fillRefinement(core::CycleRecord& record, double s) const
{
  core::RefinementRecord& r = record.refinement;
  r.ran = record.index % 2 == 0;
  r.outcome = "Clear";
  r.min_clearance_m = 0.82;
  r.solve.termination = core::Termination::Converged;
  r.solve.iterations = 23;
  const auto line = [&](double from, double to, auto&& at)
  {
    const int n = 2 + static_cast<int>((to - from) / 0.1);
    core::Polyline points(3, n);
    for (int i = 0; i < n; ++i) points.col(i) = at(from + (to - from) * i / (n - 1));
    return points;
  };
  record.refined = line(s, std::min(s + 5.5, kDuration), [&](double u) { return refinedAt(u); });
  for (const double blocked : blocked_at_)
  {
    if (blocked < s || blocked > s + 4.5) continue;
    r.outcome = "Refined";
    r.occupied_segments.push_back(
        line(blocked - 0.6, blocked + 0.6, [&](double u) { return referenceAt(u); }));
    const auto guide = [&](double u)
    {
      const double bump = 1.5 * std::max(0.0, 1.0 - std::abs(u - blocked) / 1.2);
      return Eigen::Vector3d(referenceAt(u) + Eigen::Vector3d(0.0, bump, 0.0));
    };
    r.guides.push_back(line(blocked - 1.3, blocked + 1.3, guide));
    r.pushing_paths.push_back(line(
        blocked - 1.2, blocked + 1.2,
        [&](double u) { return Eigen::Vector3d(refinedAt(u) + Eigen::Vector3d(0, 0.15, 0)); }));
    for (double u = blocked - 0.6; u <= blocked + 0.61; u += 0.3)
      r.directions.push_back({referenceAt(u), refinedAt(u) + Eigen::Vector3d(0.0, 0.1, 0.0)});
    for (const double side : {-0.8, 0.0, 0.8})
    {
      core::HalfSpaces body;
      body.A.resize(8, 3);
      body.b.resize(8);
      const Eigen::Vector3d centre = refinedAt(blocked + side) + Eigen::Vector3d(0.0, 0.35, 0.0);
      for (int i = 0; i < 6; ++i)
      {
        const double angle = std::numbers::pi * (i + 0.3) / 3.0;
        body.A.row(i) << std::cos(angle), std::sin(angle), 0.0;
        body.b[i] = body.A.row(i).dot(centre) + 0.75 + 0.1 * (i % 3);
      }
      body.A.row(6) << 0.0, 0.0, 1.0;
      body.A.row(7) << 0.0, 0.0, -1.0;
      body.b[6] = centre.z() + 1.0;
      body.b[7] = -centre.z() + 1.0;
      r.polyhedra.push_back(body);
    }
  }
}

void SyntheticFlight::fillHorizon(core::CycleRecord& record, double s) const
{
  record.horizon.resize(3, 16);
  record.horizon_yaw.resize(16);
  for (int i = 0; i < 16; ++i)
  {
    const double share = 1.0 - i / 15.0;  // from where the vehicle is back to the refined reference
    const Eigen::Vector3d error = record.state.p_L - refinedAt(s);
    record.horizon.col(i) = refinedAt(s + 0.1 * i) + share * error;
    record.horizon_yaw[i] = 0.0;
  }
  record.setpoint_L = record.horizon.col(1);
  const Eigen::Vector3d step = record.horizon.col(1) - record.horizon.col(0);
  record.setpoint_yaw = std::atan2(step.y(), step.x());
  record.command.v_W = step / 0.1;
  record.command.yaw_rate = 0.1 * std::sin(s);
  record.nmpc.termination = core::Termination::Converged;
  record.nmpc.iterations = 9;
  record.nmpc.cost = 1.25;
  record.nmpc.primal_residual = 1e-7;
}

core::CycleRecord SyntheticFlight::cycle(int index) const
{
  core::CycleRecord record;
  const double s = 0.1 * index;
  record.index = static_cast<std::uint64_t>(index);
  record.t = s;
  record.progress_s = s;
  record.has_state = true;
  const Eigen::Vector3d wobble(0.06 * std::sin(1.9 * s), 0.08 * std::sin(1.3 * s),
                               0.05 * std::cos(0.9 * s));
  record.state.t = s;
  record.state.p_L = refinedAt(s) + wobble;
  record.state.p_W = record.state.p_L + Eigen::Vector3d(0.3, -0.2, 0.1);
  record.state.v_W = (refinedAt(s + 0.05) - refinedAt(s - 0.05)) / 0.1;
  record.state.q_WB = core::fromYaw(std::atan2(record.state.v_W.y(), record.state.v_W.x()));
  record.origin_offset_norm_m = (record.state.p_W - record.state.p_L).norm();
  if (index >= 3)
    record.field = std::make_shared<SeenForest>(trunks_, record.state.p_L, record.index);
  record.reference.resize(3, 301);
  for (int i = 0; i <= 300; ++i) record.reference.col(i) = referenceAt(0.1 * i);
  record.reference_point_L = referenceAt(s);
  record.refined_point_L = refinedAt(s);
  record.distance_to_goal_m = (referenceAt(kDuration) - record.state.p_L).norm();
  fillRefinement(record, s);
  fillHorizon(record, s);
  record.status = "NAVIGATING";
  const bool braking = index >= 200 && index < 206;
  record.fallback = braking ? "Shifted" : "";
  record.reason =
      braking ? "NMPC hit its iteration limit, previous plan shifted by one stage"
              : "following the refined reference: segment 1 of R is blocked by an obstacle 0.12 m "
                "away, pushed to the left through 3 polyhedra, least clearance 0.82 m";
  record.timing = {2e-4,
                   3e-3 + 1e-3 * std::sin(s),
                   2.5e-3,
                   record.refinement.ran ? 9e-3 : 0.0,
                   4e-3 + 2e-3 * std::abs(std::sin(7.0 * s)),
                   2e-2};
  record.map_sequence = record.index;
  record.reference_sequence = record.index / 2;
  record.decision_hash = 0x9e3779b97f4a7c15ull * (record.index + 1);
  return record;
}

core::TimedPose SyntheticFlight::truth(double t) const
{
  const auto at = [&](double s)
  {
    const Eigen::Vector3d wobble(0.06 * std::sin(1.9 * s), 0.08 * std::sin(1.3 * s),
                                 0.05 * std::cos(0.9 * s));
    return Eigen::Vector3d(refinedAt(s) + wobble + Eigen::Vector3d(0.3, -0.2, 0.1));
  };
  const Eigen::Vector3d drift(0.1 * std::sin(0.2 * t), 0.05, 0.0);
  return {t, at(t) + drift, Eigen::Quaterniond::Identity()};
}

}  // namespace slalom::test
