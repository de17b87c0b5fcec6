// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <memory>
#include <vector>

#include "slalom/core/Deadline.h"
#include "slalom/core/SolveReport.h"
#include "slalom/core/VelocityResponse.h"

namespace slalom::optim
{
/// One stage of a TrackingQp: the input held over it, and what is wanted of the state it leads to.
template <int D>
struct TrackingStage
{
  using Vector = Eigen::Matrix<double, D, 1>;
  using Matrix = Eigen::Matrix<double, D, D>;

  core::VelocityResponse response;              ///< of every axis
  Vector drift_p = Vector::Zero();              ///< [m] known disturbance of the position
  Vector drift_v = Vector::Zero();              ///< [m/s] and of the velocity
  Vector position = Vector::Zero();             ///< [m] wanted at the end of the stage
  Vector velocity = Vector::Zero();             ///< [m/s] likewise
  Vector input = Vector::Zero();                ///< [m/s] wanted command
  Vector change = Vector::Zero();               ///< [m/s] wanted change of the command at the start
  Matrix position_weight = Matrix::Zero();      ///< symmetric, >= 0
  double velocity_weight = 0.0;                 ///< >= 0
  double input_weight = 0.0;                    ///< >= 0
  double change_weight = 0.0;                   ///< >= 0
  Vector input_limit = Vector::Constant(1e9);   ///< [m/s] > 0, on |u|
  Vector change_limit = Vector::Constant(1e9);  ///< [m/s] > 0, on |u - u before|
};

/// "Stay on this side": normal . (p + lead v) >= offset - s, s >= 0, at the cost `penalty` s.
template <int D>
struct SoftRow
{
  Eigen::Matrix<double, D, 1> normal = Eigen::Matrix<double, D, 1>::Unit(D - 1);  ///< [1]
  double lead = 0.0;                                                              ///< [s]
  double offset = 0.0;                                                            ///< [m]
  double penalty = 100.0;                                                         ///< [1/m] > 0
};

/** Convex program of a motion of D axes that is to follow a reference [Paper Eq. (9), linear form]:
 *
 *    min  sum_k |p_{k+1} - pr_k|_Q^2 + q |v_{k+1} - vr_k|^2 + r |u_k - ur_k|^2
 *         + s |u_k - u_{k-1} - dr_k|^2 + sum_rows penalty slack
 *    s.t. p_{k+1} = p_k + p_v v_k + p_u u_k + drift_p,
 *         v_{k+1} = v_v v_k + v_u u_k + drift_v,
 *         |u_k| <= input_limit, |u_k - u_{k-1}| <= change_limit     (per axis)
 *         the rows of stage k hold at p_{k+1}, v_{k+1}              (k = 0..N-1)
 *
 *  One slack per row makes every row an exact penalty: with |u_before| <= input_limit the program
 *  always has a solution. Where a limit lies out of reach of u_before it is widened to what the
 *  changes can reach, and the report says Infeasible. Knows no robot; D = 3 is a flight, D = 1 a
 * heading. Sizes are fixed at construction, so that solvers need no memory later. */
template <int D>
struct TrackingQp
{
  using Vector = typename TrackingStage<D>::Vector;

  /// @param rows_per_stage largest number of rows a stage may have
  TrackingQp(int stage_count, int rows_per_stage)
      : stages(static_cast<std::size_t>(stage_count)),
        rows(static_cast<std::size_t>(stage_count * rows_per_stage)),
        row_counts(static_cast<std::size_t>(stage_count), 0),
        max_rows(rows_per_stage)
  {
  }

  Vector p = Vector::Zero();         ///< [m] at the start
  Vector v = Vector::Zero();         ///< [m/s] at the start
  Vector u_before = Vector::Zero();  ///< [m/s] command in effect until the start

  std::vector<TrackingStage<D>> stages;  ///< N
  std::vector<SoftRow<D>> rows;          ///< N*max_rows; those of stage k from k*max_rows on
  std::vector<int> row_counts;           ///< N, rows in use
  int max_rows;
};

template <int D>
struct TrackingSolution
{
  Eigen::Matrix<double, D, Eigen::Dynamic> positions, velocities;  ///< DxN, after each stage
  Eigen::Matrix<double, D, Eigen::Dynamic> inputs;                 ///< DxN
  double worst_slack = 0.0;                                        ///< [m]
  /// Forces of the limits, DxN: > 0 at the upper, < 0 at the lower limit.
  Eigen::Matrix<double, D, Eigen::Dynamic> input_forces, change_forces;
  Eigen::VectorXd row_forces;  ///< N*max_rows, in the order of the rows, in [0, penalty]
  /// primal_residual: bounds, dynamics and rows; dual_residual: gradient of the Lagrangian and
  /// complementarity, both scaled by 1 + the largest gradient of the cost.
  core::SolveReport report;
};

/** How far a point and its forces are from the conditions of Karush, Kuhn and Tucker, which are
 *  necessary and sufficient for a minimum of a convex program. */
struct TrackingResiduals
{
  double dynamics = 0.0;         ///< [m], [m/s] largest error of a position or velocity
  double limits = 0.0;           ///< [m/s] largest excess of an input or a change
  double stationarity = 0.0;     ///< largest gradient of the Lagrangian per input
  double complementarity = 0.0;  ///< largest force times gap; also a row force outside its range
  double scale = 1.0;            ///< 1 + the largest gradient of the cost

  /// Both conditions of the forces, relative to the scale.
  [[nodiscard]] double dual() const { return std::max(stationarity, complementarity) / scale; }
};

enum class TrackingBackEnd
{
  Riccati,  ///< our own interior point along the stages; allocates nothing in solve()
  Ipopt     ///< the reference it is checked against
};

struct TrackingSolverConfig
{
  TrackingBackEnd back_end = TrackingBackEnd::Riccati;
  double tolerance = 1e-6;
  int max_iterations = 40;
};

/** Solves TrackingQps of one size, again and again. The only state is memory. */
template <int D>
class TrackingSolver
{
 public:
  virtual ~TrackingSolver() = default;

  /** @param guess_inputs DxN commands to start from (clipped into the limits); may be any finite
   *  ones
   *  @return the solver's own memory, valid until the next call. Never throws; when it ends early
   *  the best point so far, which keeps dynamics and limits. NumericalFailure for data that is not
   *  finite. */
  virtual const TrackingSolution<D>& solve(
      const TrackingQp<D>& problem,
      const Eigen::Ref<const Eigen::Matrix<double, D, Eigen::Dynamic>>& guess_inputs,
      const core::Deadline& deadline) = 0;
};

/// Cost of inputs that need not keep the limits; their motion follows from the problem.
template <int D>
[[nodiscard]] double trackingCost(
    const TrackingQp<D>& problem,
    const Eigen::Ref<const Eigen::Matrix<double, D, Eigen::Dynamic>>& inputs);

/// Judges a solution by the problem alone, whoever found it.
template <int D>
[[nodiscard]] TrackingResiduals trackingResiduals(const TrackingQp<D>& problem,
                                                  const TrackingSolution<D>& solution);

/// D = 1 and D = 3 are available.
template <int D>
[[nodiscard]] std::unique_ptr<TrackingSolver<D>> makeTrackingSolver(
    const TrackingSolverConfig& config, int stage_count, int rows_per_stage);

}  // namespace slalom::optim
