// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationComment.h>

#include <algorithm>
#include <cmath>

#include "Files.h"
#include "Packets.h"
#include "Rawlogs.h"
#include "slalom/mrpt_io/Diagnosis.h"
#include "slalom/mrpt_io/RawlogWriter.h"

using namespace slalom;
using namespace slalom::mrpt_io;

namespace
{
constexpr double kStart = 1.7e9;

struct Diagnosis : ::testing::Test
{
  void SetUp() override { writer = std::make_unique<RawlogWriter>(file); }
  void scans(int count)
  {
    core::Rng rng(1);
    const auto packets = test::spin({}, 76, rng);
    for (int i = 0; i < count; ++i)
      writer->write(
          *makeVelodyneObservation(kStart + 0.1 * i, packets, Eigen::Isometry3d::Identity()));
  }
  void imuAndGps(int count, double rate)
  {
    const EnuFrame frame({36.8, -2.4, 50.0});
    for (int i = 0; i < count; ++i)
    {
      writer->write(*makeImuObservation(kStart + i / rate, {0.0, {0, 0, 9.81}, {}}));
      if (i % 20 == 0) writer->write(*makeGpsObservation(kStart + i / rate, {}, frame));
    }
  }
  std::vector<Finding> examine()
  {
    writer->close();
    return diagnoseRawlog(file);
  }
  static bool has(const std::vector<Finding>& all, Severity severity, const std::string& part)
  {
    return std::any_of(all.begin(), all.end(),
                       [&](const Finding& f) {
                         return f.severity == severity && f.text.find(part) != std::string::npos;
                       });
  }
  static bool any(const std::vector<Finding>& all, Severity severity)
  {
    return has(all, severity, "");
  }

  test::TempFolder folder;
  std::filesystem::path file = folder.path() / "a.rawlog";
  std::unique_ptr<RawlogWriter> writer;
};

TEST_F(Diagnosis, AFlightIsGood)
{
  scans(5);
  imuAndGps(200, 200.0);
  const auto all = examine();
  EXPECT_TRUE(has(all, Severity::Ok, "verdict: a flight"));
  EXPECT_TRUE(has(all, Severity::Ok, "CObservationIMU \"IMU\": 200, 200.0 Hz"));
  EXPECT_FALSE(any(all, Severity::Warning));
  EXPECT_FALSE(any(all, Severity::Error));
}

TEST_F(Diagnosis, RangeDataAloneIsSaidToBeThat)
{
  scans(5);
  EXPECT_TRUE(has(examine(), Severity::Warning, "verdict: range data only"));
}

TEST_F(Diagnosis, APlanarLaserIsNoFlight)
{
  for (int i = 0; i < 5; ++i)
  {
    mrpt::obs::CObservation2DRangeScan o;
    o.timestamp = mrpt::Clock::fromDouble(kStart + i);
    o.maxRange = 10.0f;
    o.resizeScanAndAssign(181, 2.0f, true);
    writer->write(o);
  }
  EXPECT_TRUE(has(examine(), Severity::Error, "a 2-D laser log is not a flight"));
}

TEST_F(Diagnosis, NothingUsefulIsAnError)
{
  mrpt::obs::CObservationComment comment;
  comment.timestamp = mrpt::Clock::fromDouble(kStart);
  writer->write(comment);
  EXPECT_TRUE(has(examine(), Severity::Error, "nothing that a replay can use"));
}

TEST_F(Diagnosis, GapsSlowImusAndBackwardStampsAreNamed)
{
  imuAndGps(100, 20.0);
  writer->write(*makeImuObservation(kStart + 30.0, {}));
  writer->write(*makeImuObservation(kStart + 29.0, {}));
  const auto all = examine();
  EXPECT_TRUE(has(all, Severity::Warning, "gap of 25.05 s"));
  EXPECT_TRUE(has(all, Severity::Warning, "1 stamps run backwards"));
  EXPECT_TRUE(has(all, Severity::Warning, "too slow to be integrated"));
  EXPECT_TRUE(has(all, Severity::Warning, "GPS without a usable IMU"));
}

TEST_F(Diagnosis, NumbersThatAreNoneAreNamed)
{
  scans(2);
  writer->write(*makeImuObservation(kStart, {0.0, {std::nan(""), 0, 0}, {}}));
  EXPECT_TRUE(has(examine(), Severity::Warning, "1 x IMU not finite"));
}

TEST_F(Diagnosis, DamageIsAnErrorAndTheRestIsStillTold)
{
  scans(5);
  imuAndGps(200, 200.0);
  writer->close();
  const std::string whole = test::contents(file);
  test::writeFile(file, whole.substr(0, whole.size() - 100));
  const auto cut = diagnoseRawlog(file);
  EXPECT_TRUE(has(cut, Severity::Error, "ends too early"));
  EXPECT_TRUE(has(cut, Severity::Ok, "verdict: a flight"));
  std::string flipped = whole;
  flipped[whole.size() / 2] = static_cast<char>(flipped[whole.size() / 2] ^ 1);
  test::writeFile(file, flipped);
  EXPECT_TRUE(has(diagnoseRawlog(file), Severity::Error, "damaged"));
  test::writeFile(file, "text");
  EXPECT_TRUE(has(diagnoseRawlog(file), Severity::Error, "not a rawlog"));
}
}  // namespace
