// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slalom/optim/TrackingQp.h"

namespace slalom::optim::detail
{
/** Inputs that keep the limits of a TrackingQp, made from any guess; memory for one size. */
template <int D>
class TrackingInputs
{
 public:
  using Matrix = Eigen::Matrix<double, D, Eigen::Dynamic>;

  explicit TrackingInputs(int stages);

  /** @param problem finite, limits > 0
   *  @param guess DxN, finite */
  void prepare(const TrackingQp<D>& problem, const Eigen::Ref<const Matrix>& guess);

  Matrix low, high;    ///< the input limits, widened where the changes cannot reach them
  double clash = 0.0;  ///< [m/s] by how much at most
  Matrix clipped;      ///< the guess, moved into the limits
  Matrix inner;        ///< inputs that are strictly inside, far from all limits

 private:
  void widen(const TrackingQp<D>& problem);
  void clip(const TrackingQp<D>& problem, const Eigen::Ref<const Matrix>& guess);

  Matrix reach_low_, reach_high_;  // from where all later stages can be kept
};

/// What keeps a problem from being solved, or null. A short literal.
template <int D>
[[nodiscard]] const char* faultOf(
    const TrackingQp<D>& problem,
    const Eigen::Ref<const Eigen::Matrix<double, D, Eigen::Dynamic>>& guess, int stages,
    int max_rows);

}  // namespace slalom::optim::detail
