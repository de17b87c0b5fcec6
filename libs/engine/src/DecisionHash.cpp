// SPDX-License-Identifier: BSD-3-Clause
#include "DecisionHash.h"

namespace slalom::engine
{
void DecisionHash::bytes(const void* data, std::size_t size)
{
  const auto* p = static_cast<const unsigned char*>(data);
  for (std::size_t i = 0; i < size; ++i) value_ = (value_ ^ p[i]) * 0x100000001b3ULL;
}

void DecisionHash::add(const Eigen::Ref<const Eigen::MatrixXd>& numbers)
{
  for (Eigen::Index c = 0; c < numbers.cols(); ++c)
    for (Eigen::Index r = 0; r < numbers.rows(); ++r) add(numbers(r, c));
}

void DecisionHash::add(const core::CycleRecord& cycle)
{
  add(cycle.t);
  add(cycle.state.p_L);
  add(cycle.state.p_W);
  add(cycle.state.v_W);
  add(cycle.state.q_WB.coeffs());
  add(cycle.progress_s);
  add(cycle.refined);
  add(cycle.horizon);
  add(cycle.command.v_W);
  add(cycle.command.yaw_rate);
  add(cycle.status);
  add(cycle.fallback);
  add(cycle.reason);
}

}  // namespace slalom::engine
