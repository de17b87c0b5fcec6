// SPDX-License-Identifier: BSD-3-Clause
#include "Figures.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>

#include "slalom/core/TextTable.h"

namespace slalom::experiment
{
namespace
{
namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr double kWindow = 3.0;  // [s] of R around a sample's time

struct JsonFigure
{
  const char *name, *pointer;
};
constexpr std::array kOfMetrics{JsonFigure{"length_m", "/flight/length_m"},
                                JsonFigure{"duration_s", "/flight/duration_s"},
                                JsonFigure{"straight_m", "/flight/straight_m"},
                                JsonFigure{"shortest_m", "/flight/shortest_m"},
                                JsonFigure{"ratio", "/flight/length_ratio"},
                                JsonFigure{"clearance_m", "/flight/min_clearance_m"},
                                JsonFigure{"contacts", "/flight/contacts"},
                                JsonFigure{"mover_distance_m", "/flight/min_mover_distance_m"},
                                JsonFigure{"goal_error_m", "/goal_error_m"},
                                JsonFigure{"stop_error_m", "/flight/stop_error_m"},
                                JsonFigure{"reference_m", "/reference_length_m"},
                                JsonFigure{"max_speed_mps", "/flight/max_speed_mps"},
                                JsonFigure{"realtime_factor", "/run/realtime_factor"},
                                JsonFigure{"estimate_mean_m", "/tracking/estimate_error_m/mean"},
                                JsonFigure{"estimate_max_m", "/tracking/estimate_error_m/max"},
                                JsonFigure{"map_ms", "/timing/map/mean_ms"},
                                JsonFigure{"edt_ms", "/timing/edt/mean_ms"},
                                JsonFigure{"planning_ms", "/timing/global/mean_ms"},
                                JsonFigure{"planning_median_ms", "/timing/global/median_ms"},
                                JsonFigure{"planning_p99_ms", "/timing/global/p99_ms"},
                                JsonFigure{"local_ms", "/timing/local/mean_ms"},
                                JsonFigure{"local_p99_ms", "/timing/local/p99_ms"},
                                JsonFigure{"local_ticks", "/timing/local/n"},
                                JsonFigure{"cycle_ms", "/timing/cycle/mean_ms"},
                                JsonFigure{"cycle_p99_ms", "/timing/cycle/p99_ms"},
                                JsonFigure{"replans", "/planning/replans"},
                                JsonFigure{"refined_failed", "/planning/refined_failed"},
                                JsonFigure{"rescues", "/planning/rescues"},
                                JsonFigure{"brakes", "/planning/fallbacks/brake"}};
constexpr std::array kDerived{
    "success",        "expected",       "mapping_ms",      "misses",      "miss_share",
    "detour",         "r_mean_m",       "r_p95_m",         "r_max_m",     "setpoint_mean_m",
    "setpoint_p95_m", "setpoint_max_m", "final_speed_mps", "cycle_ratio", "memory_max_mb",
    "memory_ratio",   "wall_s"};

Json parsed(const fs::path& file)
{
  std::ifstream stream(file);
  Json json = Json::parse(stream, nullptr, false);
  if (!json.is_object()) throw std::runtime_error(file.string() + ": not a JSON object");
  return json;
}

std::optional<double> numberAt(const Json& json, const char* pointer)
{
  const Json::json_pointer place(pointer);
  if (!json.contains(place) || !json.at(place).is_number()) return std::nullopt;
  return json.at(place).get<double>();
}

std::string textAt(const Json& json, const char* pointer)
{
  const Json::json_pointer place(pointer);
  return json.contains(place) && json.at(place).is_string() ? json.at(place).get<std::string>()
                                                            : std::string();
}

class Reader
{
 public:
  explicit Reader(const PlannedFlight& planned) : folder_(planned.folder)
  {
    flight_.planned = planned;
    metrics_ = parsed(folder_ / "metrics.json");
  }

  FlownFlight read(const FlightRecord& record, const std::vector<std::string>& expected,
                   std::optional<double> shortest)
  {
    flight_.flown = true;
    flight_.result = textAt(metrics_, "/result/name");
    flight_.message = textAt(metrics_, "/result/message");
    for (const auto& [name, pointer] : kOfMetrics) set(name, numberAt(metrics_, pointer));
    set("wall_s", record.wall_s);
    outcome(expected);
    lengths(shortest);
    timing();
    tracking();
    course();
    return std::move(flight_);
  }

 private:
  void set(const std::string& name, std::optional<double> value)
  {
    if (value) flight_.figures[name] = *value;
  }
  [[nodiscard]] std::optional<double> get(const char* name) const { return flight_.figure(name); }

  void outcome(const std::vector<std::string>& expected)
  {
    const bool contact = get("contacts").value_or(1.0) > 0.0;
    const bool good = metrics_.value("success", false);
    const bool as_expected =
        std::find(expected.begin(), expected.end(), flight_.result) != expected.end();
    set("success", good && !contact);
    set("expected", as_expected && !contact);
  }

