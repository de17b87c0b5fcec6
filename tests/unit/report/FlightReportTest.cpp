// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "Style.h"
#include "SyntheticFlight.h"
#include "TempFolder.h"
#include "slalom/report/FlightReport.h"

namespace slalom::report
{
namespace
{
namespace fs = std::filesystem;
using test::contentOf;
using test::linesOf;

RunInfo someInfo()
{
  RunInfo info;
  info.title = "synthetic forest";
  info.epoch_s = 1.7e9;
  info.max_speed_mps = 1.5;
  info.local_deadline_s = 0.02;
  info.effective_ini = "[report]\n";
  return info;
}

RunSummary someSummary()
{
  RunSummary summary;
  summary.result = {0, "GOAL_REACHED", "", true};
  return summary;
}

/// Flies `cycles` cycles into `folder`; wall times differ with `haste`.
void fly(const fs::path& folder, int cycles, double haste, ReportConfig config = {})
{
  const test::SyntheticFlight flight;
  FlightReport report(config, folder, someInfo());
  for (int i = 0; i < cycles; ++i)
  {
    core::CycleRecord record = flight.cycle(i);
    record.timing.cycle *= haste;
    record.refinement.solve.wall_time = record.nmpc.wall_time =
        std::chrono::nanoseconds(static_cast<int>(1000 * haste));
    report.addTruth(flight.truth(record.t - 0.02));
    report.add(record);
  }
  report.finish(someSummary());
}

constexpr const char* kDeterministic[] = {
    "cycles.csv",   "commands.csv",  "estimate.tum",      "reference.tum",
    "refined.tum",  "truth.tum",     "setpoints.tum",     "overview.png",
    "tracking.png", "effective.ini", "cycles/000000.png", "cycles/000020.png"};

TEST(FlightReport, WritesEveryFileAndNoPart)
{
  const test::TempFolder folder;
  fly(folder.path(), 45, 1.0);
  for (const char* name : kDeterministic) EXPECT_TRUE(fs::exists(folder / name)) << name;
  for (const char* name : {"metrics.json", "timing.png", "timing.csv", "cycles/000040.png"})
    EXPECT_TRUE(fs::exists(folder / name)) << name;
  for (const auto& entry : fs::recursive_directory_iterator(folder.path()))
    EXPECT_NE(entry.path().extension(), ".part") << entry.path();
  const auto pictures = std::distance(fs::directory_iterator(folder / "cycles"), {});
  EXPECT_EQ(pictures, 3);  // at 0, 2 and 4 s
}

TEST(FlightReport, RowsHaveOneColumnPerNameAndOneRowPerCycle)
{
  const test::TempFolder folder;
  fly(folder.path(), 30, 1.0);
  for (const char* name : {"cycles.csv", "commands.csv", "timing.csv"})
  {
    SCOPED_TRACE(name);
    const auto lines = linesOf(folder / name);
    ASSERT_EQ(lines.size(), 31u);
    EXPECT_TRUE(lines[0].starts_with("t,"));
    const auto commas = std::count(lines[0].begin(), lines[0].end(), ',');
    for (const std::string& line : lines)
    {
      bool quoted = false;
      std::ptrdiff_t seen = 0;
      for (const char c : line) quoted ^= c == '"', seen += c == ',' && !quoted;
      EXPECT_EQ(seen, commas) << line;
    }
  }
  EXPECT_EQ(linesOf(folder / "commands.csv")[0], "t,vx,vy,vz,wz");
  for (const char* name : {"estimate.tum", "reference.tum", "refined.tum", "setpoints.tum"})
    EXPECT_EQ(linesOf(folder / name).size(), 30u) << name;
  EXPECT_EQ(linesOf(folder / "truth.tum").size(), 30u);
  EXPECT_TRUE(linesOf(folder / "setpoints.tum")[0].starts_with("1700000000.100000 "));
}

TEST(FlightReport, EqualRecordsGiveEqualBytesWhateverTheClockSaid)
{
  const test::TempFolder folder;
  fs::create_directories(folder / "a");
  fs::create_directories(folder / "b");
  fly(folder / "a", 30, 1.0);
  fly(folder / "b", 30, 1.7);
  for (const char* name : kDeterministic)
    EXPECT_TRUE(contentOf(folder / "a" / name) == contentOf(folder / "b" / name)) << name;
  EXPECT_NE(contentOf(folder / "a" / "timing.csv"), contentOf(folder / "b" / "timing.csv"));
}

TEST(FlightReport, MetricsAgreeWithTheRowFiles)
{
  const test::TempFolder folder;
  fly(folder.path(), 60, 1.0);
  const auto json = nlohmann::json::parse(contentOf(folder / "metrics.json"));
  double worst = 0.0, sum = 0.0;
  const auto estimate = linesOf(folder / "estimate.tum"),
             reference = linesOf(folder / "reference.tum");
  for (std::size_t i = 0; i < estimate.size(); ++i)
  {
    double t, a[3], b[3];
    ASSERT_EQ(std::sscanf(estimate[i].c_str(), "%lf %lf %lf %lf", &t, a, a + 1, a + 2), 4);
    ASSERT_EQ(std::sscanf(reference[i].c_str(), "%lf %lf %lf %lf", &t, b, b + 1, b + 2), 4);
    const double error = std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    worst = std::max(worst, error);
    sum += error;
  }
  EXPECT_NEAR(json["tracking"]["vs_reference_m"]["max"], worst, 1e-5);
  EXPECT_NEAR(json["tracking"]["vs_reference_m"]["mean"], sum / 60.0, 1e-5);
  EXPECT_NEAR(json["duration_s"], 5.9, 1e-9);
  EXPECT_EQ(json["planning"]["replans"], 30);
  EXPECT_TRUE(json["tracking"]["estimate_error_m"]["mean"].is_number());
}

int pixelsOf(const cv::Mat& image, cv::Rect area, detail::Colour colour)
{
  cv::Mat hits;
  cv::inRange(image(area), colour.bgr(), colour.bgr(), hits);
  return cv::countNonZero(hits);
}

TEST(FlightReport, PicturesShowWhatTheRecordHolds)
{
  const test::TempFolder folder;
  fly(folder.path(), 45, 1.0);
  const cv::Mat cycle = cv::imread((folder / "cycles/000040.png").string());
  ASSERT_EQ(cycle.size(), cv::Size(1260, 900));
  const cv::Rect map(70, 40, 800, 800);
  namespace style = detail::style;
  EXPECT_GT(pixelsOf(cycle, map, style::kRefined.colour), 200);
  EXPECT_GT(pixelsOf(cycle, map, style::kOccupiedSegment.colour), 50);
  EXPECT_GT(pixelsOf(cycle, map, style::kPushingPath.colour), 50);
  EXPECT_GT(pixelsOf(cycle, map, style::kGuide.colour), 20);
  EXPECT_GT(pixelsOf(cycle, map, style::kHorizon.colour), 50);
  EXPECT_GT(pixelsOf(cycle, map, style::kTrail.colour), 50);
  EXPECT_GT(pixelsOf(cycle, map, detail::kBlack), 1000);  // trunks
  EXPECT_GT(pixelsOf(cycle, {900, 70, 340, 30}, style::kGood), 1000);

  // Before the first map there is nothing to be black.
  const cv::Mat first = cv::imread((folder / "cycles/000000.png").string());
  EXPECT_LT(pixelsOf(first, map, detail::kBlack), 50);
  EXPECT_GT(pixelsOf(first, map, detail::hatchAt(1, 0)), 100000);

  const cv::Mat overview = cv::imread((folder / "overview.png").string());
  ASSERT_GT(overview.cols, 900);
  EXPECT_GT(pixelsOf(overview, {{0, 0}, overview.size()}, style::kGoal), 50);
  EXPECT_GT(pixelsOf(overview, {{0, 0}, overview.size()}, style::kRefinedBand.colour), 50);
}

TEST(FlightReport, PictureSizeAndIntervalAreObeyed)
{
  const test::TempFolder folder;
  ReportConfig config;
  config.picture_interval_s = 0.5;
  config.picture_size_px = 600;
  fly(folder.path(), 21, 1.0, config);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "cycles"), {}), 5);
  EXPECT_EQ(cv::imread((folder / "cycles/000005.png").string()).size(), cv::Size(840, 600));

  fs::create_directories(folder / "none");
  config.picture_interval_s = 0.0;
  fly(folder / "none", 5, 1.0, config);
  EXPECT_FALSE(fs::exists(folder / "none" / "cycles"));
}

