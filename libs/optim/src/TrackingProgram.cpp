// SPDX-License-Identifier: BSD-3-Clause
#include "TrackingProgram.h"

namespace slalom::optim::detail
{
using Eigen::Ref;
using Eigen::VectorXd;

namespace
{
constexpr double kUnlimited = 2e19;  // what Ipopt takes for infinity
}

template <int D>
void TrackingProgram<D>::bounds(Ref<VectorXd> x_lower, Ref<VectorXd> x_upper, Ref<VectorXd> g_lower,
                                Ref<VectorXd> g_upper) const
{
  x_lower.setConstant(-kUnlimited);
  x_upper.setConstant(kUnlimited);
  g_lower.setZero();
  g_upper.setZero();
  for (int k = 0; k < n_; ++k)
  {
    const int at = input(k);
    x_lower.template segment<D>(at) = low_->col(k);
    x_upper.template segment<D>(at) = high_->col(k);
    x_lower.segment(slack(k), rows_).setZero();
    g_lower.template segment<D>(at + 2 * D) = -stage(k).change_limit;
    g_upper.template segment<D>(at + 2 * D) = stage(k).change_limit;
    if (k == 0)
    {
      g_lower.template segment<D>(2 * D) += problem_->u_before;
      g_upper.template segment<D>(2 * D) += problem_->u_before;
    }
    for (int i = 0; i < rows_; ++i)
    {
      g_lower[slack(k) + i] = row(k, i) ? row(k, i)->offset : 0.0;
      g_upper[slack(k) + i] = kUnlimited;
    }
  }
}

template <int D>
template <class Visit>
void TrackingProgram<D>::eachJacobian(const Visit& visit) const
{
  for (int k = 0; k < n_; ++k)
  {
    // Without a problem only the places are wanted.
    const core::VelocityResponse r = problem_ ? stage(k).response : core::VelocityResponse{};
    for (int i = 0; i < D; ++i)
    {
      const int at = input(k) + i, u = at, p = position(k) + i, v = velocity(k) + i;
      visit(at, p, -1.0);
      visit(at, u, r.p_u);
      visit(at + D, v, -1.0);
      visit(at + D, u, r.v_u);
      visit(at + 2 * D, u, 1.0);
      if (k == 0) continue;
      visit(at, position(k - 1) + i, 1.0);
      visit(at, velocity(k - 1) + i, r.p_v);
      visit(at + D, velocity(k - 1) + i, r.v_v);
      visit(at + 2 * D, input(k - 1) + i, -1.0);
    }
    for (int j = 0; j < rows_; ++j)
    {
      const SoftRow<D>* soft = problem_ ? row(k, j) : nullptr;
      for (int i = 0; i < D; ++i)
      {
        visit(slack(k) + j, position(k) + i, soft ? soft->normal[i] : 0.0);
        visit(slack(k) + j, velocity(k) + i, soft ? soft->lead * soft->normal[i] : 0.0);
      }
      visit(slack(k) + j, slack(k) + j, 1.0);
    }
  }
}

template <int D>
template <class Visit>
void TrackingProgram<D>::eachHessian(const Visit& visit) const
{
  const TrackingStage<D> none;
  for (int k = 0; k < n_; ++k)
  {
    const TrackingStage<D>& s = problem_ ? stage(k) : none;
    const double next = k + 1 < n_ && problem_ ? stage(k + 1).change_weight : 0.0;
    for (int i = 0; i < D; ++i)
    {
      const int u = input(k) + i;
      visit(u, u, 2.0 * (s.input_weight + s.change_weight + next));
      if (k > 0) visit(u, input(k - 1) + i, -2.0 * s.change_weight);
      visit(velocity(k) + i, velocity(k) + i, 2.0 * s.velocity_weight);
      for (int j = 0; j <= i; ++j)
        visit(position(k) + i, position(k) + j, 2.0 * s.position_weight(i, j));
    }
  }
}

template <int D>
std::vector<Entry> TrackingProgram<D>::jacobianStructure() const
{
  std::vector<Entry> entries;
  eachJacobian([&](int row, int col, double) { entries.push_back({row, col}); });
  return entries;
}

template <int D>
std::vector<Entry> TrackingProgram<D>::hessianStructure() const
{
  std::vector<Entry> entries;
  eachHessian([&](int row, int col, double) { entries.push_back({row, col}); });
  return entries;
}

template <int D>
void TrackingProgram<D>::jacobian(const Ref<const VectorXd>&, Ref<VectorXd> values) const
{
  Eigen::Index next = 0;
  eachJacobian([&](int, int, double value) { values[next++] = value; });
}

template <int D>
void TrackingProgram<D>::hessian(const Ref<const VectorXd>&, double sigma,
                                 const Ref<const VectorXd>&, Ref<VectorXd> values) const
{
  Eigen::Index next = 0;
  eachHessian([&](int, int, double value) { values[next++] = sigma * value; });
}

template <int D>
double TrackingProgram<D>::cost(const Ref<const VectorXd>& x) const
{
  double cost = 0.0;
  Vector before = problem_->u_before;
  for (int k = 0; k < n_; ++k)
  {
    const TrackingStage<D>& s = stage(k);
    const Vector u = x.template segment<D>(input(k));
    const Vector off = x.template segment<D>(position(k)) - s.position;
    cost += off.dot(s.position_weight * off) +
            s.velocity_weight * (x.template segment<D>(velocity(k)) - s.velocity).squaredNorm() +
            s.input_weight * (u - s.input).squaredNorm() +
            s.change_weight * (u - before - s.change).squaredNorm();
    for (int i = 0; i < rows_; ++i)
      cost += (row(k, i) ? row(k, i)->penalty : 1.0) * x[slack(k) + i];
    before = u;
  }
  return cost;
}

template <int D>
void TrackingProgram<D>::gradient(const Ref<const VectorXd>& x, Ref<VectorXd> grad) const
{
  grad.setZero();
  Vector before = problem_->u_before;
  for (int k = 0; k < n_; ++k)
  {
    const TrackingStage<D>& s = stage(k);
    const Vector u = x.template segment<D>(input(k));
    const Vector change = 2.0 * s.change_weight * (u - before - s.change);
    grad.template segment<D>(input(k)) += 2.0 * s.input_weight * (u - s.input) + change;
    if (k > 0) grad.template segment<D>(input(k - 1)) -= change;
    grad.template segment<D>(position(k)) =
        2.0 * (s.position_weight * (x.template segment<D>(position(k)) - s.position));
    grad.template segment<D>(velocity(k)) =
        2.0 * s.velocity_weight * (x.template segment<D>(velocity(k)) - s.velocity);
    for (int i = 0; i < rows_; ++i) grad[slack(k) + i] = row(k, i) ? row(k, i)->penalty : 1.0;
    before = u;
  }
}

template <int D>
void TrackingProgram<D>::constraint(const Ref<const VectorXd>& x, Ref<VectorXd> g) const
{
  g.setZero();
  eachJacobian([&](int row, int col, double value) { g[row] += value * x[col]; });
  for (int k = 0; k < n_; ++k)
  {
    g.template segment<D>(input(k)) += stage(k).drift_p;
    g.template segment<D>(input(k) + D) += stage(k).drift_v;
  }
  const core::VelocityResponse& r = stage(0).response;
  g.template segment<D>(0) += problem_->p + r.p_v * problem_->v;
  g.template segment<D>(D) += r.v_v * problem_->v;
}

template class TrackingProgram<1>;
template class TrackingProgram<3>;

}  // namespace slalom::optim::detail
