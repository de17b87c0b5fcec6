// SPDX-License-Identifier: BSD-3-Clause
/** The figures of one flight: those of its metrics.json, and those that need its trajectories. */
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "FlightPlan.h"
#include "FlightPool.h"

namespace slalom::experiment
{
/// Names of all figures that there are.
[[nodiscard]] const std::vector<std::string>& figureNames();

/// One flight, flown or not.
struct FlownFlight
{
  PlannedFlight planned;
  bool flown = false;        ///< false: not yet, interrupted or crashed
  std::string result = "-";  ///< GOAL_REACHED, ...
  std::string message;
  std::map<std::string, double> figures;  ///< what is not known is absent

  [[nodiscard]] std::optional<double> figure(const std::string& name) const;
};

/** Reads the output folder of a finished flight.
 *  @param expected results that are as they should be, without contact: figure `expected`
 *  @param shortest [m] of the world, if known from elsewhere; else of metrics.json
 *  @throws std::runtime_error naming the file that is damaged */
[[nodiscard]] FlownFlight readFlight(const PlannedFlight& planned, const FlightRecord& record,
                                     const std::vector<std::string>& expected,
                                     std::optional<double> shortest);

/// A trajectory as TUM rows hold it.
struct Path
{
  std::vector<double> t;                ///< [s] rising
  std::vector<Eigen::Vector3d> points;  ///< [m]
};
[[nodiscard]] Path readPath(const std::filesystem::path& tum);

/** Distances [m] of the samples of `path` to the line through `reference`, for samples within the
 * reference's time. Only what the reference passed within `window_s` of the sample's time counts:
 * the other branch of a crossing is no excuse. */
[[nodiscard]] std::vector<double> distancesToLine(const Path& path, const Path& reference,
                                                  double window_s);

/// Distances [m] to where `targets` are at their own time, `path` interpolated.
[[nodiscard]] std::vector<double> distancesInTime(const Path& path, const Path& targets);

/// Mean, 95th percentile and largest; nullopt of no samples.
struct ErrorFigures
{
  double mean = 0.0, p95 = 0.0, max = 0.0;
};
[[nodiscard]] std::optional<ErrorFigures> errorFigures(std::vector<double> samples);

}  // namespace slalom::experiment
