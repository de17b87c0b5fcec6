// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservation.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "slalom/simulation/FlightRecorder.h"
#include "slalom/simulation/FlownPath.h"
#include "slalom/simulation/SimulatedVehicle.h"
#include "slalom/simulation/World.h"

namespace slalom::simulation
{
/// What really happened, from the world's geometry and the vehicle's true state at every step.
struct FlightTruth
{
  double t = 0.0;                                           ///< [s] flown
  double length_m = 0.0;                                    ///< [m] flown
  double max_speed_mps = 0.0, max_acceleration_mps2 = 0.0;  ///< norms
  Contact nearest{0.0, Eigen::Vector3d::Zero(), std::numeric_limits<double>::infinity()};
  std::optional<Contact> first_contact;
  std::uint64_t contacts = 0;  ///< times that it came into contact
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

  /// @throws std::invalid_argument if the start is not finite or already in contact
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
  SimulatedVehicle vehicle_;
  FlownPath path_;
  FlightRecorder sensors_;
  double until_ = 0.0;
  std::int64_t steps_ = 0;
  bool in_contact_ = false;
  FlightTruth truth_;
};

}  // namespace slalom::simulation
