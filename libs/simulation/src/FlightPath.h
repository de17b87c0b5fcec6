// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slalom/simulation/ScriptedFlight.h"

namespace slalom::simulation
{
/// Position and heading over time; time 0 is the start of the recording.
struct ScriptedFlight::Path
{
  struct Sample
  {
    Eigen::Vector3d p, v, a;
    double yaw;
  };
  virtual ~Path() = default;
  [[nodiscard]] virtual Sample at(double t) const = 0;
  [[nodiscard]] virtual double duration() const = 0;
};

}  // namespace slalom::simulation
