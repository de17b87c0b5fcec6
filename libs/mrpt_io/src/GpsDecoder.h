// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/obs/CObservationGPS.h>

#include <optional>
#include <string>
#include <vector>

#include "Dropped.h"
#include "slalom/core/Measurements.h"
#include "slalom/mrpt_io/Geodesy.h"
#include "slalom/mrpt_io/ObservationDecoder.h"

namespace slalom::mrpt_io::detail
{
/** GGA to PositionFix, RMC beside it to a horizontal VelocityFix. Heights are those above sea level
 * (GGA field "altitude"), because not every receiver tells the geoid's. */
class GpsDecoder
{
 public:
  /// @throws ConfigError for a malformed datum
  explicit GpsDecoder(const InputConfig& config);

  void decode(const mrpt::obs::CObservationGPS& gps, double t, std::vector<core::Measurement>& out,
              Dropped& dropped);
  [[nodiscard]] const std::optional<EnuFrame>& frame() const { return frame_; }

 private:
  double velocity_sigma_;
  std::optional<EnuFrame> frame_;
};

}  // namespace slalom::mrpt_io::detail
