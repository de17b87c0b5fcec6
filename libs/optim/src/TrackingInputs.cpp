// SPDX-License-Identifier: BSD-3-Clause
#include "TrackingInputs.h"

#include <cmath>

namespace slalom::optim::detail
{
template <int D>
TrackingInputs<D>::TrackingInputs(int stages)
    : low(D, stages),
      high(D, stages),
      clipped(D, stages),
      inner(D, stages),
      reach_low_(D, stages),
      reach_high_(D, stages)
{
}

template <int D>
void TrackingInputs<D>::prepare(const TrackingQp<D>& problem, const Eigen::Ref<const Matrix>& guess)
{
  widen(problem);
  clip(problem, guess);
}

/// The boxes all hold zero, so only the input before can be out of reach. `inner` goes from there
/// to zero, using half of what the changes allow, or nearly all where it starts outside a box.
template <int D>
void TrackingInputs<D>::widen(const TrackingQp<D>& problem)
{
  constexpr double kNearlyAll = 0.99;
  clash = 0.0;
  for (int i = 0; i < D; ++i)
  {
    const double start = std::abs(problem.u_before[i]);
    const double side = problem.u_before[i] < 0.0 ? -1.0 : 1.0;
    double fastest = start;
    bool outside = false;
    for (Eigen::Index k = 0; k < low.cols(); ++k)
    {
      const TrackingStage<D>& stage = problem.stages[static_cast<std::size_t>(k)];
      fastest = std::max(0.0, fastest - kNearlyAll * stage.change_limit[i]);
      const double limit = stage.input_limit[i];
      // A box that is reached only just has no room for an interior point either.
      const double bound = start > limit ? std::max(limit, fastest) : limit;
      outside = outside || start > limit;
      clash = std::max(clash, bound - limit);
      high(i, k) = side > 0.0 ? bound : limit;
      low(i, k) = side > 0.0 ? -limit : -bound;
    }
    const double pace = outside ? 0.5 * (1.0 + kNearlyAll) : 0.5;
    double at = start;
    for (Eigen::Index k = 0; k < low.cols(); ++k)
    {
      const TrackingStage<D>& stage = problem.stages[static_cast<std::size_t>(k)];
      at = std::max(0.0, at - pace * stage.change_limit[i]);
      inner(i, k) = side * at;
    }
  }
}

template <int D>
void TrackingInputs<D>::clip(const TrackingQp<D>& problem, const Eigen::Ref<const Matrix>& guess)
{
  for (int i = 0; i < D; ++i)
  {
    const Eigen::Index last = low.cols() - 1;
    for (Eigen::Index k = last; k >= 0; --k)
    {
      reach_low_(i, k) = low(i, k);
      reach_high_(i, k) = high(i, k);
      if (k == last) continue;
      const double change = problem.stages[static_cast<std::size_t>(k + 1)].change_limit[i];
      reach_low_(i, k) = std::max(low(i, k), reach_low_(i, k + 1) - change);
      reach_high_(i, k) = std::min(high(i, k), reach_high_(i, k + 1) + change);
    }
    double before = problem.u_before[i];
    for (Eigen::Index k = 0; k <= last; ++k)
    {
      const double change = problem.stages[static_cast<std::size_t>(k)].change_limit[i];
      const double lower = std::max(reach_low_(i, k), before - change);
      const double upper = std::min(reach_high_(i, k), before + change);
      before = std::max(lower, std::min(upper, guess(i, k)));
      clipped(i, k) = before;
    }
  }
}

template <int D>
const char* faultOf(const TrackingQp<D>& problem,
                    const Eigen::Ref<const Eigen::Matrix<double, D, Eigen::Dynamic>>& guess,
                    int stages, int max_rows)
{
  const std::size_t n = static_cast<std::size_t>(stages);
  if (problem.stages.size() != n || problem.row_counts.size() != n || guess.cols() != stages ||
      problem.max_rows > max_rows || problem.max_rows < 0 ||
      problem.rows.size() != n * static_cast<std::size_t>(problem.max_rows))
    return "wrong size";
  // Zero times anything that is not finite is not a number, and stays so in the sum.
  double zero = 0.0 * (problem.p.sum() + problem.v.sum() + problem.u_before.sum() + guess.sum());
  bool sane = true;
  for (std::size_t k = 0; k < n; ++k)
  {
    const TrackingStage<D>& s = problem.stages[k];
    zero += 0.0 * (s.response.p_v + s.response.p_u + s.response.v_v + s.response.v_u +
                   s.drift_p.sum() + s.drift_v.sum() + s.position.sum() + s.velocity.sum() +
                   s.input.sum() + s.change.sum() + s.position_weight.sum() + s.velocity_weight +
                   s.input_weight + s.change_weight + s.input_limit.sum() + s.change_limit.sum());
    sane = sane && s.velocity_weight >= 0.0 && s.input_weight >= 0.0 && s.change_weight >= 0.0 &&
           s.input_limit.minCoeff() > 0.0 && s.change_limit.minCoeff() > 0.0;
    if (problem.row_counts[k] < 0 || problem.row_counts[k] > problem.max_rows) return "wrong size";
    for (int i = 0; i < problem.row_counts[k]; ++i)
    {
      const SoftRow<D>& row =
          problem
              .rows[k * static_cast<std::size_t>(problem.max_rows) + static_cast<std::size_t>(i)];
      zero += 0.0 * (row.normal.sum() + row.lead + row.offset + row.penalty);
      sane = sane && row.penalty > 0.0;
    }
  }
  if (!(zero == 0.0)) return "not finite";
  return sane ? nullptr : "bad data";
}

template class TrackingInputs<1>;
template class TrackingInputs<3>;
template const char* faultOf<1>(const TrackingQp<1>&,
                                const Eigen::Ref<const Eigen::Matrix<double, 1, Eigen::Dynamic>>&,
                                int, int);
template const char* faultOf<3>(const TrackingQp<3>&,
                                const Eigen::Ref<const Eigen::Matrix<double, 3, Eigen::Dynamic>>&,
                                int, int);

}  // namespace slalom::optim::detail