  void lengths(std::optional<double> shortest)
  {
    if (shortest) set("shortest_m", shortest);
    const auto length = get("length_m"), best = get("shortest_m"), r = get("reference_m");
    // Half a way is not a short one.
    const bool arrived = get("success").value_or(0.0) > 0.5;
    if (arrived && length && best && *best > 0.0) set("ratio", *length / *best);
    if (length && r && *r > 0.0) set("detour", *length / *r);
  }

  void timing()
  {
    if (const auto map = get("map_ms"), edt = get("edt_ms"); map && edt)
      set("mapping_ms", *map + *edt);
    double misses = 0.0, chances = 0.0;
    for (const char* part : {"map", "global", "local"})
    {
      const std::string base = "/timing/";
      const auto missed = numberAt(metrics_, (base + "deadline_misses/" + part).c_str());
      const auto n = numberAt(metrics_, (base + part + "/n").c_str());
      if (!missed || !n) return;
      misses += *missed;
      chances += *n;
    }
    set("misses", misses);
    if (chances > 0.0) set("miss_share", misses / chances);
  }

  void errors(const std::string& prefix, std::vector<double> samples)
  {
    const auto e = errorFigures(std::move(samples));
    if (!e) return;
    set(prefix + "_mean_m", e->mean);
    set(prefix + "_p95_m", e->p95);
    set(prefix + "_max_m", e->max);
  }

  void tracking()
  {
    const Path truth = readPath(folder_ / "truth.tum");
    if (truth.t.size() < 2) return;
    errors("r", distancesToLine(truth, readPath(folder_ / "reference.tum"), kWindow));
    errors("setpoint", distancesInTime(truth, readPath(folder_ / "setpoints.tum")));
    // Over the last half second: it has to stay at rest, not to pass through it.
    std::size_t before = truth.t.size() - 1;
    while (before > 0 && truth.t.back() - truth.t[before] < 0.5) --before;
    const double span = truth.t.back() - truth.t[before];
    if (span > 0.0)
      set("final_speed_mps", (truth.points.back() - truth.points[before]).norm() / span);
  }

  /// A column of a file with a header.
  [[nodiscard]] std::vector<double> column(const char* file, const char* name) const
  {
    std::vector<double> values;
    const fs::path path = folder_ / file;
    if (!fs::exists(path)) return values;
    const auto rows = core::readRows(path, ',');
    if (rows.empty()) return values;
    const auto& header = rows.front().fields;
    const auto found = std::find(header.begin(), header.end(), name);
    if (found == header.end()) return values;
    const auto index = static_cast<std::size_t>(found - header.begin());
    for (std::size_t i = 1; i < rows.size(); ++i)
      values.push_back(core::numberAt(path, rows[i], index));
    return values;
  }

  /// Mean of one quarter (0 to 3) of the samples.
  static double quarter(const std::vector<double>& x, std::size_t which)
  {
    const auto at = [&](std::size_t q) { return x.begin() + std::ptrdiff_t(x.size() * q / 4); };
    return std::accumulate(at(which), at(which + 1), 0.0) /
           static_cast<double>(at(which + 1) - at(which));
  }

  /// What changes while it flies.
  void course()
  {
    constexpr std::size_t kFew = 8;
    if (const auto cycle = column("timing.csv", "cycle_ms"); cycle.size() >= kFew)
      if (const double first = quarter(cycle, 0); first > 0.0)
        set("cycle_ratio", quarter(cycle, 3) / first);
    const auto memory = column("memory.csv", "rss_mb");
    if (memory.empty()) return;
    set("memory_max_mb", *std::max_element(memory.begin(), memory.end()));
    // The first quarter loads and fills what later stays.
    if (memory.size() >= kFew && quarter(memory, 1) > 0.0)
      set("memory_ratio", quarter(memory, 3) / quarter(memory, 1));
  }

  fs::path folder_;
  Json metrics_;
  FlownFlight flight_;
};
}  // namespace

const std::vector<std::string>& figureNames()
{
  static const std::vector<std::string> names = []
  {
    std::vector<std::string> all(kDerived.begin(), kDerived.end());
    for (const auto& figure : kOfMetrics) all.emplace_back(figure.name);
    std::sort(all.begin(), all.end());
    return all;
  }();
  return names;
}

std::optional<double> FlownFlight::figure(const std::string& name) const
{
  const auto found = figures.find(name);
  return found == figures.end() ? std::nullopt : std::optional(found->second);
}

FlownFlight readFlight(const PlannedFlight& planned, const FlightRecord& record,
                       const std::vector<std::string>& expected, std::optional<double> shortest)
{
  return Reader(planned).read(record, expected, shortest);
}

}  // namespace slalom::experiment
