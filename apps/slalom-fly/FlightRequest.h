// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "FlySettings.h"
#include "Options.h"
#include "slalom/engine/Mission.h"
#include "slalom/simulation/World.h"

namespace slalom::fly
{
/// The command line and the configuration, understood and checked.
struct FlightRequest
{
  app::FlySettings settings;
  simulation::World world;
  engine::Mission mission;
  simulation::FlightStart start;  ///< heading towards the first waypoint

  [[nodiscard]] Eigen::Vector3d goal() const { return mission.waypoints_W.rightCols<1>(); }
};

/// @throws app::UsageError, mrpt_io::ConfigError, app::InputError
[[nodiscard]] FlightRequest readRequest(const Options& options);

}  // namespace slalom::fly