TEST(FlightReport, NoCycleAtAllIsAReport)
{
  const test::TempFolder folder;
  FlightReport report({}, folder.path(), {});
  report.finish({});
  EXPECT_NO_THROW(report.finish({}));
  const auto json = nlohmann::json::parse(contentOf(folder / "metrics.json"));
  EXPECT_EQ(json["run"]["cycles"], 0);
  EXPECT_TRUE(json["goal_error_m"].is_null());
  EXPECT_TRUE(json["timing"]["cycle"]["median_ms"].is_null());
  for (const char* name : {"overview.png", "timing.png", "tracking.png"})
    EXPECT_FALSE(cv::imread((folder / name).string()).empty()) << name;
  EXPECT_EQ(linesOf(folder / "cycles.csv").size(), 1u);
  EXPECT_EQ(contentOf(folder / "truth.tum"), "");
}

TEST(FlightReport, AnEmptyRecordAndOneFullOfNanAreDrawn)
{
  const test::TempFolder folder;
  ReportConfig config;
  config.picture_interval_s = 0.1;
  FlightReport report(config, folder.path(), {});
  report.add({});
  const test::SyntheticFlight flight;
  core::CycleRecord broken = flight.cycle(50);
  const double nan = std::nan("");
  broken.t = broken.state.t = 1.0;
  broken.state.p_L.setConstant(nan);
  broken.state.p_W.setConstant(nan);
  broken.state.v_W.setConstant(nan);
  broken.refined.setConstant(nan);
  broken.horizon.setConstant(nan);
  broken.command.yaw_rate = nan;
  report.add(broken);
  report.add(flight.cycle(51));
  report.finish({});
  const auto json = nlohmann::json::parse(contentOf(folder / "metrics.json"));
  EXPECT_EQ(json["run"]["cycles"], 3);
  EXPECT_EQ(linesOf(folder / "estimate.tum").size(), 1u);
}

