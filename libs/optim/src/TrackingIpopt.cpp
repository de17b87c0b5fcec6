// SPDX-License-Identifier: BSD-3-Clause
#include "TrackingIpopt.h"

#include <chrono>

#include "TrackingOutcome.h"

namespace slalom::optim::detail
{
using core::Termination;

template <int D>
TrackingIpopt<D>::TrackingIpopt(const TrackingSolverConfig& config, int stage_count,
                                int rows_per_stage)
    : stages_(stage_count),
      max_rows_(rows_per_stage),
      inputs_(stage_count),
      clipper_(stage_count),
      program_(stage_count, rows_per_stage),
      ipopt_({.tolerance = config.tolerance,
              .max_iterations = config.max_iterations,
              .initial_barrier = 1e-2}),
      solution_(emptySolution<D>(stage_count, rows_per_stage))
{
}

template <int D>
NlpPoint TrackingIpopt<D>::start(const TrackingQp<D>& problem) const
{
  NlpPoint point;
  point.x.setZero(program_.variables());
  for (int k = 0; k < stages_; ++k)
  {
    point.x.segment<D>(program_.input(k)) = solution_.inputs.col(k);
    point.x.segment<D>(program_.position(k)) = solution_.positions.col(k);
    point.x.segment<D>(program_.velocity(k)) = solution_.velocities.col(k);
    for (int i = 0; i < problem.row_counts[static_cast<std::size_t>(k)]; ++i)
      point.x[program_.slack(k) + i] = std::max(0.0, violation<D>(problem, solution_, k, i));
  }
  return point;
}

template <int D>
void TrackingIpopt<D>::takeForces(const TrackingQp<D>& problem, const NlpPoint& point)
{
  clearForces(solution_);
  const Eigen::Index n = program_.variables();
  if (point.g_multipliers.size() != n || point.lower_multipliers.size() != n ||
      point.upper_multipliers.size() != n)
    return;
  for (int k = 0; k < stages_; ++k)
  {
    const int at = program_.input(k);
    solution_.input_forces.col(k) =
        point.upper_multipliers.segment<D>(at) - point.lower_multipliers.segment<D>(at);
    solution_.change_forces.col(k) = point.g_multipliers.segment<D>(at + 2 * D);
    for (int i = 0; i < problem.row_counts[static_cast<std::size_t>(k)]; ++i)
      solution_.row_forces[k * problem.max_rows + i] = -point.g_multipliers[program_.slack(k) + i];
  }
}

/// The limits hold at Ipopt's point up to its tolerance; here they are to hold exactly.
template <int D>
void TrackingIpopt<D>::run(const TrackingQp<D>& problem, const core::Deadline& deadline)
{
  solution_.inputs = inputs_.clipped;
  rollOut(problem, solution_);
  const double guess = trackingCost<D>(problem, inputs_.clipped);
  program_.set(problem, inputs_.low, inputs_.high);
  const NlpSolution found = ipopt_.solve(program_, start(problem), deadline);
  solution_.report = found.report;
  solution_.report.cost = guess;
  Matrix inputs(D, stages_);
  for (int k = 0; k < stages_; ++k)
    inputs.col(k) = found.point.x.template segment<D>(program_.input(k));
  clearForces(solution_);
  if (inputs.allFinite())
  {
    clipper_.prepare(problem, inputs);
    const double cost = trackingCost<D>(problem, clipper_.clipped);
    if (found.report.converged() || cost <= guess)
    {
      solution_.inputs = clipper_.clipped;
      solution_.report.cost = cost;
      rollOut(problem, solution_);
      takeForces(problem, found.point);
    }
  }
  solution_.report.dual_residual = trackingResiduals<D>(problem, solution_).dual();
  settleClash(inputs_.clash, solution_.report);
}

template <int D>
const TrackingSolution<D>& TrackingIpopt<D>::solve(const TrackingQp<D>& problem,
                                                   const Eigen::Ref<const Matrix>& guess_inputs,
                                                   const core::Deadline& deadline)
{
  const auto begin = std::chrono::steady_clock::now();
  if (const char* fault = faultOf<D>(problem, guess_inputs, stages_, max_rows_))
    refuse<D>(problem, guess_inputs, fault, solution_);
  else
  {
    inputs_.prepare(problem, guess_inputs);
    run(problem, deadline);
    solution_.worst_slack = worstSlack<D>(problem, solution_);
  }
  solution_.report.wall_time = std::chrono::steady_clock::now() - begin;
  return solution_;
}

template class TrackingIpopt<1>;
template class TrackingIpopt<3>;

}  // namespace slalom::optim::detail
