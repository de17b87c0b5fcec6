// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slalom/core/Measurements.h"
#include "slalom/core/VehicleState.h"
#include "slalom/mrpt_io/ObservationDecoder.h"
#include "slalom/navigator/Navigator.h"

namespace slalom::navigator
{
/** What the engine gets to know, and when "now" is.
 *
 *  A host that delivers raw observations is heard through the decoder, and log time is that of the
 * stamps; another host is asked for its pose and obstacle points in every step, and log time is its
 * navigation time. */
class HostSenses
{
 public:
  using Sink = std::function<void(const core::Measurement&)>;

  /// Asks the host which kind it is; what it has already sensed is kept for the first pull().
  HostSenses(RobotInterface3D& robot, const mrpt_io::InputConfig& config, bool fly_by_truth);

  /// Hands everything new to `sink`. @param navigation_time of the host [s]
  void pull(double navigation_time, const Sink& sink);

  [[nodiscard]] bool delivers() const { return delivers_; }  ///< raw observations
  /// The present in log time [s]; empty before the first observation.
  [[nodiscard]] std::optional<double> now() const { return now_; }
  [[nodiscard]] mrpt::Clock::time_point stamp(double log_time) const;
  /// Without observations: what the host last said of its state; empty: it could not tell.
  [[nodiscard]] const std::optional<State3D>& hostState() const { return host_state_; }
  /// Ground truth since the last call.
  [[nodiscard]] std::vector<core::TimedPose> takeTruth();

  [[nodiscard]] const mrpt_io::ObservationDecoder& decoder() const { return decoder_; }
  [[nodiscard]] std::map<std::string, std::uint64_t> dropped() const;
  /// Points of every range scan so far, in order.
  [[nodiscard]] const std::vector<std::uint32_t>& pointsPerScan() const { return points_per_scan_; }

 private:
  void pullObservations(const Sink& sink);
  void take(const mrpt::obs::CObservation& observation, const Sink& sink);
  void advanceClock();
  [[nodiscard]] double ageOf(const mrpt::Clock::time_point& stamp) const;
  void askForState(double t, const Sink& sink);
  void askForObstacles(double t, const Sink& sink);

  RobotInterface3D& robot_;
  mrpt_io::ObservationDecoder decoder_;
  bool fly_by_truth_;
  bool delivers_ = false;
  std::vector<std::shared_ptr<mrpt::obs::CObservation>> waiting_;
  std::vector<core::TimedPose> truth_;
  std::optional<State3D> host_state_;
  std::optional<double> now_, newest_;
  bool heard_ = false;            // something new in this pull
  double host_when_heard_ = 0.0;  // log time by the host's clock
  mrpt::Clock::time_point last_state_;
  bool clock_agrees_ = false;  // the host's clock and the stamps are of one time base
  mrpt::system::TTimeStamp last_obstacles_ = INVALID_TIMESTAMP;
  std::uint64_t undecodable_ = 0;
  std::vector<std::uint32_t> points_per_scan_;
};

}  // namespace slalom::navigator
