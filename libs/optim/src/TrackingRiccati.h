// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "TrackingInputs.h"
#include "TrackingWork.h"
#include "slalom/optim/TrackingQp.h"

namespace slalom::optim::detail
{
/** Primal-dual interior point (Mehrotra's predictor and corrector) whose Newton step is a Riccati
 *  recursion along the stages. The iterate always keeps the dynamics and, strictly, all limits;
 *  the slacks of the rows are eliminated by hand. Allocates in the constructor only. */
template <int D>
class TrackingRiccati : public TrackingSolver<D>
{
 public:
  using Matrix = Eigen::Matrix<double, D, Eigen::Dynamic>;

  TrackingRiccati(const TrackingSolverConfig& config, int stage_count, int rows_per_stage,
                  InstructionSet set = bestInstructionSet());

  const TrackingSolution<D>& solve(const TrackingQp<D>& problem,
                                   const Eigen::Ref<const Matrix>& guess_inputs,
                                   const core::Deadline& deadline) override;

 private:
  void load(const TrackingQp<D>& problem);
  double startAt(double inwards);
  void start();
  core::Termination iterate(const core::Deadline& deadline);
  bool optimal();
  void help(int iteration);
  void takeIterate(const TrackingQp<D>& problem);
  void takeGuess(const TrackingQp<D>& problem);
  static const char* name(core::Termination termination);  // no message may need memory
  [[nodiscard]] int stages() const { return static_cast<int>(work_.nodes.size()); }
  void finish(const TrackingQp<D>& problem, core::Termination termination);

  TrackingSolverConfig config_;
  int max_rows_;
  InstructionSet set_;
  TrackingSteps<D> steps_;
  TrackingInputs<D> inputs_;
  TrackingWork<D> work_;
  TrackingSolution<D> solution_;
};

extern template class TrackingRiccati<1>;
extern template class TrackingRiccati<3>;

}  // namespace slalom::optim::detail
