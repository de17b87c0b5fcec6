// SPDX-License-Identifier: BSD-3-Clause
/** The vehicle models, at their defaults, against real multirotors: told what those were told, do
 * they fly what those flew? A vehicle that flies its commands at once is the baseline. */
#include <gtest/gtest.h>

#include <iostream>
#include <limits>

#include "SharedData.h"
#include "VelocityRecording.h"

namespace slalom::simulation
{
namespace
{
using test::compare;
using test::Fit;
using test::readVelocities;
using test::VelocityRecording;

constexpr double kSettle = 2.0;  // [s]
constexpr double kEndless = std::numeric_limits<double>::infinity();

AirframeConfig modelled(AirframeModel model)
{
  AirframeConfig config;
  config.model = model;
  return config;
}

/// The default models are nearer to the flight than the baseline by this factor at least.
void expectNearer(const VelocityRecording& recording, double factor, double until = kEndless)
{
  ASSERT_GT(recording.told.size(), 100u);
  for (const AirframeModel model : {AirframeModel::Lag, AirframeModel::Quadrotor})
  {
    const Fit fit = compare(recording, modelled(model), kSettle, until);
    std::cout << (model == AirframeModel::Lag ? "lag" : "quadrotor") << ": " << fit.model
              << " m/s rms, unity gain " << fit.unity << " m/s rms, " << fit.samples
              << " samples\n";
    ASSERT_GT(fit.samples, 100);
    EXPECT_LT(fit.model, factor * fit.unity);
  }
}

TEST(Identification, OctocopterUnderPid)
{
  const auto folder = test::sharedData("real/acsl_x8_tracking");
  if (!exists(folder)) GTEST_SKIP() << folder;
  for (const auto& [name, factor] :
       {std::pair("20240613_115633.csv", 0.6), std::pair("20240613_121802.csv", 0.8)})
  {
    SCOPED_TRACE(name);
    constexpr std::size_t kReference = 4, kMeasured = 19;
    expectNearer(
        {readVelocities(folder / name, kReference), readVelocities(folder / name, kMeasured)},
        factor);
  }
}

TEST(Identification, AutopilotOnAMission)
{
  const auto folder = test::sharedData("real/px4_outdoor_mission_motorfail");
  if (!exists(folder)) GTEST_SKIP() << folder;
  VelocityRecording recording;
  recording.told = readVelocities(folder / "setpoint.csv", 4);
  recording.flown = readVelocities(folder / "autopilot_estimate.csv", 4);
  // A motor fails at the end.
  expectNearer(recording, 0.8, recording.told.front().t + 30.0);
}
}  // namespace
}  // namespace slalom::simulation
