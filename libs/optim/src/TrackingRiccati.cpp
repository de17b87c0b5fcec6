// SPDX-License-Identifier: BSD-3-Clause
#include "TrackingRiccati.h"

#include <chrono>

#include "TrackingOutcome.h"

namespace slalom::optim::detail
{
namespace
{
using core::Termination;

constexpr int kLanes = 4;

// Tuned on closed loops and on wild random programs; the result does not depend on them.
constexpr double kSmallest = 1e-3;                         // barrier to look at a guess
constexpr double kMuOfScale = 0.02, kMuOfResidual = 0.03;  // barrier to begin with
constexpr double kLittle = 0.02, kFar = 0.15;              // of the way into the interior
constexpr int kPatience = 15;          // iterations; nearly all solves are over by then
constexpr double kLowBarrier = 300.0;  // ratio of residual to barrier
constexpr double kBad = 0.3;           // residual of a guess, of the scale

template <class Vector>
void put(Quad& quad, const Vector& vector, double factor = 1.0)
{
  for (Eigen::Index i = 0; i < vector.size(); ++i) quad.lane[i] = factor * vector[i];
}

template <int D>
void loadStage(const TrackingStage<D>& stage, TrackingNode<D>& node)
{
  node.p_v = stage.response.p_v;
  node.p_u = stage.response.p_u;
  node.v_v = stage.response.v_v;
  node.v_u = stage.response.v_u;
  node.velocity_weight = 2.0 * stage.velocity_weight;
  node.input_weight = 2.0 * stage.input_weight;
  node.change_weight = 2.0 * stage.change_weight;
  for (int j = 0; j < D; ++j) put(node.position_weight[j], stage.position_weight.col(j), 2.0);
  put(node.drift_p, stage.drift_p);
  put(node.drift_v, stage.drift_v);
  put(node.position, stage.position);
  put(node.velocity, stage.velocity);
  put(node.input, stage.input);
  put(node.change, stage.change);
  put(node.change_limit, stage.change_limit);
}

/// The lanes that are left over hold a row that is always true.
template <int D>
void loadRows(const SoftRow<D>* rows, int count, TrackingNode<D>& node, RowGroup<D>* groups)
{
  node.groups = (count + kLanes - 1) / kLanes;
  node.leads = false;
  const SoftRow<D> none{Eigen::Matrix<double, D, 1>::Zero(), 0.0, -1.0, 1.0};
  for (int i = 0; i < node.groups * kLanes; ++i)
  {
    const SoftRow<D>& row = i < count ? rows[i] : none;
    RowGroup<D>& group = groups[i / kLanes];
    const int lane = i % kLanes;
    for (int j = 0; j < D; ++j) group.normal[j].lane[lane] = row.normal[j];
    group.lead.lane[lane] = row.lead;
    group.offset.lane[lane] = row.offset;
    group.penalty.lane[lane] = row.penalty;
    node.leads = node.leads || row.lead != 0.0;
  }
}

}  // namespace

template <int D>
TrackingRiccati<D>::TrackingRiccati(const TrackingSolverConfig& config, int stage_count,
                                    int rows_per_stage, InstructionSet set)
    : config_(config),
      max_rows_(rows_per_stage),
      set_(set),
      steps_(trackingSteps<D>(set, true)),
      inputs_(stage_count),
      work_(stage_count, (rows_per_stage + kLanes - 1) / kLanes),
      solution_(emptySolution<D>(stage_count, rows_per_stage))
{
  // The lanes that no axis uses stay in the middle of a box.
  for (TrackingNode<D>& node : work_.nodes)
  {
    node.low.lane[3] = node.low.lane[2] = node.low.lane[1] = -1.0;
    node.high.lane[3] = node.high.lane[2] = node.high.lane[1] = 1.0;
    node.change_limit = node.high;
  }
}

template <int D>
void TrackingRiccati<D>::load(const TrackingQp<D>& problem)
{
  put(work_.p, problem.p);
  put(work_.v, problem.v);
  put(work_.u_before, problem.u_before);
  bool lag = false;
  double pairs = 0.0;
  for (std::size_t k = 0; k < work_.nodes.size(); ++k)
  {
    TrackingNode<D>& node = work_.nodes[k];
    loadStage(problem.stages[k], node);
    put(node.low, inputs_.low.col(static_cast<Eigen::Index>(k)));
    put(node.high, inputs_.high.col(static_cast<Eigen::Index>(k)));
    loadRows(problem.rows.data() + k * static_cast<std::size_t>(problem.max_rows),
             problem.row_counts[k], node,
             work_.rows.data() + k * static_cast<std::size_t>(work_.max_groups));
    lag = lag || node.p_v != 0.0 || node.v_v != 0.0;
    pairs += kLanes * (4.0 + 2.0 * node.groups);
  }
  work_.pairs = pairs;
  work_.damping = 1e-10;
  steps_ = trackingSteps<D>(set_, lag);
}

/// From the clipped guess inwards, because an interior point cannot begin at a limit.
/// @return how far from optimal the new iterate is
template <int D>
double TrackingRiccati<D>::startAt(double inwards)
{
  for (Eigen::Index k = 0; k < inputs_.clipped.cols(); ++k)
    put(work_.nodes[static_cast<std::size_t>(k)].u,
        (1.0 - inwards) * inputs_.clipped.col(k) + inwards * inputs_.inner.col(k));
  steps_.roll_out(work_);
  steps_.centre(work_, kSmallest);
  steps_.measure(work_);
  return steps_.dual_residual(work_);
}

/// A good guess is left as it is as far as possible; a bad one is no reason to stay near a limit.
template <int D>
void TrackingRiccati<D>::start()
{
  work_.cautious = false;
  double residual = startAt(kLittle);
  if (residual > kBad * work_.scale) residual = startAt(kFar);
  steps_.centre(work_, std::max(kMuOfScale * work_.scale, kMuOfResidual * residual));
  steps_.measure(work_);
}

template <int D>
bool TrackingRiccati<D>::optimal()
{
  const double limit = config_.tolerance * work_.scale;
  return work_.product <= limit && steps_.dual_residual(work_) <= limit;
}

/// For the one program in hundreds that takes its time. Either the barrier is too low for the way
/// that is still to go, or the iterates circle around the end of it.
template <int D>
void TrackingRiccati<D>::help(int iteration)
{
  const double residual = steps_.dual_residual(work_);
  work_.cautious = residual <= config_.tolerance * work_.scale;
  if (iteration != kPatience || residual <= kLowBarrier * work_.mu) return;
  steps_.centre(work_, kMuOfResidual * residual);
  steps_.measure(work_);
}

template <int D>
core::Termination TrackingRiccati<D>::iterate(const core::Deadline& deadline)
{
  for (int& i = solution_.report.iterations;; ++i)
  {
    if (optimal()) return Termination::Converged;
    if (i >= config_.max_iterations) return Termination::IterationLimit;
    if (deadline.passed()) return Termination::TimeLimit;
    if (i >= kPatience) help(i);
    if (!steps_.step(work_)) return Termination::NumericalFailure;
    steps_.measure(work_);
  }
}

template <int D>
void TrackingRiccati<D>::takeIterate(const TrackingQp<D>& problem)
{
  solution_.row_forces.setZero();  // also of rows that are not in use this time
  for (Eigen::Index k = 0; k < solution_.inputs.cols(); ++k)
  {
    const TrackingNode<D>& node = work_.nodes[static_cast<std::size_t>(k)];
    const RowGroup<D>* groups = work_.rows.data() + k * static_cast<Eigen::Index>(work_.max_groups);
    for (int i = 0; i < D; ++i)
    {
      solution_.inputs(i, k) = node.u.lane[i];
      solution_.positions(i, k) = node.p.lane[i];
      solution_.velocities(i, k) = node.v.lane[i];
      solution_.input_forces(i, k) = node.force[1].lane[i] - node.force[0].lane[i];
      solution_.change_forces(i, k) = node.force[3].lane[i] - node.force[2].lane[i];
    }
    for (int i = 0; i < problem.row_counts[static_cast<std::size_t>(k)]; ++i)
      solution_.row_forces[k * problem.max_rows + i] = groups[i / kLanes].force.lane[i % kLanes];
  }
}

template <int D>
void TrackingRiccati<D>::takeGuess(const TrackingQp<D>& problem)
{
  for (Eigen::Index k = 0; k < solution_.inputs.cols(); ++k)
    put(work_.nodes[static_cast<std::size_t>(k)].u, inputs_.clipped.col(k));
  steps_.roll_out(work_);
  takeIterate(problem);
  clearForces(solution_);
}

template <int D>
const char* TrackingRiccati<D>::name(core::Termination termination)
{
  switch (termination)
  {
    case Termination::Converged:
      return "optimal";
    case Termination::IterationLimit:
      return "iteration limit";
    case Termination::TimeLimit:
      return "deadline passed";
    default:
      return "no progress";
  }
}

/// The point to return and what is to be said about it.
template <int D>
void TrackingRiccati<D>::finish(const TrackingQp<D>& problem, core::Termination termination)
{
  core::SolveReport& report = solution_.report;
  const auto cost = [&] { return trackingCost<D>(problem, solution_.inputs); };
  takeIterate(problem);
  report.cost = cost();
  report.dual_residual = std::max(work_.product, steps_.dual_residual(work_)) / work_.scale;
  if (termination != Termination::Converged)
  {
    const double guess = trackingCost<D>(problem, inputs_.clipped);
    if (!(report.cost <= guess))
    {
      takeGuess(problem);
      report.cost = guess;
      report.dual_residual = std::numeric_limits<double>::infinity();
    }
  }
  report.termination = termination;
  report.message = name(termination);
  report.primal_residual = 0.0;
  settleClash(inputs_.clash, report);
}

template <int D>
const TrackingSolution<D>& TrackingRiccati<D>::solve(const TrackingQp<D>& problem,
                                                     const Eigen::Ref<const Matrix>& guess_inputs,
                                                     const core::Deadline& deadline)
{
  const auto begin = std::chrono::steady_clock::now();
  solution_.report.iterations = 0;
  if (const char* fault = faultOf<D>(problem, guess_inputs, stages(), max_rows_))
    refuse<D>(problem, guess_inputs, fault, solution_);
  else
  {
    inputs_.prepare(problem, guess_inputs);
    load(problem);
    start();
    finish(problem, iterate(deadline));
    solution_.worst_slack = worstSlack<D>(problem, solution_);
  }
  solution_.report.wall_time = std::chrono::steady_clock::now() - begin;
  return solution_;
}

template class TrackingRiccati<1>;
template class TrackingRiccati<3>;

}  // namespace slalom::optim::detail
