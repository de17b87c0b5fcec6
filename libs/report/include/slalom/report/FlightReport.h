// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>

#include "slalom/core/CycleRecord.h"
#include "slalom/report/AtomicFile.h"
#include "slalom/report/FlightMetrics.h"
#include "slalom/report/ReportConfig.h"
#include "slalom/report/RunInfo.h"

namespace slalom::report
{
/** The report of one flight, written while it is flown.
 *
 *  Legal order: construct, (add | addTruth)*, finish. Every cycle goes straight to the row files;
 * of a cycle only a summary of fixed size is kept, so memory does not depend on maps or horizons.
 *
 *  Rows: cycles.csv, commands.csv, timing.csv; estimate, reference, refined, setpoints and
 * truth.tum. All TUM files are in the world frame: local positions are shifted by the estimate's
 * own p_W - p_L of that cycle. Their stamps rise strictly (a row that would repeat a stamp is left
 * out). Wall times appear in timing.csv, timing.png and metrics.json only: every other file is
 * byte-identical for equal records.
 *
 *  Not thread-safe: one caller. */
class FlightReport
{
 public:
  /** Opens the files; `folder` exists (prepareOutputFolder()).
   *  @throws OutputError; std::invalid_argument when a config value is out of its range */
  FlightReport(const ReportConfig& config, std::filesystem::path folder, RunInfo info);
  ~FlightReport();  ///< without finish(): the rows stay in NAME.part
  FlightReport(FlightReport&&) noexcept;

  /// The next cycle. @throws OutputError; the flight may go on, finish() keeps what was written.
  void add(const core::CycleRecord& record);

  /// Ground truth, world frame, times rising; may come before or after the cycles of its time.
  /// @throws OutputError
  void addTruth(const core::TimedPose& pose_W);

  /** Completes every file from what was seen so far; may come after an error, after Ctrl-C, after
   * no cycle at all. Each file is tried, then the first failure is thrown. A second call does
   * nothing. @throws OutputError */
  void finish(const RunSummary& summary);

  /// Numbers over the cycles seen so far.
  [[nodiscard]] FlightMetrics metrics() const;

  /// What the report holds in memory that grows with the flight [bytes].
  [[nodiscard]] std::size_t memoryBytes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slalom::report