TEST(FlightReport, CyclesWithoutAnEstimateGiveNoPose)
{
  const test::TempFolder folder;
  const test::SyntheticFlight flight;
  ReportConfig config;
  config.picture_interval_s = 0.1;
  FlightReport report(config, folder.path(), {});
  for (int i = 0; i < 6; ++i)
  {
    core::CycleRecord record = flight.cycle(i);
    record.has_state = i >= 4;
    report.add(record);
  }
  report.finish({});
  EXPECT_EQ(linesOf(folder / "cycles.csv").size(), 7u);
  EXPECT_NE(linesOf(folder / "cycles.csv")[1].find(",,,,,,,"), std::string::npos);
  for (const char* name : {"estimate.tum", "reference.tum", "setpoints.tum"})
    EXPECT_EQ(linesOf(folder / name).size(), 2u) << name;
}

TEST(FlightReport, AProcessThatDiesTakesNoMoreThanASecondWithIt)
{
  const test::TempFolder folder;
  const test::SyntheticFlight flight;
  ReportConfig config;
  config.picture_interval_s = 0.0;
  FlightReport report(config, folder.path(), {});
  for (int i = 0; i <= 40; ++i) report.add(flight.cycle(i));
  // What the operating system has while the report is still open, i.e. after a kill.
  EXPECT_GE(linesOf(folder / "cycles.csv.part").size(), 1u + 31u);
  EXPECT_GE(linesOf(folder / "estimate.tum.part").size(), 31u);
}

TEST(FlightReport, WithoutFinishTheRowsAreInPart)
{
  const test::TempFolder folder;
  {
    const test::SyntheticFlight flight;
    FlightReport report({}, folder.path(), {});
    report.add(flight.cycle(0));
  }
  EXPECT_FALSE(fs::exists(folder / "cycles.csv"));
  EXPECT_EQ(linesOf(folder / "cycles.csv.part").size(), 2u);
}

TEST(FlightReport, OneFullFileDoesNotCostTheOthers)
{
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  const test::TempFolder folder;
  fs::create_symlink("/dev/full", folder / "commands.csv.part");
  const test::SyntheticFlight flight;
  FlightReport report({}, folder.path(), {});
  for (int i = 0; i < 10; ++i) EXPECT_THROW(report.add(flight.cycle(i)), OutputError);
  try
  {
    report.finish(someSummary());
    FAIL() << "the full disk went unnoticed";
  }
  catch (const OutputError& error)
  {
    EXPECT_EQ(error.path(), folder / "commands.csv");
    EXPECT_NE(std::string(error.what()).find("No space left"), std::string::npos);
  }
  EXPECT_EQ(linesOf(folder / "cycles.csv").size(), 11u);
  EXPECT_EQ(linesOf(folder / "timing.csv").size(), 11u);
  EXPECT_EQ(linesOf(folder / "estimate.tum").size(), 10u);
  EXPECT_TRUE(fs::exists(folder / "metrics.json"));
  EXPECT_TRUE(fs::exists(folder / "overview.png"));
}

TEST(FlightReport, UnwritableFolderIsAnOutputError)
{
  const test::TempFolder folder;
  EXPECT_THROW(FlightReport({}, folder / "missing", {}), OutputError);
  ReportConfig config;
  config.view_half_width_m = std::nan("");
  EXPECT_THROW(FlightReport(config, folder.path(), {}), std::invalid_argument);
}

TEST(FlightReport, MemoryGrowsByASmallFixedAmountPerCycle)
{
  const test::TempFolder folder;
  ReportConfig config;
  config.picture_interval_s = 0.0;
  const test::SyntheticFlight flight;
  FlightReport report(config, folder.path(), {});
  // The same places again and again: what grows is the memory per cycle, not per square metre.
  std::size_t after_first = 0;
  constexpr int kRounds = 12, kCycles = 100;
  for (int round = 0; round < kRounds; ++round)
  {
    for (int i = 0; i < kCycles; ++i)
    {
      core::CycleRecord record = flight.cycle(i);
      record.t = record.state.t = 0.1 * (round * kCycles + i);
      report.addTruth(flight.truth(record.t - 0.02));
      report.add(record);
    }
    if (round == 0) after_first = report.memoryBytes();
  }
  // A vector may hold twice what it uses.
  const double per_cycle =
      static_cast<double>(report.memoryBytes() - after_first) / ((kRounds - 1) * kCycles);
  EXPECT_LT(per_cycle, 2.0 * 240.0);
}
}  // namespace
}  // namespace slalom::report
