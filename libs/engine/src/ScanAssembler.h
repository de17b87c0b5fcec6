// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <map>
#include <string>
#include <vector>

#include "Pipeline.h"
#include "StateSource.h"
#include "slalom/core/PointCloud.h"

namespace slalom::engine
{
/// Holds scans until the path of the vehicle during them is known, then turns them into
/// motion-compensated rays.
class ScanAssembler
{
 public:
  explicit ScanAssembler(const mapping::MapperConfig& config) : config_(config) {}

  void add(core::RangeScan scan) { pending_.push_back(std::move(scan)); }

  /** Scans that are ready at log time `now`, in order of arrival. A scan whose end the estimate
   * does not reach within a quarter of a second is dropped and counted. */
  [[nodiscard]] std::vector<MapJob> take(const StateSource& source, double now,
                                         std::map<std::string, std::uint64_t>& dropped);

 private:
  [[nodiscard]] bool believesSilence(const core::RangeScan& scan) const;

  mapping::MapperConfig config_;
  std::deque<core::RangeScan> pending_;
};

}  // namespace slalom::engine
