// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slalom/optim/TrackingQp.h"

namespace slalom::optim::detail
{
/// With all memory a solution of this size may need.
template <int D>
[[nodiscard]] TrackingSolution<D> emptySolution(int stages, int max_rows);

template <int D>
void clearForces(TrackingSolution<D>& solution);

/// Positions and velocities of the inputs.
template <int D>
void rollOut(const TrackingQp<D>& problem, TrackingSolution<D>& solution);

/// By how much row i of stage k is violated [m]; < 0 if it holds.
template <int D>
[[nodiscard]] double violation(const TrackingQp<D>& problem, const TrackingSolution<D>& solution,
                               Eigen::Index k, int i)
{
  const SoftRow<D>& row = problem.rows[static_cast<std::size_t>(k * problem.max_rows + i)];
  return row.offset -
         row.normal.dot(solution.positions.col(k) + row.lead * solution.velocities.col(k));
}

/// Largest violation of a row, >= 0.
template <int D>
[[nodiscard]] double worstSlack(const TrackingQp<D>& problem, const TrackingSolution<D>& solution);

/// Something to fly although the data cannot be used: the guess in those limits that are numbers,
/// and no motion.
template <int D>
void refuse(const TrackingQp<D>& problem,
            const Eigen::Ref<const Eigen::Matrix<double, D, Eigen::Dynamic>>& guess,
            const char* fault, TrackingSolution<D>& solution);

/// A solution for widened limits is none for the given ones.
void settleClash(double clash, core::SolveReport& report);

}  // namespace slalom::optim::detail
