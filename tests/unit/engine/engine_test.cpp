// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <stdexcept>

#include "Pipeline.h"
#include "ReferenceClock.h"
#include "ScanAssembler.h"
#include "StateSource.h"
#include "slalom/core/Rng.h"
#include "slalom/mrpt_io/ConfigBinder.h"
#include "slalom/spline/WaypointFit.h"

namespace slalom::engine
{
namespace
{
spline::UniformBSpline straight()
{
  Eigen::Matrix3Xd ends(3, 2);
  ends << 0, 20, 0, 0, 1, 1;
  return spline::fitWaypoints(ends, {1.0, 1.0, 0.2});
}

spline::TimeLaw law(const spline::UniformBSpline& r, double to)
{
  return {r, r.start(), to, 1.0, {1.1, 1.1}};
}

TEST(ReferenceClock, RunsWithTimeWhenTheVehicleKeepsUp)
{
  const spline::UniformBSpline r = straight();
  ReferenceClock clock(0.6);
  clock.restart(0.0);
  for (int k = 0; k < 100; ++k)
    clock.advance(0.05, r, law(r, r.end()), r.position(clock.progress()));
  EXPECT_NEAR(clock.progress(), 5.0, 1e-6);
}

TEST(ReferenceClock, WaitsForABlockedVehicleAndResumesWithoutAJump)
{
  const spline::UniformBSpline r = straight();
  ReferenceClock clock(0.6);
  clock.restart(5.0);
  const Eigen::Vector3d held = r.position(5.0);
  for (int k = 0; k < 100; ++k) clock.advance(0.05, r, law(r, r.end()), held);
  EXPECT_LE(clock.progress(), 5.0 + 0.6 + 1e-3);
  const double before = clock.progress();
  clock.advance(0.05, r, law(r, r.end()), held);
  EXPECT_LE(std::abs(clock.progress() - before), 0.05 + 1e-9);
}

TEST(ReferenceClock, NeverRunsBackwardsNorPastTheStop)
{
  const spline::UniformBSpline r = straight();
  core::Rng rng(1);
  ReferenceClock clock(0.6);
  clock.restart(0.0);
  double last = 0.0;
  for (int k = 0; k < 500; ++k)
  {
    clock.advance(0.05, r, law(r, 12.0), r.position(last) + rng.normal3(0.3));
    EXPECT_GE(clock.progress(), last);
    EXPECT_LE(clock.progress(), 12.0);
    last = clock.progress();
  }
}

TEST(ReferenceClock, AHookInThePlanDoesNotHoldIt)
{
  // Out along x, round a narrow bend and back: a vehicle that cut the bend is nearer to the way
  // out.
  for (const double aside : {0.0, 0.1, 0.2, 0.3})
  {
    SCOPED_TRACE(aside);
    Eigen::Matrix3Xd points(3, 40);
    for (int i = 0; i < 40; ++i)
      points.col(i) << (i < 20 ? 0.1 * i : 0.1 * (39 - i)), i < 20 ? 0.0 : 0.35, 1.0;
    const spline::UniformBSpline curve(points, 0.2);
    ReferenceClock clock(0.6);
    clock.restart(4.4);
    const Eigen::Vector3d standing = curve.position(4.4) - Eigen::Vector3d(0.0, aside, 0.0);
    for (int k = 0; k < 12; ++k) clock.advance(0.05, curve, law(curve, curve.end()), standing);
    EXPECT_GT(clock.progress(), 4.9);
  }
}

TEST(ReferenceClock, DoesNotJumpToALegThatPassesNearby)
{
  // Out along x, and back half a metre beside it.
  Eigen::Matrix3Xd points(3, 24);
  for (int i = 0; i < 24; ++i)
    points.col(i) << 0.2 * (i < 12 ? i : 23 - i), i < 12 ? 0.0 : 0.5, 1.0;
  const spline::UniformBSpline curve(points, 0.2);
  ReferenceClock clock(0.6), free(0.6, true);
  for (ReferenceClock* each : {&clock, &free})
  {
    each->restart(1.4);
    each->advance(0.05, curve, law(curve, curve.end()), {1.4, 0.45, 1.0});
  }
  EXPECT_LT(clock.progress(), 1.7);
  EXPECT_GT(free.progress(), 2.0) << "nobody steers, the vehicle is where it is";
}

TEST(Worker, DropsTheOldestWhenItIsLate)
{
  std::atomic<int> seen{0};
  std::atomic<bool> go{false};
  Worker<int> worker(2,
                     [&](int job)
                     {
                       while (!go) std::this_thread::yield();
                       seen += job;
                     });
  std::size_t dropped = 0;
  for (const int job : {1, 10, 100, 1000}) dropped += worker.submit(job);
  go = true;
  worker.drain();
  EXPECT_GE(dropped, 1u);
  EXPECT_GE(seen.load(), 1100) << "the newest two are always worked on";
}

/// A scan from the origin, all of whose returns lie around `end`.
MapJob lookAt(double t, const Eigen::Vector3f& end, std::uint64_t frame)
{
  MapJob job;
  job.t = t;
  job.frame = frame;
  for (int i = -2; i <= 2; ++i)
    job.rays.push_back(
        {Eigen::Vector3f::Zero(), end + Eigen::Vector3f(0.0f, 0.0f, 0.05f * float(i))});
  return job;
}

TEST(Pipeline, ALostScanDoesNotSaveTheMapOfAnOldFrame)
{
  const Eigen::Vector3d old_wall(3.0, 0.0, 0.0), new_wall(0.0, 3.0, 0.0);
  for (const bool threaded : {false, true})
  {
    SCOPED_TRACE(threaded);
    EngineConfig config;
    config.rates.threaded = threaded;
    std::atomic<bool> fails{false};
    const StepHooks hooks{[&fails]
                          {
                            if (fails) throw std::runtime_error("out of memory");
                          },
                          {},
                          {}};
    Pipeline pipeline(config, hooks);
    pipeline.map(lookAt(0.0, old_wall.cast<float>(), 0));
    pipeline.drain();
    ASSERT_EQ(pipeline.latestMap()->field->occupancy(old_wall), core::Occupancy::Occupied);
    fails = true;
    pipeline.map(lookAt(0.1, new_wall.cast<float>(), 1));
    pipeline.drain();
    EXPECT_EQ(pipeline.latestMap()->frame, 0u) << "the old map does not pass for a new one";
    fails = false;
    pipeline.map(lookAt(0.2, new_wall.cast<float>(), 1));
    pipeline.drain();
    EXPECT_EQ(pipeline.latestMap()->frame, 1u);
    EXPECT_EQ(pipeline.latestMap()->field->occupancy(new_wall), core::Occupancy::Occupied);
    EXPECT_EQ(pipeline.latestMap()->field->occupancy(old_wall), core::Occupancy::Unknown);
  }
}

core::PositionFix fixAt(double t)
{
  core::PositionFix fix;
  fix.t = t;
  return fix;
}

TEST(StateSource, AutoPrefersFusionOverPoses)
{
  StateSource source({}, {});
  core::PoseFix pose;
  source.add(pose);
  EXPECT_EQ(source.kind(), StateSourceKind::Auto);
  source.add(fixAt(0.3));
  EXPECT_EQ(source.kind(), StateSourceKind::Fusion);
}

TEST(StateSource, AutoFollowsPosesWhenThereIsNothingElse)
{
  StateSource source({}, {});
  for (int k = 0; k < 40; ++k)
  {
    core::PoseFix pose;
    pose.t = 0.05 * k;
    pose.T_WB.translation() = Eigen::Vector3d(5.0 + 0.05 * k, 2.0, 1.0);
    source.add(pose);
  }
  ASSERT_EQ(source.kind(), StateSourceKind::PoseObservation);
  const auto state = source.state(1.95);
  ASSERT_TRUE(state);
  EXPECT_NEAR(state->p_W.x(), 6.95, 0.1);
  EXPECT_NEAR((state->p_L - state->p_W).norm(), 0.0, 0.2) << "the local frame begins as the world";
}

TEST(StateSource, AutoStandsStillWithoutAnySource)
{
  StateConfig config;
  config.wait_s = 1.0;
  StateSource source(config, {});
  core::RangeScan scan;
  source.add(scan);
  scan.t = 1.5;
  source.add(scan);
  EXPECT_EQ(source.kind(), StateSourceKind::Static);
  ASSERT_TRUE(source.state(2.0));
  EXPECT_EQ(source.state(2.0)->p_L.norm(), 0.0);
}

TEST(ScanAssembler, UndoesTheMotionDuringAScan)
{
  // A vehicle at 2 m/s looks at one point for 0.1 s: compensated, all returns are that point.
  StateConfig config;
  config.source = StateSourceKind::Truth;
  StateSource source(config, {});
  const Eigen::Vector3d velocity(2.0, 0.0, 0.0), target(6.0, 1.0, 0.5);
  for (int k = 0; k <= 160; ++k)
  {
    core::PoseFix pose;
    pose.t = 0.01 * k;
    pose.T_WB.translation() = velocity * pose.t;
    source.add(pose);
  }
  core::RangeScan scan;
  scan.t = 1.4;
  scan.duration = 0.1;
  scan.T_BS.translation() = Eigen::Vector3d(0.1, 0.0, 0.05);
  for (int k = 0; k <= 10; ++k)
  {
    const double dt = 0.01 * k;
    const Eigen::Vector3d p_S = target - velocity * (scan.t + dt) - scan.T_BS.translation();
    scan.points.push_back({p_S.cast<float>(), float(dt)});
  }
  ScanAssembler assembler{mapping::MapperConfig{}};
  assembler.add(scan);
  std::map<std::string, std::uint64_t> dropped;
  const std::vector<MapJob> jobs = assembler.take(source, 1.6, dropped);
  ASSERT_EQ(jobs.size(), 1u);
  for (const core::Ray& ray : jobs[0].rays)
    EXPECT_LT((ray.end_L.cast<double>() - target).norm(), 0.03);
}

TEST(ScanAssembler, TakesSilenceForFreeSpaceUnlessTheSensorIsCovered)
{
  StateConfig config;
  config.source = StateSourceKind::Truth;
  StateSource source(config, {});
  for (int k = 0; k < 200; ++k)
  {
    core::PoseFix pose;
    pose.t = 0.01 * k;
    source.add(pose);
  }
  const auto raysOf = [&source](std::size_t echoes, mapping::NoReturn no_return)
  {
    mapping::MapperConfig mapping;
    mapping.no_return = no_return;
    core::RangeScan scan;
    scan.t = 1.0;
    scan.points.assign(echoes, {Eigen::Vector3f(3.0f, 0.0f, 0.0f), 0.0f});
    scan.silent.assign(1000, {Eigen::Vector3f::UnitY(), 0.0f});
    ScanAssembler assembler(mapping);
    assembler.add(scan);
    std::map<std::string, std::uint64_t> dropped;
    return assembler.take(source, 1.5, dropped).at(0);
  };
  const MapJob open = raysOf(100, mapping::NoReturn::Free);
  ASSERT_EQ(open.rays.size(), 1100u);
  EXPECT_EQ(open.silent, 1000u);
  const double reach = mapping::MapperConfig{}.update_range_m;
  EXPECT_NEAR(open.rays.back().end_L.y(), reach, 1e-5);
  EXPECT_NEAR(open.rays.back().origin_L.y(), 1.0, 1e-5) << "an obstacle too near gives no echo";
  EXPECT_EQ(raysOf(10, mapping::NoReturn::Free).rays.size(), 10u) << "covered";
  EXPECT_EQ(raysOf(100, mapping::NoReturn::Unknown).rays.size(), 100u);
}

TEST(ScanAssembler, WaitsForTheEstimateAndDropsWhatNeverGetsOne)
{
  StateConfig config;
  config.source = StateSourceKind::Truth;
  StateSource source(config, {});
  ScanAssembler assembler{mapping::MapperConfig{}};
  core::RangeScan scan;
  scan.t = 1.0;
  scan.duration = 0.1;
  assembler.add(scan);
  std::map<std::string, std::uint64_t> dropped;
  EXPECT_TRUE(assembler.take(source, 1.2, dropped).empty());
  EXPECT_TRUE(dropped.empty()) << "still waiting";
  EXPECT_TRUE(assembler.take(source, 2.0, dropped).empty());
  EXPECT_EQ(dropped["scan without pose"], 1u);
}

TEST(EngineConfig, EveryRuleBetweenFieldsNamesBothValues)
{
  const auto complaint = [](auto&& change)
  {
    EngineConfig config;
    change(config);
    try
    {
      check(config);
    }
    catch (const mrpt_io::ConfigError& error)
    {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(complaint([](EngineConfig&) {}), "");
  EXPECT_NE(complaint([](EngineConfig& c) { c.mapping.window_xy_m = 8; }).find("update_range_m"),
            std::string::npos);
  EXPECT_NE(complaint([](EngineConfig& c) { c.vehicle.radius_m = 0.9; }).find("clearance_m"),
            std::string::npos);
  EXPECT_NE(
      complaint([](EngineConfig& c) { c.mapping.max_distance_m = 0.5; }).find("max_distance_m"),
      std::string::npos);
  EXPECT_NE(complaint([](EngineConfig& c) { c.global_planner.horizon_m = 30; }).find("horizon_m"),
            std::string::npos);
  EXPECT_NE(complaint([](EngineConfig& c) { c.local_planner.step_s = 0.5; }).find("step_s"),
            std::string::npos);
  EXPECT_NE(complaint([](EngineConfig& c) { c.safety.fence_max_y_m = -2e6; }).find("fence_max"),
            std::string::npos);
  EXPECT_NE(
      complaint([](EngineConfig& c) { c.rates.global_period_s = 3.0; }).find("plan_timeout_s"),
      std::string::npos);
  EXPECT_NE(complaint([](EngineConfig& c) { c.tracking.range_m = 0.1; }).find("min_range_m"),
            std::string::npos);
}

TEST(Configuration, EveryShippedFileLoads)
{
  int files = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(SLALOM_SOURCE_DIR "/configs"))
  {
    if (entry.path().extension() != ".ini") continue;
    SCOPED_TRACE(entry.path());
    const auto document = mrpt_io::IniDocument::read(entry.path());
    // Experiments and worlds have readers, and tests, of their own.
    const auto sections = document.sections();
    if (std::ranges::any_of(sections,
                            [](const auto& s) { return s == "experiment" || s == "world"; }))
      continue;
    mrpt_io::ConfigBinder binder(document);
    EngineConfig config;
    bind(binder, config);
    for (const char* other : {"input", "report", "replay", "fly", "airframe", "lidar", "gps"})
      binder.ignore(other);
    binder.finish();
    check(config);
    ++files;
  }
  EXPECT_GE(files, 3);
}

}  // namespace
}  // namespace slalom::engine
