// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace slalom::optim::detail
{
/// What the steps are compiled for. All of them give the same results to the last bit.
enum class InstructionSet
{
  Portable,
  Avx2
};
[[nodiscard]] InstructionSet bestInstructionSet();  ///< of this processor

/// Four numbers side by side: the axes of a vector (what is left over is zero), or four rows.
struct alignas(32) Quad
{
  double lane[4] = {0.0, 0.0, 0.0, 0.0};
};

/** Four soft rows of one stage, a lane each. With t = normal . (p + lead v) - offset a row is
 *  `above` = t + `slack` >= 0, slack >= 0. Its multiplier is `force` in (0, penalty), that of the
 *  slack penalty - force. */
template <int D>
struct RowGroup
{
  Quad normal[D], lead, offset, penalty;
  Quad above, slack, force;
  Quad inverse;  ///< 1 / ((penalty - force) above + force slack)
  Quad weight;   ///< of the row in the Newton matrix
  Quad d_value, d_above, d_slack, d_force;
};

/** One stage: data, iterate, Newton step. The limits of an input u and a change e = u - u_before
 *  are four gaps per axis: u - low, high - u, change_limit + e, change_limit - e. */
template <int D>
struct TrackingNode
{
  double p_v, p_u, v_v, v_u;
  double velocity_weight, input_weight, change_weight;  ///< doubled: entries of the Hessian
  int groups;                                           ///< of rows
  bool leads;                                           ///< whether any row looks at the velocity
  Quad position_weight[D];                              ///< doubled, columns
  Quad drift_p, drift_v, position, velocity, input, change;
  Quad low, high, change_limit;

  Quad u, p, v;  ///< the input, and what it leads to
  Quad gap[4], force[4];
  Quad inverse_gap[4], inverse_force[4];
  Quad grad_p, grad_v, grad_u, grad_e;  ///< of the cost

  Quad lower[D];                         ///< rows of L in H_uu = L D L^T
  Quad pivot;                            ///< inverse of D
  Quad tied_p[D], tied_v[D], tied_u[D];  ///< rows of L^-1 H_ux
  Quad feed;                             ///< D^-1 L^-1 h_u
  Quad du, dp, dv, d_force[4];
};

/// All memory of a solve, and the figures its steps hand to the loop around them.
template <int D>
struct TrackingWork
{
  TrackingWork(int stages, int groups)
      : nodes(static_cast<std::size_t>(stages)),
        rows(static_cast<std::size_t>(stages * groups)),
        max_groups(groups)
  {
  }

  std::vector<TrackingNode<D>> nodes;
  std::vector<RowGroup<D>> rows;  ///< those of stage k from k*max_groups on
  int max_groups;
  Quad p, v, u_before;

  double pairs = 0.0;     ///< number of gaps
  double mu = 0.0;        ///< mean of gap times force
  double product = 0.0;   ///< largest of them
  double scale = 1.0;     ///< 1 + largest gradient of the cost
  bool cautious = false;  ///< stay near the central path
  double damping = 0.0;   ///< added to the Newton matrix, relative to scale
};

/// The steps of the interior point for one processor and one kind of vehicle.
template <int D>
struct TrackingSteps
{
  /// Positions and velocities of the inputs.
  void (*roll_out)(TrackingWork<D>&);
  /// Forces with force times gap = mu for inputs that are strictly inside the limits.
  void (*centre)(TrackingWork<D>&, double mu);
  /// Gaps, gradients, mu, product and scale of the iterate.
  void (*measure)(TrackingWork<D>&);
  /// Largest entry of the gradient of the Lagrangian with respect to the inputs.
  double (*dual_residual)(const TrackingWork<D>&);
  /// Predictor, corrector, move. False if there is no way on.
  bool (*step)(TrackingWork<D>&);
};

/// @param lag whether velocity is a state of its own (p_v or v_v not zero in any stage)
template <int D>
[[nodiscard]] TrackingSteps<D> trackingSteps(InstructionSet set, bool lag);
template <>
TrackingSteps<1> trackingSteps<1>(InstructionSet set, bool lag);
template <>
TrackingSteps<3> trackingSteps<3>(InstructionSet set, bool lag);

}  // namespace slalom::optim::detail
