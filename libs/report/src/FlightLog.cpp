// SPDX-License-Identifier: BSD-3-Clause
#include "FlightLog.h"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace slalom::report::detail
{
namespace
{
// Neighbours further apart than this say nothing about the moment between them.
constexpr double kMaxGapS = 0.5;
constexpr double kTimeTolerance = 1e-6;
constexpr double kTruthPathStepM = 0.1;

// Two cycles of the same stamp have no rate of change.
constexpr double kShortestStepS = 1e-4;
}  // namespace

FallbackKind fallbackKind(std::string_view name)
{
  std::string lower(name);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (lower.empty() || lower == "none") return FallbackKind::None;
  if (lower.starts_with("shift")) return FallbackKind::Shifted;
  if (lower.starts_with("committed") || lower.starts_with("backup")) return FallbackKind::Backup;
  if (lower.starts_with("brak")) return FallbackKind::Brake;
  return FallbackKind::Other;
}

double lengthOf(const core::Polyline& line)
{
  double length = 0.0;
  for (Eigen::Index i = 1; i < line.cols(); ++i) length += (line.col(i) - line.col(i - 1)).norm();
  return length;
}

double clearanceOf(const core::CycleRecord& record)
{
  if (!record.field || !record.state.p_L.allFinite()) return kNone;
  return record.field->distance(record.state.p_L, core::UnknownAs::Free).value_or(kNone);
}

void FlightLog::addMotion(const core::CycleRecord& record, CycleSummary& now)
{
  now.p_L = record.state.p_L;
  now.speed_mps = record.state.v_W.norm();
  now.clearance_m = clearanceOf(record);
  // Before the first estimate the last position is NaN, and so is the step.
  if (!cycles_.empty())
  {
    const CycleSummary& before = cycles_.back();
    const double step = (now.p_L - before.p_L).norm(), dt = now.t - before.t;
    if (std::isfinite(step)) length_m_ += step;
    if (std::isfinite(step) && dt > kShortestStepS)
      max_acceleration_mps2_ =
          std::fmax(max_acceleration_mps2_, (record.state.v_W - last_velocity_W_).norm() / dt);
  }
  last_velocity_W_ = record.state.v_W;
}

void FlightLog::addMission(const core::CycleRecord& record, CycleSummary& now)
{
  reference_L_ = record.reference;
  distance_to_goal_m_ = record.distance_to_goal_m;
  now.reference_z = record.reference_point_L.z();
  now.vs_reference_m = (record.state.p_L - record.reference_point_L).norm();
  if (record.refined.cols() == 0) return;
  now.refined_L = record.refined_point_L;
  now.detour_m = (record.refined_point_L - record.reference_point_L).norm();
}

const CycleSummary& FlightLog::add(const core::CycleRecord& record)
{
  CycleSummary now;
  now.t = record.t;
  now.commanded_speed_mps = record.command.v_W.norm();
  now.timing = record.timing;
  now.fallback = fallbackKind(record.fallback);
  if (record.has_state) addMotion(record, now);
  if (record.has_state && record.reference.cols() > 0) addMission(record, now);
  cycles_.push_back(now);
  countPlanning(record);
  decision_hash_ = record.decision_hash;

  matchSetpoints();
  if (record.horizon.cols() > 0)
    open_setpoints_.push_back({record.t + info_.setpoint_lead_s, record.setpoint_L});
  if (record.has_state)
    open_estimates_.push_back({record.state.t, record.state.p_W, cycles_.size() - 1,
                               record.state.p_L - record.state.p_W});
  matchTruth();
  return cycles_.back();
}

void FlightLog::addTruth(double t, const Eigen::Vector3d& p_W)
{
  if (!std::isfinite(t) || !p_W.allFinite()) return;
  if (!truth_.empty() && t <= truth_.back().t) return;
  truth_.push_back({t, p_W});
  matchTruth();
}

void FlightLog::countPlanning(const core::CycleRecord& record)
{
  if (!record.verified_stop && cycles_.size() > 1)
    planning_.time_without_verified_stop_s += record.t - cycles_[cycles_.size() - 2].t;
  if (record.refinement.ran)
  {
    const std::string& outcome = record.refinement.outcome;
    ++planning_.replans;
    if (record.refinement.certified) ++planning_.certified;
    if (!record.verified_stop && record.refinement.stop_excess > 0.01) ++planning_.rescues;
    if (outcome == "Recovered") ++planning_.recoveries;
    if (outcome == "Clear" || outcome == "Refined" || outcome == "Recovered")
      ++planning_.refined_ok;
    else
      ++planning_.refined_failed;
  }
  if (!record.gate.intervention.empty()) ++safety_.gate[record.gate.intervention];
  for (const core::Event& event : record.events) ++safety_.events[event.name];
  safety_.most_movers = std::max<std::uint64_t>(safety_.most_movers, record.movers.size());
  switch (fallbackKind(record.fallback))
  {
    case FallbackKind::Shifted:
      ++planning_.shifted;
      break;
    case FallbackKind::Backup:
      ++planning_.backup;
      break;
    case FallbackKind::Brake:
      ++planning_.brake;
      break;
    default:
      break;
  }
}

void FlightLog::matchSetpoints()
{
  if (cycles_.size() < 2) return;
  CycleSummary& now = cycles_.back();
  const CycleSummary& before = cycles_[cycles_.size() - 2];
  while (!open_setpoints_.empty() && open_setpoints_.front().t <= now.t + kTimeTolerance)
  {
    const Timed setpoint = open_setpoints_.front();
    open_setpoints_.pop_front();
    const double dt = now.t - before.t;
    if (dt > kMaxGapS || setpoint.t < before.t - kTimeTolerance) continue;
    const double share =
        dt > kShortestStepS ? std::clamp((setpoint.t - before.t) / dt, 0.0, 1.0) : 1.0;
    const Eigen::Vector3d flown = before.p_L + share * (now.p_L - before.p_L);
    now.vs_setpoint_m = (flown - setpoint.p).norm();
  }
}

void FlightLog::matchTruth()
{
  while (!open_estimates_.empty() && !truth_.empty() &&
         open_estimates_.front().t <= truth_.back().t)
  {
    const Timed estimate = open_estimates_.front();
    open_estimates_.pop_front();
    while (truth_.size() >= 2 && truth_[1].t <= estimate.t) truth_.pop_front();
    const Timed& a = truth_.front();
    if (a.t > estimate.t) continue;  // the estimate is older than all truth
    const Timed& b = truth_.size() >= 2 ? truth_[1] : a;
    const double gap = b.t - a.t;
    if (gap > kMaxGapS) continue;
    const double share = gap > 0.0 ? (estimate.t - a.t) / gap : 0.0;
    const Eigen::Vector3d truth_W = a.p + share * (b.p - a.p);
    cycles_[estimate.cycle].estimate_error_m = (estimate.p - truth_W).norm();
    const Eigen::Vector3d truth_L = truth_W + estimate.offset;
    if (truth_path_L_.empty() || (truth_L - truth_path_L_.back()).norm() >= kTruthPathStepM)
      truth_path_L_.push_back(truth_L);
  }
  // One of the two may never come: keep only what a late start could still use.
  constexpr std::size_t kMaxOpen = 20000;
  if (open_estimates_.size() > kMaxOpen) open_estimates_.pop_front();
  if (truth_.size() > kMaxOpen) truth_.pop_front();
}

FlightMetrics FlightLog::metrics() const
{
  FlightMetrics m = computeMetrics(cycles_, info_);
  m.length_m = length_m_;
  if (std::isfinite(max_acceleration_mps2_)) m.max_acceleration_mps2 = max_acceleration_mps2_;
  if (reference_L_.cols() > 0) m.reference_length_m = lengthOf(reference_L_);
  if (std::isfinite(distance_to_goal_m_)) m.goal_error_m = distance_to_goal_m_;
  m.planning = planning_;
  m.safety = safety_;
  if (!cycles_.empty()) m.decision_hash = hexOf(decision_hash_);
  return m;
}

std::size_t FlightLog::memoryBytes() const
{
  return cycles_.capacity() * sizeof(CycleSummary) +
         (open_setpoints_.size() + open_estimates_.size() + truth_.size()) * sizeof(Timed) +
         truth_path_L_.capacity() * sizeof(Eigen::Vector3d) +
         static_cast<std::size_t>(reference_L_.size()) * sizeof(double);
}

}  // namespace slalom::report::detail
