// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/mrpt_io/Diagnosis.h"

#include <mrpt/core/Clock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>

#include "slalom/mrpt_io/ObservationDecoder.h"
#include "slalom/mrpt_io/RawlogReader.h"

namespace slalom::mrpt_io
{
namespace
{
constexpr double kSlowImu = 50.0;     // [Hz] below this strap-down integration is hopeless
constexpr double kGapFactor = 5.0;    // times the usual interval ...
constexpr double kShortestGap = 0.5;  // ... and at least this [s] makes a gap worth a word
constexpr double kFlat = 1e-3;        // [m] a scan without height is planar
constexpr std::uint64_t kFewFixes = 3;

std::string number(double value, int decimals)
{
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  return text.data();
}

template <class T>
T median(std::vector<T> values)
{
  if (values.empty()) return T();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::string bareName(const mrpt::obs::CObservation& o)
{
  const std::string name = o.GetRuntimeClass()->className;
  return name.substr(name.rfind(':') + 1);
}

struct Sensor
{
  std::uint64_t count = 0, backwards = 0;
  double first = 0.0, last = 0.0, largest_gap = 0.0, gap_at = 0.0;  ///< [s]
  std::vector<double> intervals;

  void stamp(double t)
  {
    if (count++ > 0)
    {
      const double dt = t - last;
      if (dt < 0.0) ++backwards;
      if (dt > largest_gap)
      {
        largest_gap = dt;
        gap_at = last;
      }
      intervals.push_back(std::abs(dt));
    }
    else
      first = t;
    last = t;
  }
  [[nodiscard]] double rate() const
  {
    const double dt = median(intervals);
    return dt > 0.0 ? 1.0 / dt : 0.0;
  }
};

/// What the decoder made of the recording.
struct Content
{
  std::uint64_t imu = 0, fixes = 0, velocities = 0, poses = 0, truth = 0;
  std::uint64_t volumetric = 0, planar = 0, empty = 0, points = 0;
  std::vector<std::size_t> points_per_scan;

  void add(const core::Measurement& m)
  {
    imu += std::holds_alternative<core::ImuSample>(m);
    fixes += std::holds_alternative<core::PositionFix>(m);
    velocities += std::holds_alternative<core::VelocityFix>(m);
    poses += std::holds_alternative<core::PoseFix>(m);
    if (const auto* scan = std::get_if<core::RangeScan>(&m)) addScan(*scan);
  }
  void addScan(const core::RangeScan& scan)
  {
    points += scan.points.size();
    points_per_scan.push_back(scan.points.size());
    const auto high = [](const core::ScanPoint& p) { return std::abs(p.p_S.z()) > kFlat; };
    if (scan.points.empty())
      ++empty;
    else if (std::any_of(scan.points.begin(), scan.points.end(), high))
      ++volumetric;
    else
      ++planar;
  }
};

class Examination
{
 public:
  std::vector<Finding> run(const std::filesystem::path& file)
  {
    std::string damage;
    try
    {
      RawlogReader reader(file);
      damage = readAll(reader);
      tellObjects(reader.statistics());
    }
    catch (const RawlogError& e)
    {
      say(Severity::Error, e.what());
      return findings_;
    }
    if (!damage.empty()) say(Severity::Error, damage);
    for (const auto& [name, sensor] : sensors_) tellSensor(name, sensor);
    tellPoints();
    tellDropped();
    tellVerdict();
    return findings_;
  }

 private:
  void say(Severity severity, const std::string& text) { findings_.push_back({severity, text}); }

  std::string readAll(RawlogReader& reader)
  {
    try
    {
      while (const auto o = reader.next())
      {
        sensors_[bareName(*o) + " \"" + o->sensorLabel + "\""].stamp(
            mrpt::Clock::toDouble(o->timestamp));
        for (const core::Measurement& m : decoder_.decode(*o)) content_.add(m);
        content_.truth += decoder_.truth(*o).has_value();
      }
    }
    catch (const RawlogError& e)
    {
      return e.what();
    }
    return "";
  }

  void tellObjects(const RawlogStatistics& statistics)
  {
    say(Severity::Ok, std::to_string(statistics.objects) + " objects");
    for (const auto& [reason, count] : statistics.skipped)
    {
      const bool harmless = reason.ends_with("CActionCollection");
      say(harmless ? Severity::Ok : Severity::Warning,
          std::to_string(count) + " x " + reason + ": not used");
    }
  }

  void tellSensor(const std::string& name, const Sensor& s)
  {
    std::string text = name + ": " + std::to_string(s.count);
    if (s.count > 1)
      text += ", " + number(s.rate(), 1) + " Hz, " + number(s.last - s.first, 1) + " s";
    say(Severity::Ok, text);
    const double usual = median(s.intervals);
    if (s.largest_gap > std::max(kShortestGap, kGapFactor * usual))
      say(Severity::Warning, name + ": gap of " + number(s.largest_gap, 2) + " s, " +
                                 number(s.gap_at - s.first, 1) + " s after its first");
    if (s.backwards > 0)
      say(Severity::Warning, name + ": " + std::to_string(s.backwards) + " stamps run backwards");
    if (name.starts_with("CObservationIMU") && content_.imu > 0 && s.count > 10 &&
        s.rate() < kSlowImu)
    {
      slow_imu_ = true;
      say(Severity::Warning,
          name + ": " + number(s.rate(), 1) + " Hz is too slow to be integrated");
    }
  }

  void tellPoints()
  {
    if (content_.points_per_scan.empty()) return;
    const auto& n = content_.points_per_scan;
    say(Severity::Ok, std::to_string(n.size()) + " scans, points per scan: median " +
                          std::to_string(median(n)) + ", max " +
                          std::to_string(*std::max_element(n.begin(), n.end())));
    if (content_.empty > 0)
      say(Severity::Warning, std::to_string(content_.empty) + " scans without a single point");
  }

  void tellDropped()
  {
    for (const auto& [reason, count] : decoder_.dropped())
    {
      // Rays that met nothing are no defect; everything else may be one.
      const bool usual = reason == "zero range" || reason == "invalid 2-D range" ||
                         reason.ends_with("not understood");
      std::string text = "dropped: " + std::to_string(count) + " x " + reason;
      if (reason == "not finite" && content_.points + count > 0)
        text += " (" +
                number(100.0 * static_cast<double>(count) /
                           static_cast<double>(content_.points + count),
                       2) +
                " % of the points)";
      say(usual ? Severity::Ok : Severity::Warning, text);
    }
  }

  void tellVerdict()
  {
    const Content& c = content_;
    const bool fused = c.imu > 0 && !slow_imu_ && (c.fixes >= kFewFixes || c.velocities > 0);
    std::string pose = fused                  ? "GPS, velocity and IMU to fuse"
                       : c.poses > 0          ? "poses to follow"
                       : c.truth > 0          ? "ground truth only"
                       : c.fixes >= kFewFixes ? "GPS without a usable IMU"
                                              : "";
    if (c.volumetric > 0 && !pose.empty())
      say(Severity::Ok, "verdict: a flight: 3-D range data and " + pose);
    else if (c.volumetric > 0)
      say(Severity::Warning,
          "verdict: range data only: no pose source, so the replay maps from a standstill");
    else if (!pose.empty())
      say(Severity::Warning,
          "verdict: no 3-D range sensor: the replay gives the estimate alone (" + pose + ")");
    else if (c.planar > 0)
      say(Severity::Error, "verdict: no 3-D range sensor: a 2-D laser log is not a flight");
    else
      say(Severity::Error, "verdict: nothing that a replay can use");
  }

  ObservationDecoder decoder_{InputConfig()};
  std::map<std::string, Sensor> sensors_;
  Content content_;
  bool slow_imu_ = false;
  std::vector<Finding> findings_;
};
}  // namespace

std::vector<Finding> diagnoseRawlog(const std::filesystem::path& file)
{
  return Examination().run(file);
}

}  // namespace slalom::mrpt_io
