// SPDX-License-Identifier: BSD-3-Clause
// Recorded flights. The bounds here only tell sane from broken; the figures go to the log.
#include <gtest/gtest.h>

#include "RealFlight.h"

namespace slalom::test
{
namespace
{
using core::PositionFix;
using estimation::StateEstimator;

std::filesystem::path real(const std::string& name)
{
  return sharedData("real/" + name);
}

void say(const char* name, const ErrorSum& e, const StateEstimator& estimator)
{
  std::printf("%-44s horizontal rms %.2f m, max %.2f m (n %d), heading rms %.1f deg, resets %llu",
              name, e.rms(), e.worst, e.n, e.yawRmsDeg(),
              static_cast<unsigned long long>(estimator.counters().resets));
  for (const auto& [reason, count] : estimator.counters().dropped)
    std::printf(", %s %llu", reason.c_str(), static_cast<unsigned long long>(count));
  std::printf("\n");
}

/// Feeds everything and hands out the estimate at each of the given times (rows of a table, time
/// first), as soon as it is available.
template <class Use>
void play(StateEstimator& estimator, const std::vector<Arrival>& arrivals, const Table& rows,
          Use&& use)
{
  std::size_t next = 0;
  for (const Arrival& a : arrivals)
  {
    feed(estimator, a.measurement);
    const auto now = estimator.state();
    while (now && next < rows.size() && rows[next][0] <= now->t)
    {
      if (const auto s = estimator.stateAt(rows[next][0])) use(*s, rows[next]);
      ++next;
    }
    if (!now)
      while (next < rows.size() && rows[next][0] < a.at) ++next;
  }
}

double yawFrom(const std::vector<double>& row, std::size_t first)
{
  return core::yawOf(fromAerospace(row[first], row[first + 1], row[first + 2], row[first + 3]));
}
}  // namespace

TEST(RealFlights, InavQuadAgainstItsGps)
{
  const auto dir = real("inav_3dr_quad");
  if (!exists(dir)) GTEST_SKIP() << dir;
  const Table gps = readCsv(dir / "gps.csv");
  const Table attitude = readCsv(dir / "attitude_rpy.csv");
  const TangentPlane plane(gps[0][1], gps[0][2], gps[0][3]);
  for (const bool thinned : {false, true})
  {
    std::vector<Arrival> arrivals;
    appendImu(arrivals, dir / "imu.csv");
    appendGps(arrivals, dir / "gps.csv", plane, 0.0);
    sortByArrival(arrivals);
    double last = -1e9;
    std::erase_if(arrivals,
                  [&](const Arrival& a)
                  {
                    if (!thinned || std::holds_alternative<core::ImuSample>(a.measurement))
                      return false;
                    if (a.at - last >= 0.99) last = a.at;
                    return a.at != last;
                  });
    StateEstimator estimator({});
    ErrorSum error;
    play(estimator, arrivals, gps,
         [&](const core::VehicleState& s, const std::vector<double>& r)
         { error.add(s.p_W - plane(r[1], r[2], r[3])); });
    say(thinned ? "inav, GPS at 1 Hz, against all fixes" : "inav, against its fixes", error,
        estimator);
    StateEstimator again({});
    ErrorSum heading;
    play(again, arrivals, attitude,
         [&](const core::VehicleState& s, const std::vector<double>& r)
         {
           if (s.t < 150.0) return;
           const double yaw = (90.0 - r[3]) / 57.29577951;
           heading.add(Eigen::Vector3d::Zero(), core::wrapAngle(s.yaw() - yaw));
         });
    say("inav, heading against on-board AHRS, t>150", heading, again);
    EXPECT_GT(error.n, 1500);
    EXPECT_LT(error.rms(), 2.0);
  }
}

TEST(RealFlights, ManualFastFlightAndCrash)
{
  const auto dir = real("px4_outdoor_manual_fast");
  if (!exists(dir)) GTEST_SKIP() << dir;
  const TangentPlane plane(53.7156778, 9.8207831, 10.89);
  const Table gps = readCsv(dir / "gps.csv");
  const Table reference = readCsv(dir / "autopilot_estimate.csv");
  for (const double lag : {0.0, 0.1})
  {
    std::vector<Arrival> arrivals;
    appendImu(arrivals, dir / "imu.csv");
    appendGps(arrivals, dir / "gps.csv", plane, lag);
    sortByArrival(arrivals);
    StateEstimator estimator({});
    ErrorSum flight;
    play(estimator, arrivals, reference,
         [&](const core::VehicleState& s, const std::vector<double>& r)
         {
           // It hovers until 61 s, and there is no compass among the inputs.
           if (s.t < 62.0 || s.t > 114.0) return;
           flight.add(s.p_W - enu(r[1], r[2], r[3]), core::wrapAngle(s.yaw() - yawFrom(r, 7)));
         });
    say(lag > 0.0 ? "manual fast, vs EKF2, stamps -0.1 s" : "manual fast, vs EKF2", flight,
        estimator);
    StateEstimator again({});
    ErrorSum crash;
    play(again, arrivals, gps,
         [&](const core::VehicleState& s, const std::vector<double>& r)
         {
           if (s.t > 118.0) crash.add(s.p_W - plane(r[1], r[2], r[3]));
         });
    say("manual fast, after the crash, vs GPS", crash, again);
    EXPECT_GT(flight.n, 300);
    EXPECT_LT(flight.yawRmsDeg(), 20.0);
    EXPECT_LT(flight.rms(), 3.0);
    EXPECT_GT(crash.n, 10);
    EXPECT_LT(crash.worst, 3.0);
    EXPECT_TRUE(again.state()->covariance.allFinite());
  }
}

TEST(RealFlights, Phantom4AgainstRtkTruth)
{
  for (const char* name : {"horizontal_path_3", "vertical_path_1"})
  {
    const auto dir = real("ansfl_p4rtk") / name;
    if (!exists(dir)) GTEST_SKIP() << dir;
    const Table truth = readCsv(dir / "rtk_gt.csv");
    std::vector<Arrival> arrivals;
    appendImu(arrivals, dir / "imu.csv");
    core::Rng rng(1);
    for (std::size_t i = 0; i < truth.size(); i += 10)
    {
      PositionFix fix;
      fix.t = truth[i][0];
      fix.sigma.setConstant(0.1);
      fix.p_W = enu(truth[i][1], truth[i][2], truth[i][3]) + rng.normal3(0.1);
      arrivals.push_back({fix.t, fix});
    }
    sortByArrival(arrivals);
    StateEstimator estimator({});
    ErrorSum error;
    play(estimator, arrivals, truth,
         [&](const core::VehicleState& s, const std::vector<double>& r)
         { error.add(s.p_W - enu(r[1], r[2], r[3])); });
    say(name, error, estimator);
    EXPECT_GT(error.n, 150);
    EXPECT_LT(error.rms(), 3.0);
  }
}

TEST(RealFlights, MissionWithSlowImu)
{
  const auto dir = real("px4_outdoor_mission_motorfail");
  if (!exists(dir)) GTEST_SKIP() << dir;
  const TangentPlane plane(47.3565835, 8.5189385, 419.888);
  std::vector<Arrival> arrivals;
  appendImu(arrivals, dir / "imu.csv");
  appendGps(arrivals, dir / "gps.csv", plane, 0.0);
  sortByArrival(arrivals);
  StateEstimator estimator({});
  ErrorSum error;
  play(estimator, arrivals, readCsv(dir / "autopilot_estimate.csv"),
       [&](const core::VehicleState& s, const std::vector<double>& r)
       { error.add(s.p_W - enu(r[1], r[2], r[3]), core::wrapAngle(s.yaw() - yawFrom(r, 7))); });
  say("motor failure, IMU 8.6 Hz, vs EKF2", error, estimator);
  EXPECT_GT(estimator.counters().dropped.at("imu_too_slow"), 250u);
  EXPECT_GT(error.n, 200);
  EXPECT_LT(error.rms(), 1.5);
  // It does not fly nose first; the variance must say that the course is a guess.
  EXPECT_GT(std::sqrt(estimator.state()->covariance(8, 8)), 0.4);
}

}  // namespace slalom::test
