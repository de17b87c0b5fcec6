// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "slalom/optim/TrackingQp.h"

namespace slalom::optim
{
namespace
{
template <int D>
using Vector = typename TrackingStage<D>::Vector;

template <int D>
struct Motion
{
  Vector<D> p, v;
};

template <int D>
Motion<D> after(const TrackingStage<D>& stage, const Motion<D>& from, const Vector<D>& u)
{
  const core::VelocityResponse& r = stage.response;
  return {from.p + r.p_v * from.v + r.p_u * u + stage.drift_p,
          r.v_v * from.v + r.v_u * u + stage.drift_v};
}

/// Distance of a motion from the edge of a row; < 0 on the wrong side.
template <int D>
double distance(const SoftRow<D>& row, const Motion<D>& at)
{
  return row.normal.dot(at.p + row.lead * at.v) - row.offset;
}

/// Halves of the gradients of the squares of one stage, times two.
template <int D>
struct Gradient
{
  Vector<D> p, v, u, change;

  Gradient(const TrackingStage<D>& stage, const Motion<D>& at, const Vector<D>& input,
           const Vector<D>& before)
      : p(2.0 * (stage.position_weight * (at.p - stage.position))),
        v(2.0 * stage.velocity_weight * (at.v - stage.velocity)),
        u(2.0 * stage.input_weight * (input - stage.input)),
        change(2.0 * stage.change_weight * (input - before - stage.change))
  {
  }
  [[nodiscard]] double largest() const
  {
    return std::max(std::max(p.cwiseAbs().maxCoeff(), v.cwiseAbs().maxCoeff()),
                    std::max(u.cwiseAbs().maxCoeff(), change.cwiseAbs().maxCoeff()));
  }
};

/// Excess over |x| <= limit, and force times gap where the force presses against it.
template <int D>
void judgeLimit(const Vector<D>& x, const Vector<D>& limit, const Vector<D>& force,
                TrackingResiduals& residuals)
{
  for (int i = 0; i < D; ++i)
  {
    const double gap = force[i] > 0.0 ? limit[i] - x[i] : limit[i] + x[i];
    residuals.limits = std::max(residuals.limits, std::abs(x[i]) - limit[i]);
    residuals.complementarity = std::max(residuals.complementarity, std::abs(force[i] * gap));
  }
}

template <int D>
void judgeRow(const SoftRow<D>& row, const Motion<D>& at, double force,
              TrackingResiduals& residuals)
{
  const double t = distance(row, at);
  const double rest = row.penalty - force;
  residuals.complementarity = std::max({residuals.complementarity, force * std::max(0.0, t),
                                        rest * std::max(0.0, -t), -force, -rest});
}

}  // namespace

template <int D>
double trackingCost(const TrackingQp<D>& problem,
                    const Eigen::Ref<const Eigen::Matrix<double, D, Eigen::Dynamic>>& inputs)
{
  double cost = 0.0;
  Motion<D> at{problem.p, problem.v};
  Vector<D> before = problem.u_before;
  for (std::size_t k = 0; k < problem.stages.size(); ++k)
  {
    const TrackingStage<D>& stage = problem.stages[k];
    const Vector<D> u = inputs.col(static_cast<Eigen::Index>(k));
    at = after<D>(stage, at, u);
    const Vector<D> off = at.p - stage.position;
    cost += off.dot(stage.position_weight * off) +
            stage.velocity_weight * (at.v - stage.velocity).squaredNorm() +
            stage.input_weight * (u - stage.input).squaredNorm() +
            stage.change_weight * (u - before - stage.change).squaredNorm();
    before = u;
    const std::size_t first = k * static_cast<std::size_t>(problem.max_rows);
    for (int i = 0; i < problem.row_counts[k]; ++i)
    {
      const SoftRow<D>& row = problem.rows[first + static_cast<std::size_t>(i)];
      cost += row.penalty * std::max(0.0, -distance(row, at));
    }
  }
  return cost;
}

template <int D>
TrackingResiduals trackingResiduals(const TrackingQp<D>& problem,
                                    const TrackingSolution<D>& solution)
{
  TrackingResiduals residuals;
  const Eigen::Index n = solution.inputs.cols();
  const auto before = [&](Eigen::Index k) -> Vector<D>
  { return k == 0 ? problem.u_before : Vector<D>(solution.inputs.col(k - 1)); };
  Motion<D> exact{problem.p, problem.v};
  // Of the Lagrangian with respect to the motion after a stage, from the last stage to the first.
  Motion<D> slope{Vector<D>::Zero(), Vector<D>::Zero()};
  for (Eigen::Index k = 0; k < n; ++k)
  {
    const TrackingStage<D>& stage = problem.stages[static_cast<std::size_t>(k)];
    const Vector<D> u = solution.inputs.col(k);
    exact = after<D>(stage, exact, u);
    residuals.dynamics =
        std::max({residuals.dynamics, (exact.p - solution.positions.col(k)).cwiseAbs().maxCoeff(),
                  (exact.v - solution.velocities.col(k)).cwiseAbs().maxCoeff()});
    judgeLimit<D>(u, stage.input_limit, solution.input_forces.col(k), residuals);
    judgeLimit<D>(u - before(k), stage.change_limit, solution.change_forces.col(k), residuals);
  }
  Vector<D> next = Vector<D>::Zero();  // how the following change depends on this input
  for (Eigen::Index k = n; k-- > 0;)
  {
    const TrackingStage<D>& stage = problem.stages[static_cast<std::size_t>(k)];
    const Motion<D> at{solution.positions.col(k), solution.velocities.col(k)};
    const Gradient<D> gradient(stage, at, solution.inputs.col(k), before(k));
    residuals.scale = std::max(residuals.scale, 1.0 + gradient.largest());
    slope.p += gradient.p;
    slope.v += gradient.v;
    for (int i = 0; i < problem.row_counts[static_cast<std::size_t>(k)]; ++i)
    {
      const Eigen::Index index = k * problem.max_rows + i;
      const SoftRow<D>& row = problem.rows[static_cast<std::size_t>(index)];
      const double force = solution.row_forces[index];
      judgeRow<D>(row, at, force, residuals);
      slope.p -= force * row.normal;
      slope.v -= force * row.lead * row.normal;
    }
    const core::VelocityResponse& r = stage.response;
    const Vector<D> change = gradient.change + solution.change_forces.col(k);
    const Vector<D> total = r.p_u * slope.p + r.v_u * slope.v + gradient.u +
                            solution.input_forces.col(k) + change - next;
    residuals.stationarity = std::max(residuals.stationarity, total.cwiseAbs().maxCoeff());
    slope.v = r.p_v * slope.p + r.v_v * slope.v;
    next = change;
  }
  return residuals;
}

template double trackingCost<1>(const TrackingQp<1>&,
                                const Eigen::Ref<const Eigen::Matrix<double, 1, Eigen::Dynamic>>&);
template double trackingCost<3>(const TrackingQp<3>&,
                                const Eigen::Ref<const Eigen::Matrix<double, 3, Eigen::Dynamic>>&);
template TrackingResiduals trackingResiduals<1>(const TrackingQp<1>&, const TrackingSolution<1>&);
template TrackingResiduals trackingResiduals<3>(const TrackingQp<3>&, const TrackingSolution<3>&);

}  // namespace slalom::optim
