// SPDX-License-Identifier: BSD-3-Clause
#include "TrackingOutcome.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slalom::optim::detail
{
using core::Termination;

template <int D>
TrackingSolution<D> emptySolution(int stages, int max_rows)
{
  TrackingSolution<D> solution;
  for (auto* matrix : {&solution.positions, &solution.velocities, &solution.inputs,
                       &solution.input_forces, &solution.change_forces})
    matrix->setZero(D, stages);
  solution.row_forces.setZero(stages * max_rows);
  // Longer than any message of the solver that may not allocate.
  solution.report.message.reserve(64);
  return solution;
}

template <int D>
void clearForces(TrackingSolution<D>& solution)
{
  solution.input_forces.setZero();
  solution.change_forces.setZero();
  solution.row_forces.setZero();
}

template <int D>
void rollOut(const TrackingQp<D>& problem, TrackingSolution<D>& solution)
{
  typename TrackingStage<D>::Vector p = problem.p, v = problem.v;
  for (Eigen::Index k = 0; k < solution.inputs.cols(); ++k)
  {
    const TrackingStage<D>& stage = problem.stages[static_cast<std::size_t>(k)];
    const core::VelocityResponse& r = stage.response;
    p += r.p_v * v + r.p_u * solution.inputs.col(k) + stage.drift_p;
    v = r.v_v * v + r.v_u * solution.inputs.col(k) + stage.drift_v;
    solution.positions.col(k) = p;
    solution.velocities.col(k) = v;
  }
}

template <int D>
double worstSlack(const TrackingQp<D>& problem, const TrackingSolution<D>& solution)
{
  double worst = 0.0;
  for (Eigen::Index k = 0; k < solution.inputs.cols(); ++k)
    for (int i = 0; i < problem.row_counts[static_cast<std::size_t>(k)]; ++i)
      worst = std::max(worst, violation<D>(problem, solution, k, i));
  return worst;
}

template <int D>
void refuse(const TrackingQp<D>& problem,
            const Eigen::Ref<const Eigen::Matrix<double, D, Eigen::Dynamic>>& guess,
            const char* fault, TrackingSolution<D>& solution)
{
  const auto number = [](double x) { return std::isfinite(x) ? x : 0.0; };
  const auto clamp = [](double x, double middle, double reach)
  { return std::max(middle - reach, std::min(middle + reach, x)); };
  for (int i = 0; i < D; ++i)
  {
    double before = number(problem.u_before[i]);
    for (Eigen::Index k = 0; k < solution.inputs.cols(); ++k)
    {
      const auto stage = static_cast<std::size_t>(k);
      const bool known = stage < problem.stages.size();
      const double limit = known ? number(problem.stages[stage].input_limit[i]) : 0.0;
      const double change = known ? number(problem.stages[stage].change_limit[i]) : 0.0;
      const double wanted = k < guess.cols() ? number(guess(i, k)) : 0.0;
      before = clamp(clamp(wanted, before, std::abs(change)), 0.0, std::abs(limit));
      solution.inputs(i, k) = before;
    }
    solution.positions.row(i).setConstant(number(problem.p[i]));
  }
  solution.velocities.setZero();
  clearForces(solution);
  solution.worst_slack = 0.0;
  core::SolveReport& report = solution.report;
  report.termination = Termination::NumericalFailure;
  report.message = fault;
  report.iterations = 0;
  report.cost = std::numeric_limits<double>::quiet_NaN();
  report.primal_residual = report.dual_residual = std::numeric_limits<double>::infinity();
}

void settleClash(double clash, core::SolveReport& report)
{
  report.primal_residual = std::max(report.primal_residual, clash);
  if (!(clash > 0.0) || !report.converged()) return;
  report.termination = Termination::Infeasible;
  report.message = "limits clash";
}

template TrackingSolution<1> emptySolution<1>(int, int);
template TrackingSolution<3> emptySolution<3>(int, int);
template void clearForces<1>(TrackingSolution<1>&);
template void clearForces<3>(TrackingSolution<3>&);
template void rollOut<1>(const TrackingQp<1>&, TrackingSolution<1>&);
template void rollOut<3>(const TrackingQp<3>&, TrackingSolution<3>&);
template double worstSlack<1>(const TrackingQp<1>&, const TrackingSolution<1>&);
template double worstSlack<3>(const TrackingQp<3>&, const TrackingSolution<3>&);
template void refuse<1>(const TrackingQp<1>&,
                        const Eigen::Ref<const Eigen::Matrix<double, 1, Eigen::Dynamic>>&,
                        const char*, TrackingSolution<1>&);
template void refuse<3>(const TrackingQp<3>&,
                        const Eigen::Ref<const Eigen::Matrix<double, 3, Eigen::Dynamic>>&,
                        const char*, TrackingSolution<3>&);

}  // namespace slalom::optim::detail
