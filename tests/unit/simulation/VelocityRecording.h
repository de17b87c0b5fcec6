// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "slalom/core/TextTable.h"
#include "slalom/simulation/Airframe.h"

namespace slalom::test
{
/// What a real vehicle was told and what it did: velocities in ENU at times.
struct VelocityRecording
{
  struct Row
  {
    double t;
    Eigen::Vector3d v;
  };
  std::vector<Row> told, flown;
};

/// Times and velocities (north, east, down in three columns from `first` on) of a csv; rows with a
/// nan are left out.
[[nodiscard]] inline std::vector<VelocityRecording::Row> readVelocities(
    const std::filesystem::path& file, std::size_t first)
{
  std::vector<VelocityRecording::Row> result;
  const auto rows = core::readRows(file, ',');
  for (std::size_t k = 1; k < rows.size(); ++k)
  {
    const auto& fields = rows[k].fields;
    if (fields[first] == "nan" || fields[first + 1] == "nan" || fields[first + 2] == "nan")
      continue;
    const auto number = [&](std::size_t f) { return core::numberAt(file, rows[k], f); };
    result.push_back({number(0), {number(first + 1), number(first), -number(first + 2)}});
  }
  return result;
}

/// Root mean square of the velocity error [m/s].
struct Fit
{
  double model = 0.0;  ///< of the vehicle model, told what the real one was told
  double unity = 0.0;  ///< of a vehicle that flies what it is told
  int samples = 0;
};

/** @param settle [s] from the start that are not compared
 *  @param until [s] of the recording's clock */
[[nodiscard]] inline Fit compare(const VelocityRecording& recording,
                                 const simulation::AirframeConfig& config, double settle,
                                 double until)
{
  const double start = recording.told.front().t;
  const auto vehicle = simulation::makeVehicle(config, Eigen::Vector3d::Zero(), 0.0, 1);
  Fit fit;
  std::size_t next = 0;
  Eigen::Vector3d told = Eigen::Vector3d::Zero();
  for (const auto& row : recording.flown)
  {
    if (row.t < start || row.t > until) continue;
    for (; next < recording.told.size() && recording.told[next].t <= row.t; ++next)
    {
      vehicle->advance(recording.told[next].t - start - vehicle->time());
      told = recording.told[next].v;
      vehicle->command({told, 0.0});
    }
    vehicle->advance(row.t - start - vehicle->time());
    if (row.t < start + settle) continue;
    fit.model += (vehicle->sample().v_W - row.v).squaredNorm();
    fit.unity += (told - row.v).squaredNorm();
    ++fit.samples;
  }
  fit.model = std::sqrt(fit.model / fit.samples);
  fit.unity = std::sqrt(fit.unity / fit.samples);
  return fit;
}

}  // namespace slalom::test
