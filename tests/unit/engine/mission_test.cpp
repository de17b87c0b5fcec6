// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <limits>

#include "slalom/core/Rng.h"
#include "slalom/engine/Engine.h"

namespace slalom::engine
{
namespace
{
EngineConfig truthConfig()
{
  EngineConfig config;
  config.state.source = StateSourceKind::Truth;
  return config;
}

Mission legTo(double x)
{
  Mission mission;
  mission.waypoints_W.resize(3, 2);
  mission.waypoints_W << 0.0, x, 0.0, 0.0, 1.5, 1.5;
  return mission;
}

/// What check() says; empty: nothing.
std::string refusal(const Mission& mission, const EngineConfig& config)
{
  try
  {
    check(mission, config);
    return {};
  }
  catch (const std::invalid_argument& error)
  {
    return error.what();
  }
}

void expectWords(const std::string& text, std::initializer_list<const char*> words)
{
  for (const char* word : words)
    EXPECT_NE(text.find(word), std::string::npos) << "no " << word << " in: " << text;
}

/// A vehicle that stands still until its state has been known for a while, with a cycle every 50
/// ms.
core::CycleRecord stand(Engine& engine)
{
  core::PoseFix fix;
  fix.T_WB.setIdentity();
  core::CycleRecord cycle;
  for (int k = 0; k <= 250; ++k)
  {
    fix.t = 0.01 * k;
    engine.add(fix);
    if (k % 5 == 0) cycle = engine.step(fix.t);
  }
  return cycle;
}

double peakMegabytes()
{
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

/// Peak of what the first cycles with a mission of this length take [MB].
double memoryOf(double length_m)
{
  Engine engine(truthConfig());
  const double before = peakMegabytes();
  engine.setMission(legTo(length_m));
  (void)stand(engine);
  if (std::abs(engine.referenceLength() - length_m) > 2.0) std::exit(2);  // it flew the leg
  return peakMegabytes() - before;
}

TEST(Mission, TenKilometresTakeAFewMegabytes)
{
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "measures the sanitizer";
#endif
  // In a process of its own, whose peak nothing else has raised before.
  const auto within = [](double limit_mb)
  {
    const double taken = memoryOf(10000.0);
    std::fprintf(stderr, "%.1f MB", taken);
    std::exit(taken <= limit_mb ? 0 : 1);
  };
  EXPECT_EXIT(within(16.0), testing::ExitedWithCode(0), "");
}

TEST(Mission, IsRefusedBeyondItsBoundsWhichTheMessageNames)
{
  EngineConfig config;
  EXPECT_EQ(refusal(legTo(config.mission.max_length_m), config), "");
  expectWords(refusal(legTo(config.mission.max_length_m + 1.0), config),
              {"20001", "mission.max_length_m = 20000"});
  config.mission.max_length_m = 1e6;
  for (const double x : {1e7, 1e30, -1e300, std::nan(""), std::numeric_limits<double>::infinity()})
    expectWords(refusal(legTo(x), config), {"waypoint", "1000000"});
  config.vehicle.max_speed_mps = 0.05;
  expectWords(refusal(legTo(9e5), config),
              {"900000", "max_speed_mps", "knot_span_s = 0.2", "1000000"});
  expectWords(refusal({}, config), {"at least one"});
  expectWords(refusal({Eigen::Matrix3Xd::Zero(3, 10001)}, config), {"10001", "10000"});
}

/// Whatever a host hands over, the engine either says what is wrong or answers every cycle.
TEST(Mission, OfAnyKindIsRefusedOrAnswered)
{
  for (std::uint64_t seed = 1; seed <= 30; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    Mission mission;
    mission.waypoints_W.resize(3, 1 + static_cast<Eigen::Index>(rng.uniform(0.0, 4.0)));
    for (auto& value : mission.waypoints_W.reshaped())
      value = rng.normal() * std::pow(10.0, rng.uniform(-3.0, 5.0));
    Engine engine(truthConfig());
    try
    {
      engine.setMission(mission);
    }
    catch (const std::invalid_argument&)
    {
      continue;
    }
    const core::CycleRecord cycle = stand(engine);
    // Refused only from where the vehicle is: no mission, with the reason in the first cycle.
    EXPECT_NE(engine.status(), EngineStatus::WaitingForState) << cycle.reason;
    EXPECT_EQ(engine.status() == EngineStatus::NoMission, engine.referenceLength() == 0.0);
    EXPECT_TRUE(cycle.command.v_W.allFinite());
    EXPECT_LE(engine.referenceLength(), 1.5 * EngineConfig{}.mission.max_length_m);
  }
}

}  // namespace
}  // namespace slalom::engine
