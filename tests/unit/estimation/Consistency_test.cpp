// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <string>

#include "SimulatedFlight.h"

namespace slalom::test
{
namespace
{
using core::VehicleState;
using estimation::StateEstimator;
using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Vector9 = Eigen::Matrix<double, 9, 1>;

double nees(const VehicleState& s, const FlightPath& path)
{
  const Vector9 e = errorOf(s, path);
  return e.dot(s.covariance.ldlt().solve(e));
}

/// Mean NEES of each block and of all nine states, at the end of each flight.
struct MeanNees
{
  double all = 0.0, p = 0.0, v = 0.0, r = 0.0;
  int samples = 0;
};

MeanNees meanNees(const SensorSuite& suite, const FlightPath& path, int runs)
{
  MeanNees mean;
  for (int run = 0; run < runs; ++run)
  {
    StateEstimator estimator({});
    for (const Arrival& a : simulate(path, suite, 1000 + run)) feed(estimator, a.measurement);
    const auto s = estimator.state();
    if (!s) continue;
    const Vector9 e = errorOf(*s, path);
    const auto block = [&](int i)
    {
      const Eigen::Vector3d part = e.segment<3>(i);
      return part.dot(s->covariance.block<3, 3>(i, i).ldlt().solve(part));
    };
    mean.all += nees(*s, path);
    mean.p += block(0);
    mean.v += block(3);
    mean.r += block(6);
    ++mean.samples;
  }
  mean.all /= mean.samples;
  mean.p /= mean.samples;
  mean.v /= mean.samples;
  mean.r /= mean.samples;
  return mean;
}

// 95 % interval of the mean of `n` chi-square variables with `dof` degrees of freedom; n dof is
// large, so the normal approximation holds.
void expectConsistent(double value, int dof, int n, const char* what)
{
  const double half = 1.96 * std::sqrt(2.0 * dof / n);
  EXPECT_GT(value, dof - half) << what;
  EXPECT_LT(value, dof + half) << what;
}

void expectConsistent(const MeanNees& mean, int runs)
{
  ASSERT_EQ(mean.samples, runs) << "some flights never aligned";
  expectConsistent(mean.all, 9, runs, "all nine states");
  // Single blocks are looked at as well, at 99.9 %: four looks at one sample.
  const double wide = 3.29 * std::sqrt(2.0 * 3 / runs);
  EXPECT_NEAR(mean.p, 3.0, wide);
  EXPECT_NEAR(mean.v, 3.0, wide);
  EXPECT_NEAR(mean.r, 3.0, wide);
  testing::Test::RecordProperty("nees_of_9_states", std::to_string(mean.all));
}
}  // namespace

TEST(Consistency, NeesOfWorldVelocityFlight)
{
  SensorSuite suite;
  suite.duration = 15.0;
  expectConsistent(meanNees(suite, FlightPath::loops(1.0), 100), 100);
}

TEST(Consistency, NeesOfBodyVelocityFlightWithDelayedGpsAndLever)
{
  SensorSuite suite;
  suite.duration = 15.0;
  suite.velocity_in_body = true;
  suite.gps_delay = 0.2;
  suite.lever_B = {0.1, -0.05, 0.2};
  expectConsistent(meanNees(suite, FlightPath::loops(1.0), 100), 100);
}

TEST(Consistency, NeesOfAirborneStartWithPositionOnly)
{
  SensorSuite suite;
  suite.duration = 20.0;
  suite.velocity_hz = 0.0;
  expectConsistent(meanNees(suite, FlightPath::loops(-10.0), 100), 100);
}

// A filter that is told half the noise there is must be caught by the same measure.
TEST(Consistency, NeesCatchesAnOverconfidentFilter)
{
  SensorSuite suite;
  suite.duration = 10.0;
  const FlightPath path = FlightPath::loops(1.0);
  double mean = 0.0;
  const int runs = 30;
  for (int run = 0; run < runs; ++run)
  {
    StateEstimator estimator({});
    for (Arrival a : simulate(path, suite, 1000 + run))
    {
      if (auto* fix = std::get_if<core::PositionFix>(&a.measurement)) fix->sigma *= 0.5;
      if (auto* fix = std::get_if<core::VelocityFix>(&a.measurement)) fix->sigma *= 0.5;
      feed(estimator, a.measurement);
    }
    ASSERT_TRUE(estimator.state());
    mean += nees(*estimator.state(), path) / runs;
  }
  EXPECT_GT(mean, 9.0 + 1.96 * std::sqrt(18.0 / runs));
}

TEST(Consistency, CovarianceIsSymmetricAndPositive)
{
  SensorSuite suite;
  suite.duration = 60.0;
  suite.lever_B = {0.3, 0.0, -0.1};
  suite.gps_delay = 0.1;
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
  {
    SCOPED_TRACE(seed);
    StateEstimator estimator({});
    int checked = 0;
    for (const Arrival& a : simulate(FlightPath::loops(1.0), suite, seed))
    {
      // A hole in everything, and one in the IMU.
      if (a.at > 20.0 && a.at < 23.0) continue;
      if (a.at > 30.0 && a.at < 35.0 && std::holds_alternative<core::ImuSample>(a.measurement))
        continue;
      feed(estimator, a.measurement);
      const auto s = estimator.state();
      if (!s) continue;
      ++checked;
      ASSERT_EQ((s->covariance - s->covariance.transpose()).cwiseAbs().maxCoeff(), 0.0);
      ASSERT_EQ(Eigen::LLT<Matrix9>(s->covariance).info(), Eigen::Success) << "t " << s->t;
    }
    EXPECT_GT(checked, 5000);
  }
}

TEST(Consistency, SameInputSameBits)
{
  SensorSuite suite;
  suite.gps_delay = 0.15;
  const auto arrivals = simulate(FlightPath::loops(1.0), suite, 7);
  StateEstimator a({});
  StateEstimator b({});
  b.add(core::ImuSample{3.0});
  b.reset();
  for (const Arrival& arrival : arrivals)
  {
    feed(a, arrival.measurement);
    feed(b, arrival.measurement);
    const auto sa = a.state();
    const auto sb = b.state();
    ASSERT_EQ(sa.has_value(), sb.has_value());
    if (!sa) continue;
    ASSERT_EQ(sa->p_W, sb->p_W);
    ASSERT_EQ(sa->p_L, sb->p_L);
    ASSERT_EQ(sa->q_WB.coeffs(), sb->q_WB.coeffs());
    ASSERT_EQ(sa->covariance, sb->covariance);
  }
}

}  // namespace slalom::test
