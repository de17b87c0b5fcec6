// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/report/FlightReport.h"

#include <array>
#include <cmath>
#include <exception>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <utility>

#include "CyclePicture.h"
#include "FlightLog.h"
#include "FlightPictures.h"
#include "Geometry2d.h"
#include "MapAccumulator.h"
#include "MetricsJson.h"
#include "RowFiles.h"

namespace slalom::report
{
namespace
{
/// Throws for the first value outside its range.
void check(const ReportConfig& config)
{
  const auto inRange = [](std::string_view name, double value, core::Range range)
  {
    if (value >= range.min && value <= range.max) return;
    throw std::invalid_argument("report." + std::string(name) + " = " + std::to_string(value) +
                                " is outside [" + std::to_string(range.min) + ", " +
                                std::to_string(range.max) + "]");
  };
  ReportConfig::fields(config, [&](std::string_view name, const auto& value, core::Range range,
                                   auto&&...) { inRange(name, double(value), range); });
}

void writePicture(const std::filesystem::path& path, const detail::Canvas& canvas)
{
  // Without a level OpenCV tries one filter per row instead of five: half the time, 3 % more bytes.
  const std::vector<int> fast = {cv::IMWRITE_PNG_STRATEGY, cv::IMWRITE_PNG_STRATEGY_DEFAULT};
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".png", canvas.pixels(), bytes, fast))
    throw OutputError(path, "cannot be encoded as PNG");
  writeFileAtomically(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

std::string pictureName(std::uint64_t index)
{
  const std::string digits = std::to_string(index);
  return std::string(digits.size() < 6 ? 6 - digits.size() : 0, '0') + digits + ".png";
}

/// Tries jobs one after the other; one that fails does not keep the next from being tried.
class Attempts
{
 public:
  template <class Job>
  void run(Job&& job)
  {
    try
    {
      job();
    }
    catch (...)
    {
      if (!first_) first_ = std::current_exception();
    }
  }
  void rethrowFirst() const
  {
    if (first_) std::rethrow_exception(first_);
  }

 private:
  std::exception_ptr first_;
};

/// Renames the file into place; after a failed write what there is of it.
void complete(AtomicFile& file)
{
  try
  {
    file.commit();
  }
  catch (const OutputError&)
  {
    file.commitWholeLines();
    throw;
  }
}

constexpr std::string_view kCycleColumns =
    "t,index,status,fallback,reason,x_m,y_m,z_m,yaw_rad,vx_mps,vy_mps,vz_mps,progress_s,pace,"
    "distance_to_goal_m,clearance_m,error_reference_m,refinement_ran,refinement,refinement_reason,"
    "certified,certificate_margin_m,stop_excess,goal,goal_short_m,"
    "occupied_segments,polyhedra,refined_clearance_m,global_termination,global_iterations,"
    "nmpc_termination,nmpc_iterations,nmpc_cost,nmpc_residual,cmd_vx_mps,cmd_vy_mps,cmd_vz_mps,"
    "cmd_wz_radps,gate,gate_stop_margin_m,events,movers,local_offset_m,map_sequence,reference_"
    "sequence,decision_hash\n";
}  // namespace

struct FlightReport::Impl
{
  ReportConfig config;
  std::filesystem::path folder;
  RunInfo info;
  detail::FlightLog log;
  detail::MapAccumulator map;
  AtomicFile cycles, commands, timing;
  detail::TumWriter estimate, reference, refined, setpoints, truth;
  double next_picture_t = -std::numeric_limits<double>::infinity();
  double next_flush_t = -std::numeric_limits<double>::infinity();
  bool finished = false;

  Impl(const ReportConfig& c, std::filesystem::path f, RunInfo i)
      : config(c),
        folder(std::move(f)),
        info(std::move(i)),
        log(info),
        cycles(folder / "cycles.csv"),
        commands(folder / "commands.csv"),
        timing(folder / "timing.csv"),
        estimate(folder / "estimate.tum", info.epoch_s),
        reference(folder / "reference.tum", info.epoch_s),
        refined(folder / "refined.tum", info.epoch_s),
        setpoints(folder / "setpoints.tum", info.epoch_s),
        truth(folder / "truth.tum", info.epoch_s)
  {
    cycles.write(kCycleColumns);
    commands.write("t,vx,vy,vz,wz\n");
    timing.write("t,estimate_ms,map_ms,edt_ms,global_ms,local_ms,cycle_ms\n");
  }

