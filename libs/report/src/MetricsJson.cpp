// SPDX-License-Identifier: BSD-3-Clause
#include "MetricsJson.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace slalom::report::detail
{
namespace
{
using Json = nlohmann::ordered_json;

Json number(std::optional<double> value, double scale = 1.0)
{
  return value && std::isfinite(*value * scale) ? Json(*value * scale) : Json(nullptr);
}
Json count(std::optional<std::uint64_t> value)
{
  return value ? Json(*value) : Json(nullptr);
}
Json textOrNull(const std::string& text)
{
  return text.empty() ? Json(nullptr) : Json(text);
}

Json errorOf(const Distribution& d)
{
  return {{"mean", number(d.mean)}, {"p95", number(d.p95)}, {"max", number(d.max)}};
}

Json millisecondsOf(const Distribution& d)
{
  constexpr double kMs = 1e3;
  return {{"n", d.n},
          {"mean_ms", number(d.mean, kMs)},
          {"median_ms", number(d.median, kMs)},
          {"p95_ms", number(d.p95, kMs)},
          {"p99_ms", number(d.p99, kMs)},
          {"max_ms", number(d.max, kMs)}};
}

Json missesOf(const TimingMetrics& t)
{
  return {{"map", t.map_misses}, {"global", t.global_misses}, {"local", t.local_misses}};
}

Json timingOf(const TimingMetrics& t)
{
  return {{"estimate", millisecondsOf(t.estimate)}, {"map", millisecondsOf(t.map)},
          {"edt", millisecondsOf(t.edt)},           {"global", millisecondsOf(t.global)},
          {"local", millisecondsOf(t.local)},       {"cycle", millisecondsOf(t.cycle)},
          {"deadline_misses", missesOf(t)}};
}

Json planningOf(const PlanningMetrics& p)
{
  return {{"replans", p.replans},
          {"refined_ok", p.refined_ok},
          {"refined_failed", p.refined_failed},
          {"certified", p.certified},
          {"recoveries", p.recoveries},
          {"rescues", p.rescues},
          {"fallbacks", {{"shifted", p.shifted}, {"backup", p.backup}, {"brake", p.brake}}},
          {"time_without_verified_stop_s", p.time_without_verified_stop_s}};
}

Json safetyOf(const SafetyMetrics& s)
{
  return {{"gate", Json(s.gate)}, {"events", Json(s.events)}, {"most_movers", s.most_movers}};
}

Json inputOf(const RunInfo& info, const InputSummary& input)
{
  return {{"rawlog", textOrNull(info.rawlog)},
          {"sha256", textOrNull(info.rawlog_sha256)},
          {"duration_s", number(input.duration_s)},
          {"observations", Json(input.observations)},
          {"points_per_scan",
           {{"median", number(input.points_per_scan_median)},
            {"max", number(input.points_per_scan_max)}}},
          {"dropped", Json(input.dropped)}};
}

Json flightOf(const RunSummary& summary)
{
  const TrueFlight& f = *summary.flight;
  std::optional<double> ratio;
  if (summary.result.success && f.shortest_m && *f.shortest_m > 0.0)
    ratio = f.length_m / *f.shortest_m;
  return {{"duration_s", number(f.duration_s)},
          {"length_m", number(f.length_m)},
          {"straight_m", number(f.straight_m)},
          {"shortest_m", number(f.shortest_m)},
          {"stop_error_m", number(f.stop_error_m)},
          {"length_ratio", number(ratio)},
          {"goal_distance_m", number(f.goal_distance_m)},
          {"min_clearance_m", number(summary.min_true_clearance_m)},
          {"clearance_p05_m", number(f.clearance_p05_m)},
          {"min_mover_distance_m", number(f.min_mover_distance_m)},
          {"contacts", f.contacts},
          {"max_speed_mps", number(f.max_speed_mps)},
          {"max_acceleration_mps2", number(f.max_acceleration_mps2)},
          {"acceleration_effort_m2_s3", number(f.acceleration_effort_m2_s3)},
          {"jerk_effort_m2_s5", number(f.jerk_effort_m2_s5)},
          {"realtime_factor", number(summary.realtime_factor)}};
}

Json runOf(const FlightMetrics& m, const RunInfo& info, const RunSummary& summary)
{
  return {{"version", textOrNull(info.version)},
          {"build", textOrNull(info.build)},
          {"seed", count(info.seed)},
          {"method", textOrNull(info.method)},
          {"config_sha256", textOrNull(info.config_sha256)},
          {"decision_hash", textOrNull(m.decision_hash)},
          {"cycles", m.cycles},
          {"threads", info.threads},
          {"realtime_factor", number(summary.realtime_factor)}};
}
}  // namespace

std::string metricsJson(const FlightMetrics& m, const RunInfo& info, const RunSummary& summary)
{
  const RunResult& result = summary.result;
  Json json;
  json["schema_version"] = 1;
  json["result"] = {{"code", result.code}, {"name", result.name}, {"message", result.message}};
  json["success"] = result.success;
  json["goal_error_m"] = number(summary.goal_error_m ? summary.goal_error_m : m.goal_error_m);
  json["length_m"] = number(m.length_m);
  json["duration_s"] = number(m.duration_s);
  json["reference_length_m"] = number(m.reference_length_m);
  json["clearance"] = {{"min_true_m", number(summary.min_true_clearance_m)},
                       {"min_map_m", number(m.min_map_clearance_m)},
                       {"time_below_hard_s", number(m.time_below_hard_s)}};
  json["tracking"] = {{"vs_reference_m", errorOf(m.vs_reference_m)},
                      {"vs_setpoint_m", errorOf(m.vs_setpoint_m)},
                      {"estimate_error_m", errorOf(m.estimate_error_m)}};
  json["speed"] = {{"mean_mps", number(m.mean_speed_mps)},
                   {"max_mps", number(m.max_speed_mps)},
                   {"max_acc_mps2", number(m.max_acceleration_mps2)}};
  json["timing"] = timingOf(m.timing);
  json["planning"] = planningOf(m.planning);
  json["safety"] = safetyOf(m.safety);
  json["input"] = inputOf(info, summary.input);
  if (summary.flight) json["flight"] = flightOf(summary);
  json["run"] = runOf(m, info, summary);
  // A title or path that is not UTF-8 must not cost the user the numbers.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace slalom::report::detail
