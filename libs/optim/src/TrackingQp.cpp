// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/optim/TrackingQp.h"

#include <stdexcept>
#include <string>

#include "TrackingIpopt.h"
#include "TrackingRiccati.h"

namespace slalom::optim
{
template <int D>
std::unique_ptr<TrackingSolver<D>> makeTrackingSolver(const TrackingSolverConfig& config,
                                                      int stage_count, int rows_per_stage)
{
  if (stage_count < 1)
    throw std::invalid_argument("tracking solver: " + std::to_string(stage_count) +
                                " stages, at least 1 is needed");
  if (rows_per_stage < 0)
    throw std::invalid_argument("tracking solver: " + std::to_string(rows_per_stage) +
                                " rows per stage, at least 0 is needed");
  if (!(config.tolerance > 0.0))
    throw std::invalid_argument("tracking solver: tolerance " + std::to_string(config.tolerance) +
                                " must be > 0");
  if (config.max_iterations < 0)
    throw std::invalid_argument("tracking solver: max_iterations " +
                                std::to_string(config.max_iterations) + " must be >= 0");
  if (config.back_end == TrackingBackEnd::Ipopt)
    return std::make_unique<detail::TrackingIpopt<D>>(config, stage_count, rows_per_stage);
  return std::make_unique<detail::TrackingRiccati<D>>(config, stage_count, rows_per_stage);
}

template std::unique_ptr<TrackingSolver<1>> makeTrackingSolver<1>(const TrackingSolverConfig&, int,
                                                                  int);
template std::unique_ptr<TrackingSolver<3>> makeTrackingSolver<3>(const TrackingSolverConfig&, int,
                                                                  int);

}  // namespace slalom::optim
