// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "TrackingInputs.h"
#include "TrackingProgram.h"

namespace slalom::optim::detail
{
/// The reference: the same problem by Ipopt, with exact derivatives. Allocates.
template <int D>
class TrackingIpopt : public TrackingSolver<D>
{
 public:
  using Matrix = Eigen::Matrix<double, D, Eigen::Dynamic>;

  TrackingIpopt(const TrackingSolverConfig& config, int stage_count, int rows_per_stage);

  const TrackingSolution<D>& solve(const TrackingQp<D>& problem,
                                   const Eigen::Ref<const Matrix>& guess_inputs,
                                   const core::Deadline& deadline) override;

 private:
  [[nodiscard]] NlpPoint start(const TrackingQp<D>& problem) const;
  void takeForces(const TrackingQp<D>& problem, const NlpPoint& point);
  void run(const TrackingQp<D>& problem, const core::Deadline& deadline);

  int stages_, max_rows_;
  TrackingInputs<D> inputs_, clipper_;
  TrackingProgram<D> program_;
  IpoptSolver ipopt_;
  TrackingSolution<D> solution_;
};

extern template class TrackingIpopt<1>;
extern template class TrackingIpopt<3>;

}  // namespace slalom::optim::detail
