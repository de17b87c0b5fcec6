// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservation.h>

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "slalom/simulation/Airframe.h"
#include "slalom/simulation/FlightRecorder.h"
#include "slalom/simulation/FlownPath.h"
#include "slalom/simulation/World.h"

namespace slalom::simulation
{
/// How often the vehicle was how near to what is solid.
class ClearanceHistogram
{
 public:
  static constexpr double kBin = 0.02;  ///< [m]
  static constexpr int kBins = 250;     ///< the last one holds everything beyond

  void add(double clearance);
  /// @param share in [0, 1]; @return [m] upper end of the bin below which that share of the steps
  /// lies, NaN of none
  [[nodiscard]] double quantile(double share) const;
  [[nodiscard]] const std::array<std::uint64_t, kBins>& counts() const { return counts_; }

 private:
  std::array<std::uint64_t, kBins> counts_{};
};

/// What really happened, from the world's geometry and the vehicle's true state at every step.
struct FlightTruth
{
  double t = 0.0;                                           ///< [s] flown
  double length_m = 0.0;                                    ///< [m] flown
  double max_speed_mps = 0.0, max_acceleration_mps2 = 0.0;  ///< norms
  double acceleration_effort = 0.0;                         ///< [m^2/s^3] integral of |a|^2
  double jerk_effort = 0.0;                                 ///< [m^2/s^5] integral of |a'|^2
  Contact nearest{0.0, Eigen::Vector3d::Zero(), std::numeric_limits<double>::infinity()};
  Contact nearest_mover = nearest;  ///< infinite in a world without movers
  std::optional<Contact> first_contact;
  bool hit_mover = false;         ///< the first contact is with a mover
  std::uint64_t contacts = 0;     ///< times that it came into contact
  ClearanceHistogram clearances;  ///< of every step
};

/// Where the vehicle of a simulated flight begins, and how large it is.
struct FlightStart
{
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  ///< [m]
  double yaw = 0.0;                               ///< [rad]
  double radius_m = 0.35;                         ///< [m] of the vehicle
};

/** A flight that reacts: a vehicle in a world obeys commands, and its sensors say what they would
 * say. Deterministic in (world, settings, start, seed, commands). The world must outlive it. */
class SimulatedFlight
{
 public:
  static constexpr double kStep = 5e-3;  ///< [s] of truth and of the path that sensors see

  /// @throws std::invalid_argument if the start is not finite or already in contact, or the
  /// airframe cannot be had
  SimulatedFlight(const World& world, const AirframeConfig& airframe, const SensorSuite& suite,
                  const FlightStart& start, std::uint64_t seed);

  /** Gives the command and flies on for dt (whole steps; a remainder is made up for later).
   *  @return what the sensors delivered in that time, in order of arrival: a lidar scan when its
   * last packet is complete, everything else at its stamp. Commands must be finite. */
  [[nodiscard]] std::vector<mrpt::obs::CObservation::Ptr> advance(
      double dt, const core::VelocityCommand& command);

  [[nodiscard]] double time() const { return until_; }  ///< [s]
  [[nodiscard]] const MotionSample& state() const { return path_.newest(); }
  [[nodiscard]] const FlightTruth& truth() const { return truth_; }

 private:
  void step();
  void judge(const MotionSample& now);

  const World& world_;
  double radius_;
  std::unique_ptr<VehicleModel> vehicle_;
  FlownPath path_;
  FlightRecorder sensors_;
  double until_ = 0.0;
  std::int64_t steps_ = 0;
  bool in_contact_ = false;
  Eigen::Vector3d last_acceleration_ = Eigen::Vector3d::Zero();
  FlightTruth truth_;
};

}  // namespace slalom::simulation
