// SPDX-License-Identifier: BSD-3-Clause
#include "Surroundings.h"

#include <algorithm>
#include <cmath>

namespace slalom::safety::detail
{
namespace
{
using core::UnknownAs;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kComfort = 0.1;  // [m] less room than this is looked up anew
constexpr double kSight = 0.05;   // [m] how far beyond the required clearance exact bounds look

double distanceToSegment(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                         const Eigen::Vector3d& b)
{
  const Eigen::Vector3d along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (a + t * along - p).norm();
}

/// Distance of a segment to an upright one about the origin. Its square is convex along the segment
/// and made of three parabolas: over the axis, beside it, and under it.
double distanceToAxis(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double half_axis)
{
  const Eigen::Vector3d along = b - a;
  const double planar2 = along.head<2>().squaredNorm(), all2 = along.squaredNorm();
  const double beside = -a.head<2>().dot(along.head<2>());
  const auto at = [&](double t)
  {
    const Eigen::Vector3d p = a + std::clamp(t, 0.0, 1.0) * along;
    return std::hypot(p.x(), p.y(), std::max(0.0, std::abs(p.z()) - half_axis));
  };
  double least = std::min(at(0.0), at(1.0));
  if (planar2 > 0.0) least = std::min(least, at(beside / planar2));
  for (const double end : {-half_axis, half_axis})
  {
    if (all2 > 0.0) least = std::min(least, at((beside - (a.z() - end) * along.z()) / all2));
    if (along.z() != 0.0) least = std::min(least, at((end - a.z()) / along.z()));
  }
  return least;
}

bool usable(const core::MovingObstacle& m)
{
  return std::isfinite(m.t) && m.p_L.allFinite() && m.v_L.allFinite() &&
         std::isfinite(m.radius_m) && m.half_axis_m >= 0.0 && std::isfinite(m.half_axis_m) &&
         std::isfinite(m.sigma_p_m) && std::isfinite(m.sigma_v_mps);
}
}  // namespace

Surroundings::Surroundings(const GateInput& input, const SafetyConfig& config,
                           const core::Vehicle& vehicle, const core::DistanceField* field,
                           const Eigen::Vector3d& from_L, double tau)
    : input_(input),
      config_(config),
      field_(field),
      radius_(vehicle.radius_m),
      from_L_(from_L),
      tau_(tau)
{
  if (field_)
  {
    const double here = clearanceAt(from_L, config.unknown);
    layers_[layer_count_++] = {config.unknown, std::min(radius_, here)};
    // Who is excused from keeping clear of unknown space must still keep clear of what is seen.
    if (config.unknown == UnknownAs::Occupied && here < radius_)
      layers_[layer_count_++] = {UnknownAs::Free,
                                 std::min(radius_, clearanceAt(from_L, UnknownAs::Free))};
  }
  const Eigen::Vector3d to_local = input.state.p_L - input.state.p_W;
  fence_L_ = {config.fenceMin() + to_local, config.fenceMax() + to_local};
  fenced_ = (config.fenceMin().array() > -1e6).any() || (config.fenceMax().array() < 1e6).any();
  if (fenced_) fence_required_ = std::min(0.0, fenceSlack(from_L));
  for (const core::MovingObstacle& mover : input.movers)
  {
    if (!usable(mover)) continue;
    const double reach =
        config.mover_horizon_s * (mover.v_L.norm() + std::sqrt(3.0) * vehicle.max_speed_mps);
    const double gap = (mover.nearest(from_L, input.t + tau) - from_L).norm() -
                       moverRadius(mover, tau + config.mover_horizon_s);
    movers_near_ = movers_near_ || !(gap - reach > radius_);
  }
}

double Surroundings::excused() const
{
  double most = 0.0;
  for (int i = 0; i < layer_count_; ++i) most = std::max(most, radius_ - layers_[i].required);
  return most;
}

Eigen::Vector3d Surroundings::away() const
{
  const auto here = field_ ? field_->sample(from_L_, config_.unknown) : std::nullopt;
  return here && here->gradient.allFinite() ? here->gradient.stableNormalized()
                                            : Eigen::Vector3d(Eigen::Vector3d::Zero());
}

/// Below zero inside obstacles and outside the map.
double Surroundings::signedAt(const Eigen::Vector3d& p_L, UnknownAs unknown) const
{
  if (const auto inside = field_->distance(p_L, unknown)) return std::min(0.0, *inside);
  return unknown == UnknownAs::Free ? 0.0 : -field_->bounds().exteriorDistance(p_L);
}

double Surroundings::clearanceAt(const Eigen::Vector3d& p_L, UnknownAs unknown) const
{
  double bound = field_->boundEverywhere(p_L, unknown);
  if (bound < radius_)
    bound = std::max(bound, field_->hullBound(p_L.replicate<1, 4>(), unknown, radius_));
  return bound > 0.0 ? bound : signedAt(p_L, unknown);
}

void Surroundings::look(const Eigen::Vector3d& p_L, Sweep& sweep) const
{
  sweep.anchor = p_L;
  for (int i = 0; i < layer_count_; ++i)
    sweep.anchor_slack[i] =
        layers_[i].required > 0.0
            ? field_->boundEverywhere(p_L, layers_[i].unknown) - layers_[i].required
            : -kInfinity;
}

double Surroundings::room(const Eigen::Vector3d& p_L, const Sweep& sweep) const
{
  if (movers_near_) return -kInfinity;
  double least = kInfinity;
  const double gone = (p_L - sweep.anchor).norm();
  for (int i = 0; i < layer_count_; ++i) least = std::min(least, sweep.anchor_slack[i] - gone);
  if (fenced_) least = std::min(least, fenceSlack(p_L) - fence_required_);
  return least;
}

void Surroundings::pass(const Piece& piece, Sweep& sweep) const
{
  passStanding(piece, sweep);
  passMovers(piece, sweep);
}

double Surroundings::moversUntil() const
{
  return movers_near_ ? tau_ + config_.mover_horizon_s : -kInfinity;
}

void Surroundings::passStanding(const Piece& piece, Sweep& sweep) const
{
  if (!piece.hull.allFinite()) return sweep.lower(-kInfinity, Cause::Map);
  if (field_) passMap(piece, sweep);
  if (fenced_) passFence(piece, sweep);
}

void Surroundings::passMap(const Piece& piece, Sweep& sweep) const
{
  const auto farthest = [&](const Eigen::Vector3d& from)
  { return std::sqrt((piece.hull.colwise() - from).colwise().squaredNorm().maxCoeff()); };
  const double known =
      std::min(sweep.anchor_slack[0], layer_count_ > 1 ? sweep.anchor_slack[1] : kInfinity) -
      farthest(sweep.anchor);
  if (known >= kComfort) return sweep.lower(known, Cause::Map);
  const Eigen::Vector3d centre = 0.5 * (piece.hull.col(0) + piece.hull.col(3));
  const double radius = farthest(centre);
  look(centre, sweep);
  for (int i = 0; i < layer_count_; ++i)
  {
    const double ball = sweep.anchor_slack[i] - radius;
    sweep.lower(ball >= 0.0 ? ball : hullSlack(piece.hull, piece.end, layers_[i], ball),
                Cause::Map);
  }
}

/// @param ball what is known already
double Surroundings::hullSlack(const core::Hull4& hull, const Eigen::Vector3d& end,
                               const Layer& layer, double ball) const
{
  // Inside an obstacle only depth counts, and depth is known at points alone.
  if (layer.required <= 0.0) return signedAt(end, layer.unknown) - layer.required;
  double slack = std::max(
      ball, field_->hullBound(hull, layer.unknown, layer.required + kSight) - layer.required);
  if (slack < 0.0) slack = std::max(slack, chainSlack(hull, layer));
  if (slack + layer.required > 0.0) return slack;
  return std::min(slack, signedAt(end, layer.unknown) - layer.required);
}

/** For fields that enclose hulls in balls: a chain of smaller balls along the chord. Distance to
 * the chord is convex, hence over the hull largest at one of its points. */
double Surroundings::chainSlack(const core::Hull4& hull, const Layer& layer) const
{
  constexpr int kBalls = 6;
  const Eigen::Vector3d a = hull.col(0), b = hull.col(3);
  const double thickness =
      std::max(distanceToSegment(hull.col(1), a, b), distanceToSegment(hull.col(2), a, b));
  const double radius = thickness + 0.5 / kBalls * (b - a).norm();
  double least = kInfinity;
  for (int i = 0; i < kBalls; ++i)
    least =
        std::min(least, field_->boundEverywhere(a + (i + 0.5) / kBalls * (b - a), layer.unknown));
  return least - radius - layer.required;
}

double Surroundings::moverRadius(const core::MovingObstacle& mover, double tau) const
{
  return mover.radius_m + mover.uncertainty(input_.t + tau, config_.mover_sigmas);
}

void Surroundings::passMovers(const Piece& piece, Sweep& sweep) const
{
  if (!(piece.tau <= moversUntil())) return;
  for (const core::MovingObstacle& mover : input_.movers)
  {
    if (!usable(mover)) continue;
    const double start = input_.t + tau_;
    const double now = (from_L_ - mover.nearest(from_L_, start)).norm() - moverRadius(mover, tau_);
    // Seen from the mover the piece is nearly straight; that far it is not.
    const double bend = 0.5 * piece.duration * piece.spread;
    const Eigen::Vector3d centre = mover.at(input_.t + piece.tau);
    const double distance =
        distanceToAxis(piece.hull.col(0) - centre, piece.end - piece.duration * mover.v_L - centre,
                       mover.half_axis_m) -
        bend - moverRadius(mover, piece.tau + piece.duration);
    sweep.mover = std::min(sweep.mover, distance - std::min(radius_, now));
  }
}

void Surroundings::passBeyond(const Eigen::Vector3d& end_L, Sweep& sweep) const
{
  constexpr double kHorizons = 2.0;  // that somebody is taken to walk straight on
  if (!movers_near_) return;
  for (const core::MovingObstacle& mover : input_.movers)
  {
    if (!usable(mover)) continue;
    const Eigen::Vector3d from = end_L - mover.at(input_.t + moversUntil());
    const double distance = distanceToAxis(
        from, from - kHorizons * config_.mover_horizon_s * mover.v_L, mover.half_axis_m);
    sweep.beyond = std::min(sweep.beyond, distance - moverRadius(mover, moversUntil()) - radius_);
  }
}

Eigen::Vector3d Surroundings::aside() const
{
  constexpr double kStill = 1e-3;  // [m/s]
  Eigen::Vector3d best = Eigen::Vector3d::UnitX();
  double soonest = kInfinity;
  for (const core::MovingObstacle& mover : input_.movers)
  {
    if (!usable(mover)) continue;
    const Eigen::Vector3d to = from_L_ - mover.at(input_.t + tau_);
    const Eigen::Vector2d away = to.head<2>().stableNormalized(), v = mover.v_L.head<2>();
    const double when = (to.head<2>().norm() - mover.radius_m) / std::max(away.dot(v), kStill);
    if (!(when < soonest)) continue;
    soonest = when;
    Eigen::Vector2d side = v.norm() > kStill ? Eigen::Vector2d(-v.y(), v.x()).normalized() : away;
    if (side.dot(away) < 0.0) side = -side;
    if (side.norm() > 0.5) best << side, 0.0;
  }
  return best;
}

double Surroundings::fenceSlack(const Eigen::Vector3d& p_L) const
{
  return std::min((p_L - fence_L_.min()).minCoeff(), (fence_L_.max() - p_L).minCoeff());
}

void Surroundings::passFence(const Piece& piece, Sweep& sweep) const
{
  double least = kInfinity;
  for (int i = 0; i < 4; ++i) least = std::min(least, fenceSlack(piece.hull.col(i)));
  sweep.lower(least - fence_required_, Cause::Fence);
}

}  // namespace slalom::safety::detail