  void writeCycleRow(const core::CycleRecord& record, const detail::CycleSummary& summary);
  void writeCommandRow(const core::CycleRecord& record);
  void writeTimingRow(const core::CycleRecord& record);
  void writePoses(const core::CycleRecord& record);
  void drawCycle(const core::CycleRecord& record);
  /// Once per second of the log: a process that dies takes no more than that with it.
  void flushRows(double t);
  [[nodiscard]] std::array<AtomicFile*, 8> rowFiles()
  {
    return {&cycles,         &commands,     &timing,         &estimate.file,
            &reference.file, &refined.file, &setpoints.file, &truth.file};
  }
};

FlightReport::FlightReport(const ReportConfig& config, std::filesystem::path folder, RunInfo info)
{
  check(config);
  // Drawing is rare and short: no pool of threads beside those of the engine.
  cv::setNumThreads(1);
  impl_ = std::make_unique<Impl>(config, std::move(folder), std::move(info));
  if (!impl_->info.effective_ini.empty())
    writeFileAtomically(impl_->folder / "effective.ini", impl_->info.effective_ini);
}
FlightReport::~FlightReport() = default;
FlightReport::FlightReport(FlightReport&&) noexcept = default;

void FlightReport::Impl::writeCycleRow(const core::CycleRecord& r, const detail::CycleSummary& s)
{
  const core::VehicleState& state = r.state;
  detail::CsvRow row;
  row.number(r.t, 6).integer(r.index).text(r.status).text(r.fallback).text(r.reason);
  const auto known = [&](double value) { return r.has_state ? value : detail::kNone; };
  for (int axis = 0; axis < 3; ++axis) row.number(known(state.p_W[axis]), 6);
  row.number(known(state.yaw()), 6);
  for (int axis = 0; axis < 3; ++axis) row.number(known(state.v_W[axis]), 6);
  const bool mission = r.reference.cols() > 0;
  row.number(mission ? r.progress_s : detail::kNone, 6);
  row.number(mission ? r.pace : detail::kNone, 6);
  row.number(mission ? r.distance_to_goal_m : detail::kNone, 6);
  row.number(s.clearance_m, 6).number(s.vs_reference_m, 6);
  row.integer(r.refinement.ran ? 1 : 0).text(r.refinement.outcome);
  row.text(r.refinement.reason).integer(r.refinement.certified ? 1 : 0);
  row.number(r.refinement.certified ? r.refinement.certificate_margin_m : detail::kNone, 6);
  row.number(r.refinement.stop_excess, 6);
  row.text(r.refinement.goal).number(mission ? r.refinement.goal_short_m : detail::kNone, 6);
  row.integer(r.refinement.occupied_segments.size()).integer(r.refinement.polyhedra.size());
  row.number(r.refinement.outcome.empty() ? detail::kNone : r.refinement.min_clearance_m, 6);
  row.text(core::toString(r.refinement.solve.termination));
  row.integer(static_cast<std::uint64_t>(std::max(0, r.refinement.solve.iterations)));
  row.text(core::toString(r.nmpc.termination));
  row.integer(static_cast<std::uint64_t>(std::max(0, r.nmpc.iterations)));
  row.number(r.nmpc.cost, 6).number(r.nmpc.primal_residual, 9);
  for (int axis = 0; axis < 3; ++axis) row.number(r.command.v_W[axis], 6);
  row.number(r.command.yaw_rate, 6);
  std::string news;
  for (const core::Event& event : r.events) news += (news.empty() ? "" : " ") + event.name;
  row.text(r.gate.intervention).number(r.gate.stop_margin_m, 6).text(news);
  row.integer(r.movers.size()).number(r.origin_offset_norm_m, 6);
  row.integer(r.map_sequence).integer(r.reference_sequence).text(detail::hexOf(r.decision_hash));
  cycles.write(row.line());
}

void FlightReport::Impl::writeCommandRow(const core::CycleRecord& r)
{
  detail::CsvRow command;
  command.number(r.t, 6);
  for (int axis = 0; axis < 3; ++axis) command.number(r.command.v_W[axis], 6);
  commands.write(command.number(r.command.yaw_rate, 6).line());
}

void FlightReport::Impl::writeTimingRow(const core::CycleRecord& r)
{
  detail::CsvRow spent;
  spent.number(r.t, 6);
  for (const double seconds : {r.timing.estimate, r.timing.map, r.timing.edt, r.timing.global,
                               r.timing.local, r.timing.cycle})
    spent.number(1e3 * seconds, 4);
  timing.write(spent.line());
}

void FlightReport::Impl::writePoses(const core::CycleRecord& r)
{
  if (!r.has_state) return;
  estimate.write({r.state.t, r.state.p_W, r.state.q_WB});
  const Eigen::Vector3d to_world = r.state.p_W - r.state.p_L;
  const auto pose = [&](double t, const Eigen::Vector3d& p_L, double yaw) {
    return core::TimedPose{t, p_L + to_world, core::fromYaw(yaw)};
  };
  if (r.reference.cols() > 0)
    reference.write(
        pose(r.t, r.reference_point_L, detail::headingAt(r.reference, r.reference_point_L)));
  if (r.refined.cols() > 0)
    refined.write(pose(r.t, r.refined_point_L, detail::headingAt(r.refined, r.refined_point_L)));
  if (r.horizon.cols() > 0)
    setpoints.write(pose(r.t + info.setpoint_lead_s, r.setpoint_L, r.setpoint_yaw));
}

void FlightReport::Impl::drawCycle(const core::CycleRecord& record)
{
  if (config.picture_interval_s <= 0.0 || record.t < next_picture_t - 1e-9) return;
  // On the grid of the interval, so that a late cycle does not shift all later pictures.
  next_picture_t =
      config.picture_interval_s * (std::floor(record.t / config.picture_interval_s + 1e-9) + 1.0);
  std::error_code error;
  std::filesystem::create_directories(folder / "cycles", error);
  if (error) throw OutputError(folder / "cycles", "cannot be created", error.value());
  writePicture(folder / "cycles" / pictureName(record.index),
               detail::drawCyclePicture({record, log.cycles(), info, config}));
}

void FlightReport::Impl::flushRows(double t)
{
  if (t < next_flush_t) return;
  next_flush_t = t + 1.0;
  Attempts attempts;
  for (AtomicFile* file : rowFiles()) attempts.run([&] { file->flush(); });
  attempts.rethrowFirst();
}

void FlightReport::add(const core::CycleRecord& record)
{
  const detail::CycleSummary summary = impl_->log.add(record);
  if (record.has_state) impl_->map.add(record.field, record.t, record.state.p_L);
  Attempts attempts;
  attempts.run([&] { impl_->writeCycleRow(record, summary); });
  attempts.run([&] { impl_->writeCommandRow(record); });
  attempts.run([&] { impl_->writeTimingRow(record); });
  attempts.run([&] { impl_->writePoses(record); });
  attempts.run([&] { impl_->drawCycle(record); });
  attempts.run([&] { impl_->flushRows(record.t); });
  attempts.rethrowFirst();
}

void FlightReport::addTruth(const core::TimedPose& pose_W)
{
  impl_->log.addTruth(pose_W.t, pose_W.position);
  impl_->truth.write(pose_W);
}

void FlightReport::finish(const RunSummary& summary)
{
  if (impl_->finished) return;
  impl_->finished = true;
  const std::filesystem::path& folder = impl_->folder;
  const FlightMetrics numbers = impl_->log.metrics();
  const detail::FlightView view{impl_->log, numbers, impl_->map, impl_->info, summary};
  Attempts attempts;
  for (AtomicFile* file : impl_->rowFiles()) attempts.run([&] { complete(*file); });
  attempts.run(
      [&]
      {
        writeFileAtomically(folder / "metrics.json",
                            detail::metricsJson(numbers, impl_->info, summary));
      });
  impl_->map.finish();
  attempts.run([&] { writePicture(folder / "overview.png", detail::drawOverview(view)); });
  attempts.run([&] { writePicture(folder / "tracking.png", detail::drawTracking(view)); });
  attempts.run([&] { writePicture(folder / "timing.png", detail::drawTiming(view)); });
  attempts.rethrowFirst();
}

FlightMetrics FlightReport::metrics() const
{
  return impl_->log.metrics();
}

std::size_t FlightReport::memoryBytes() const
{
  return impl_->log.memoryBytes() + impl_->map.memoryBytes();
}

}  // namespace slalom::report
