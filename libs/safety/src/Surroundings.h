// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <limits>

#include "slalom/core/DistanceField.h"
#include "slalom/core/Vehicle.h"
#include "slalom/safety/OutputGate.h"
#include "slalom/safety/SafetyConfig.h"

namespace slalom::safety::detail
{
/// What a way comes nearest to, of what stands.
enum class Cause
{
  Map,
  Fence
};

/// A piece of a way: all of it lies in the hull.
struct Piece
{
  core::Hull4 hull;     ///< [m] local frame; starts at column 0
  Eigen::Vector3d end;  ///< [m] where the piece ends; in the hull
  double tau = 0.0;     ///< [s] from now, when it starts
  double duration = 0.0;
  double spread = 0.0;  ///< [m/s] the velocities in it are this near to each other
};

/// A way that is being looked at, piece by piece.
struct Sweep
{
  double fixed = std::numeric_limits<double>::infinity();  ///< [m] least clearance - required one
  double mover = std::numeric_limits<double>::infinity();  ///< [m] likewise, of what moves
  /// [m] Likewise of the place where the way ends, if what moves walks on after that.
  double beyond = std::numeric_limits<double>::infinity();
  Cause cause = Cause::Map;                          ///< of `fixed`
  Eigen::Vector3d anchor = Eigen::Vector3d::Zero();  ///< [m] the place last looked up
  /// [m] The map's slack there, per layer.
  std::array<double, 2> anchor_slack{-std::numeric_limits<double>::infinity(),
                                     -std::numeric_limits<double>::infinity()};

  void lower(double to, Cause because)
  {
    if (!(to < fixed)) return;  // what is not a number says nothing
    fixed = to;
    cause = because;
  }
};

/** What is around the vehicle, and how near a way may come to it: the vehicle's radius, or where it
 * is already nearer at the start of all ways, as near as it is there. */
class Surroundings
{
 public:
  /// @param from_L where all ways start [m] @param tau when they do, from now [s]
  Surroundings(const GateInput& input, const SafetyConfig& config, const core::Vehicle& vehicle,
               const core::DistanceField* field, const Eigen::Vector3d& from_L, double tau);

  /// Looks up a place, so that room() is known about it.
  void look(const Eigen::Vector3d& p_L, Sweep& sweep) const;

  /// Takes a piece of the way into account.
  void pass(const Piece& piece, Sweep& sweep) const;

  /// The same, of what stands only: when the piece is flown does not matter.
  void passStanding(const Piece& piece, Sweep& sweep) const;
  void passMovers(const Piece& piece, Sweep& sweep) const;

  /// Where the vehicle rests in the end: does something move on over this place?
  void passBeyond(const Eigen::Vector3d& end_L, Sweep& sweep) const;

  /// [s] From now, how far ahead movers are believed; -infinity if none may come near.
  [[nodiscard]] double moversUntil() const;

  /// [m] within this of a place nothing comes nearer than it may, as far as what was looked up
  /// last tells; -infinity where that says nothing.
  [[nodiscard]] double room(const Eigen::Vector3d& p_L, const Sweep& sweep) const;

  /// Where to from the start of all ways, for more clearance; a unit vector, or 0 if not known.
  [[nodiscard]] Eigen::Vector3d away() const;

  /// Something that moves may come near within the horizon.
  [[nodiscard]] bool moversNear() const { return movers_near_; }

  /// Horizontal direction in which to leave the way of the moving obstacle that comes nearest, a
  /// unit vector; what is on that side already is nearer to safety.
  [[nodiscard]] Eigen::Vector3d aside() const;

  /// [m] what may be missing to the radius, 0 unless the vehicle is already nearer.
  [[nodiscard]] double excused() const;

 private:
  /// One treatment of unknown space and what it requires.
  struct Layer
  {
    core::UnknownAs unknown = core::UnknownAs::Free;
    double required = 0.0;  ///< [m]
  };

  [[nodiscard]] double clearanceAt(const Eigen::Vector3d& p_L, core::UnknownAs unknown) const;
  [[nodiscard]] double signedAt(const Eigen::Vector3d& p_L, core::UnknownAs unknown) const;
  [[nodiscard]] double hullSlack(const core::Hull4& hull, const Eigen::Vector3d& end,
                                 const Layer& layer, double ball) const;
  [[nodiscard]] double chainSlack(const core::Hull4& hull, const Layer& layer) const;
  void passMap(const Piece& piece, Sweep& sweep) const;
  void passFence(const Piece& piece, Sweep& sweep) const;
  [[nodiscard]] double moverRadius(const core::MovingObstacle& mover, double tau) const;
  [[nodiscard]] double fenceSlack(const Eigen::Vector3d& p_L) const;

  const GateInput& input_;
  const SafetyConfig& config_;
  const core::DistanceField* field_;
  double radius_;
  std::array<Layer, 2> layers_;
  int layer_count_ = 0;
  Eigen::AlignedBox3d fence_L_;
  bool fenced_ = false;
  double fence_required_ = 0.0;
  bool movers_near_ = false;
  Eigen::Vector3d from_L_;
  double tau_;
};

}  // namespace slalom::safety::detail
