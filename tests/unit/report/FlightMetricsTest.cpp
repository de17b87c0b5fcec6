// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "AnalyticField.h"
#include "FlightLog.h"
#include "MetricsJson.h"
#include "slalom/core/Rng.h"
#include "slalom/report/FlightMetrics.h"

namespace slalom::report
{
namespace
{
TEST(Quantile, AgreesWithHandComputation)
{
  // Rank q (n-1): for n = 4 the quarter points are at ranks 0.75, 1.5, 2.25.
  EXPECT_DOUBLE_EQ(*quantile({4, 1, 3, 2}, 0.25), 1.75);
  EXPECT_DOUBLE_EQ(*quantile({4, 1, 3, 2}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(*quantile({4, 1, 3, 2}, 0.95), 3.85);
  EXPECT_DOUBLE_EQ(*quantile({7}, 0.99), 7.0);
  EXPECT_FALSE(quantile({}, 0.5));
}

TEST(Quantile, ShareOfSamplesBelowItIsTheOneAskedFor)
{
  for (std::uint64_t seed = 0; seed < 30; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    std::vector<double> samples(static_cast<std::size_t>(rng.integer(1, 400)));
    for (double& x : samples) x = rng.normal();
    double last = -1e9;
    for (const double q : {0.0, 0.1, 0.5, 0.95, 0.99, 1.0})
    {
      const double value = *quantile(samples, q);
      const auto below =
          std::count_if(samples.begin(), samples.end(), [&](double x) { return x <= value; });
      const double n = static_cast<double>(samples.size());
      EXPECT_GE(static_cast<double>(below) + 1e-9, q * (n - 1.0));
      EXPECT_LE(static_cast<double>(below), q * (n - 1.0) + 1.0 + 1e-9);
      EXPECT_GE(value, last);
      last = value;
    }
  }
}

TEST(Describe, LeavesOutWhatIsNotFinite)
{
  const Distribution d = describe({1.0, std::nan(""), 3.0, INFINITY, 8.0});
  EXPECT_EQ(d.n, 3u);
  EXPECT_DOUBLE_EQ(*d.mean, 4.0);
  EXPECT_DOUBLE_EQ(*d.median, 3.0);
  EXPECT_DOUBLE_EQ(*d.p95, 3.0 + 0.9 * 5.0);
  EXPECT_DOUBLE_EQ(*d.max, 8.0);
  EXPECT_FALSE(describe({std::nan("")}).mean);
}

/// Flies 1 m east per second along R, 0.5 m to its left; a wall at y = 2.
core::CycleRecord straight(int k)
{
  static const auto kWall = std::make_shared<test::AnalyticField>(std::vector<test::Obstacle>{
      Eigen::AlignedBox3d(Eigen::Vector3d(-50, 2, -50), Eigen::Vector3d(50, 3, 50))});
  core::CycleRecord r;
  r.index = static_cast<std::uint64_t>(k);
  r.has_state = true;
  r.t = r.state.t = 10.0 + 0.1 * k;
  r.refined = Eigen::Matrix3Xd::Zero(3, 2);
  r.state.p_L = {0.1 * k, 0.5, 1.0};
  r.state.p_W = r.state.p_L + Eigen::Vector3d(5.0, 0.0, 0.0);
  r.state.v_W = {1.0, 0.0, 0.0};
  r.field = kWall;
  r.reference.resize(3, 3);
  r.reference << 0.0, 3.0, 3.0, 0.0, 0.0, 4.0, 1.0, 1.0, 1.0;
  r.reference_point_L = {0.1 * k, 0.0, 1.0};
  r.refined_point_L = r.reference_point_L;
  r.horizon = Eigen::Matrix3Xd::Zero(3, 2);
  r.setpoint_L = {0.1 * k + 0.1, 0.3, 1.0};  // where it should be 0.1 s later
  r.distance_to_goal_m = 7.0 - 0.1 * k;
  r.decision_hash = 0xab0000000000001cull;
  return r;
}

TEST(FlightLog, NumbersOfAStraightFlight)
{
  RunInfo info;
  info.setpoint_lead_s = 0.1;
  detail::FlightLog log(info);
  for (int k = 0; k <= 20; ++k) log.add(straight(k));
  const FlightMetrics m = log.metrics();
  EXPECT_EQ(m.cycles, 21u);
  EXPECT_NEAR(m.duration_s, 2.0, 1e-12);
  EXPECT_NEAR(m.length_m, 2.0, 1e-12);
  EXPECT_NEAR(*m.reference_length_m, 7.0, 1e-12);
  EXPECT_NEAR(*m.goal_error_m, 5.0, 1e-12);
  EXPECT_NEAR(*m.min_map_clearance_m, 1.5, 1e-12);
  EXPECT_EQ(m.time_below_hard_s, 0.0);
  EXPECT_EQ(m.vs_reference_m.n, 21u);
  EXPECT_NEAR(*m.vs_reference_m.max, 0.5, 1e-12);
  EXPECT_EQ(m.vs_setpoint_m.n, 20u);  // the last one is not flown past
  EXPECT_NEAR(*m.vs_setpoint_m.mean, 0.2, 1e-9);
  EXPECT_EQ(m.estimate_error_m.n, 0u);
  EXPECT_NEAR(*m.max_speed_mps, 1.0, 1e-12);
  EXPECT_NEAR(*m.max_acceleration_mps2, 0.0, 1e-12);
  EXPECT_EQ(m.decision_hash, "ab0000000000001c");
}

TEST(FlightLog, SetpointIsComparedAtTheMomentItWasMeantFor)
{
  RunInfo info;
  info.setpoint_lead_s = 0.05;  // between two cycles: the flown position is interpolated
  detail::FlightLog log(info);
  for (int k = 0; k <= 10; ++k)
  {
    core::CycleRecord r = straight(k);
    r.setpoint_L = {0.1 * k + 0.05, 0.5, 1.0 - 0.25};
    log.add(r);
  }
  EXPECT_NEAR(*log.metrics().vs_setpoint_m.max, 0.25, 1e-9);
}

TEST(FlightLog, EstimateErrorDoesNotDependOnTheOrderOfTruthAndCycles)
{
  const auto truthAt = [](double t)
  { return Eigen::Vector3d(5.0 + (t - 10.0), 0.5, 1.0 + 0.3 * (t - 10.0)); };
  const auto fly = [&](auto truth_first)
  {
    detail::FlightLog log{RunInfo{}};
    const auto truth = [&](double from, double to)
    {
      for (double t = from; t < to - 1e-9; t += 0.02) log.addTruth(t, truthAt(t));
    };
    if (truth_first == 0) truth(9.99, 12.1);
    for (int k = 0; k <= 20; ++k)
    {
      if (truth_first == 1) truth(9.99 + 0.1 * k, 9.99 + 0.1 * (k + 1));
      log.add(straight(k));
    }
    if (truth_first == 2) truth(9.99, 12.1);
    return log.metrics().estimate_error_m;
  };
  for (const int order : {0, 1, 2})
  {
    SCOPED_TRACE(order);
    const Distribution d = fly(order);
    EXPECT_EQ(d.n, 21u);
    EXPECT_NEAR(*d.max, 0.6, 1e-9);  // 0.3 m/s for two seconds
    EXPECT_NEAR(*d.mean, 0.3, 1e-9);
  }
}

TEST(FlightLog, TruthWithAHoleSaysNothingInsideIt)
{
  detail::FlightLog log{RunInfo{}};
  log.addTruth(9.5, {5.0, 0.5, 1.0});
  for (int k = 0; k <= 20; ++k) log.add(straight(k));
  log.addTruth(12.5, {7.5, 0.5, 1.0});
  EXPECT_EQ(log.metrics().estimate_error_m.n, 0u);
}

TEST(FlightLog, WaitingForAnEstimateIsNotFlying)
{
  detail::FlightLog log{RunInfo{}};
  for (int k = 0; k <= 5; ++k)
  {
    log.addTruth(10.0 + 0.1 * k, {5.0 + 0.1 * k, 0.5, 1.0});
    core::CycleRecord r = straight(k);
    r.has_state = k >= 3;
    if (!r.has_state) r.state.p_L = r.state.p_W = r.state.v_W = Eigen::Vector3d(900.0, 0.0, 0.0);
    if (k == 5)
    {
      r.refined.resize(3, 0);
      r.refined_point_L.setZero();
    }
    log.add(r);
  }
  const FlightMetrics m = log.metrics();
  EXPECT_EQ(m.cycles, 6u);
  EXPECT_NEAR(m.length_m, 0.2, 1e-12);
  EXPECT_NEAR(*m.max_speed_mps, 1.0, 1e-12);
  EXPECT_NEAR(*m.max_acceleration_mps2, 0.0, 1e-12);
  EXPECT_EQ(m.vs_reference_m.n, 3u);
  EXPECT_NEAR(*m.estimate_error_m.max, 0.0, 1e-9);
  EXPECT_EQ(m.estimate_error_m.n, 3u);
  EXPECT_TRUE(std::isnan(log.cycles().front().p_L.x()));
  EXPECT_FALSE(log.cycles().back().refined_L.allFinite());
}

TEST(FlightLog, CountsPlanningTimingAndViolations)
{
  RunInfo info;
  info.hard_clearance_m = 2.0;  // the wall is 1.5 m away
  info.local_deadline_s = 0.01;
  info.map_deadline_s = 0.01;
  detail::FlightLog log(info);
  const char* outcomes[] = {"Clear", "Refined", "Recovered", "GuideFailed", "StillOccupied"};
  const char* fallbacks[] = {"", "None", "Shifted", "Brake", "Backup"};
  for (int k = 0; k < 5; ++k)
  {
    core::CycleRecord r = straight(k);
    r.refinement.ran = k != 1;
    r.refinement.outcome = outcomes[k];
    r.fallback = fallbacks[k];
    r.timing.local = 0.004 * k;  // 0 = did not run; 12 and 16 ms are late
    r.timing.map = r.timing.edt = 0.006;
    r.state.v_W.x() = k == 3 ? 1.5 : 1.0;
    log.add(r);
  }
  const FlightMetrics m = log.metrics();
  EXPECT_EQ(m.planning.replans, 4u);
  EXPECT_EQ(m.planning.refined_ok, 2u);
  EXPECT_EQ(m.planning.refined_failed, 2u);
  EXPECT_EQ(m.planning.recoveries, 1u);
  EXPECT_EQ(m.planning.shifted, 1u);
  EXPECT_EQ(m.planning.brake, 1u);
  EXPECT_EQ(m.planning.backup, 1u);
  EXPECT_EQ(m.timing.local.n, 4u);
  EXPECT_NEAR(*m.timing.local.mean, 0.010, 1e-12);
  EXPECT_EQ(m.timing.local_misses, 2u);
  EXPECT_EQ(m.timing.map_misses, 5u);
  EXPECT_EQ(m.timing.global_misses, 0u);
  EXPECT_NEAR(m.time_below_hard_s, 0.4, 1e-9);
  EXPECT_NEAR(*m.max_acceleration_mps2, 5.0, 1e-9);
}

/// Every number in it is finite or null (JSON cannot spell others), every key of the schema is
/// there.
TEST(MetricsJson, HoldsTheSchema)
{
  RunSummary summary;
  summary.result = {4, "TIMEOUT", "too late", false};
  summary.realtime_factor = INFINITY;
  summary.input.observations["CObservationIMU"] = 7;
  RunInfo info;
  info.title = "not \xff UTF-8";
  info.rawlog = info.title;
  for (const bool flown : {false, true})
  {
    SCOPED_TRACE(flown);
    detail::FlightLog log(info);
    if (flown)
      for (int k = 0; k < 3; ++k)
      {
        core::CycleRecord r = straight(k);
        r.distance_to_goal_m = std::nan("");
        log.add(r);
      }
    const auto json = nlohmann::json::parse(detail::metricsJson(log.metrics(), info, summary));
    EXPECT_EQ(json.at("schema_version"), 1);
    EXPECT_EQ(json.at("result").at("name"), "TIMEOUT");
    for (const char* pointer : {"/result/code",
                                "/result/message",
                                "/success",
                                "/goal_error_m",
                                "/length_m",
                                "/duration_s",
                                "/reference_length_m",
                                "/clearance/min_true_m",
                                "/clearance/min_map_m",
                                "/clearance/time_below_hard_s",
                                "/tracking/vs_reference_m/mean",
                                "/tracking/vs_setpoint_m/p95",
                                "/tracking/estimate_error_m/max",
                                "/speed/mean_mps",
                                "/speed/max_mps",
                                "/speed/max_acc_mps2",
                                "/timing/estimate/n",
                                "/timing/map/mean_ms",
                                "/timing/edt/median_ms",
                                "/timing/global/p95_ms",
                                "/timing/local/p99_ms",
                                "/timing/cycle/max_ms",
                                "/timing/deadline_misses/map",
                                "/timing/deadline_misses/global",
                                "/timing/deadline_misses/local",
                                "/planning/replans",
                                "/planning/refined_ok",
                                "/planning/refined_failed",
                                "/planning/certified",
                                "/planning/recoveries",
                                "/planning/rescues",
                                "/planning/fallbacks/shifted",
                                "/planning/fallbacks/backup",
                                "/planning/fallbacks/brake",
                                "/planning/time_without_verified_stop_s",
                                "/input/rawlog",
                                "/input/sha256",
                                "/input/duration_s",
                                "/input/observations",
                                "/input/points_per_scan/median",
                                "/input/points_per_scan/max",
                                "/input/dropped",
                                "/run/version",
                                "/run/build",
                                "/run/seed",
                                "/run/method",
                                "/run/config_sha256",
                                "/run/decision_hash",
                                "/run/threads",
                                "/run/realtime_factor"})
      EXPECT_TRUE(json.contains(nlohmann::json::json_pointer(pointer))) << pointer;
    EXPECT_TRUE(json["goal_error_m"].is_null());
    EXPECT_TRUE(json["run"]["realtime_factor"].is_null());
    EXPECT_TRUE(json["clearance"]["min_true_m"].is_null());
    EXPECT_TRUE(json["input"]["dropped"].is_object());
    EXPECT_EQ(json["clearance"]["min_map_m"].is_null(), !flown);
  }
}
}  // namespace
}  // namespace slalom::report
