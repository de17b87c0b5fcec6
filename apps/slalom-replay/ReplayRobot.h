// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "ObservationRobot.h"

namespace slalom::replay
{
/// The vehicle of a recording: it senses what was recorded and flies what was flown, whatever it is
/// told.
class ReplayRobot final : public app::ObservationRobot
{
 public:
  bool changeSpeeds3D(const navigator::VelocityCommand3D&) override { return true; }
  bool stop3D(bool) override { return true; }
};

}  // namespace slalom::replay
