// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string_view>

#include "slalom/core/CycleRecord.h"

namespace slalom::engine
{
/** Running FNV-1a hash over the bits of every decision: state, plan, command, status, never a wall
 * time. Two runs are equal up to cycle k exactly if their hashes are equal at k. */
class DecisionHash
{
 public:
  void add(const core::CycleRecord& cycle);
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  void bytes(const void* data, std::size_t size);
  void add(double number) { bytes(&number, sizeof number); }
  void add(std::string_view text) { bytes(text.data(), text.size()); }
  void add(const Eigen::Ref<const Eigen::MatrixXd>& numbers);

  std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

}  // namespace slalom::engine
