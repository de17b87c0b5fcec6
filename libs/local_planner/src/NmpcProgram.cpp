// SPDX-License-Identifier: BSD-3-Clause
#include "NmpcProgram.h"

#include <algorithm>
#include <cmath>

namespace slalom::local_planner::detail
{
namespace
{
using Eigen::Ref;
using Eigen::Vector3d;
using Eigen::Vector4d;
using Eigen::VectorXd;
using optim::Entry;

constexpr double kUnbounded = 2e19;  // Ipopt takes 1e19 and more for infinity

Vector4d weights(double position, double yaw)
{
  return {position, position, position, yaw};
}
}  // namespace

NmpcProgram::NmpcProgram(const LocalPlannerConfig& config, const core::Vehicle& vehicle,
                         int rows_per_stage)
    : stages_(config.horizon),
      rows_(rows_per_stage),
      step_(config.step_s),
      penalty_(config.obstacle_penalty),
      max_change_(vehicle.max_acceleration_mps2 * config.step_s),
      q_(weights(config.weight_position, config.weight_yaw)),
      r_(weights(config.weight_velocity, config.weight_yaw_rate)),
      s_(Vector4d::Constant(config.weight_rate)),
      limit_(weights(vehicle.max_speed_mps, vehicle.max_yaw_rate_radps))
{
  data.state_reference.setZero(4, stages_ + 1);
  data.input_reference.setZero(4, stages_);
  data.keep_outs.resize(static_cast<std::size_t>(stages_ * rows_));
  walkJacobian([this](int r, int c, double) { jacobian_structure_.push_back({r, c}); });
  walkHessian(0.0, [this](int r, int c, double) { hessian_structure_.push_back({r, c}); });
}

VectorXd NmpcProgram::pack(const Eigen::Matrix4Xd& states, const Eigen::Matrix4Xd& inputs) const
{
  VectorXd x(variables());
  for (int k = 0; k < stages_; ++k)
  {
    x.segment<4>(input(k)) = inputs.col(k);
    x.segment<4>(state(k + 1)) = states.col(k + 1);
    // Well inside its bound and its rows: an interior-point method hates to start on them.
    if (rows_ > 0) x[slack(k + 1)] = neededSlack(states, k + 1) + 0.1;
  }
  return x;
}

double NmpcProgram::neededSlack(const Eigen::Matrix4Xd& states, int k) const
{
  double needed = 0.0;
  for (int j = 0; j < rows_; ++j)
  {
    const KeepOut& row = keepOut(k, j);
    needed = std::max(needed, row.offset - row.normal.dot(states.col(k).head<3>()));
  }
  return needed;
}

double NmpcProgram::neededSlack(const Eigen::Matrix4Xd& states) const
{
  double worst = 0.0;
  for (int k = 1; k <= stages_; ++k) worst = std::max(worst, neededSlack(states, k));
  return worst;
}

Eigen::Matrix4Xd NmpcProgram::statesOf(const VectorXd& x) const
{
  Eigen::Matrix4Xd states(4, stages_ + 1);
  states.col(0) = data.state;
  for (int k = 1; k <= stages_; ++k) states.col(k) = x.segment<4>(state(k));
  return states;
}

Eigen::Matrix4Xd NmpcProgram::inputsOf(const VectorXd& x) const
{
  Eigen::Matrix4Xd inputs(4, stages_);
  for (int k = 0; k < stages_; ++k) inputs.col(k) = x.segment<4>(input(k));
  return inputs;
}

double NmpcProgram::worstSlack(const VectorXd& x) const
{
  double worst = 0.0;
  for (int k = 1; k <= stages_ && rows_ > 0; ++k) worst = std::max(worst, x[slack(k)]);
  return worst;
}

void NmpcProgram::bounds(Ref<VectorXd> x_lower, Ref<VectorXd> x_upper, Ref<VectorXd> g_lower,
                         Ref<VectorXd> g_upper) const
{
  x_lower.setConstant(-kUnbounded);
  x_upper.setConstant(kUnbounded);
  g_lower.setZero();
  g_upper.setZero();
  for (int k = 0; k < stages_; ++k)
  {
    x_lower.segment<4>(input(k)) = -limit_;
    x_upper.segment<4>(input(k)) = limit_;
    if (rows_ > 0) x_lower[slack(k + 1)] = 0.0;
    for (int j = 0; j < rows_; ++j) g_lower[row(k) + 4 + j] = keepOut(k + 1, j).offset;
    g_upper.segment(row(k) + 4, rows_).setConstant(kUnbounded);
    if (k == 0) continue;
    g_lower.segment<3>(row(k) + 4 + rows_).setConstant(-max_change_);
    g_upper.segment<3>(row(k) + 4 + rows_).setConstant(max_change_);
  }
  // The first change starts from a given input: a bound of u_0, not a row.
  const double first_change = max_change_ / step_ * data.elapsed;
  const Vector3d last = data.last_input.head<3>();
  x_lower.head<3>() = (last.array() - first_change).max(-limit_.head<3>().array());
  x_upper.head<3>() = (last.array() + first_change).min(limit_.head<3>().array());
}

std::vector<Entry> NmpcProgram::jacobianStructure() const
{
  return jacobian_structure_;
}
std::vector<Entry> NmpcProgram::hessianStructure() const
{
  return hessian_structure_;
}

double NmpcProgram::cost(const Point& x) const
{
  double sum = 0.0;
  for (int k = 0; k < stages_; ++k)
  {
    const Vector4d u = x.segment<4>(input(k));
    const Vector4d u_error = u - data.input_reference.col(k);
    const Vector4d change = u - previousInput(x, k);
    const Vector4d x_error = x.segment<4>(state(k + 1)) - data.state_reference.col(k + 1);
    sum += x_error.dot(q_.cwiseProduct(x_error)) + u_error.dot(r_.cwiseProduct(u_error)) +
           change.dot(s_.cwiseProduct(change));
    if (rows_ > 0) sum += penalty_ * x[slack(k + 1)];
  }
  return sum;
}

void NmpcProgram::gradient(const Point& x, Ref<VectorXd> grad) const
{
  grad.setZero();
  for (int k = 0; k < stages_; ++k)
  {
    const Vector4d u = x.segment<4>(input(k));
    const Vector4d change = 2.0 * s_.cwiseProduct(u - previousInput(x, k));
    grad.segment<4>(input(k)) += 2.0 * r_.cwiseProduct(u - data.input_reference.col(k)) + change;
    if (k > 0) grad.segment<4>(input(k - 1)) -= change;
    grad.segment<4>(state(k + 1)) =
        2.0 * q_.cwiseProduct(x.segment<4>(state(k + 1)) - data.state_reference.col(k + 1));
    if (rows_ > 0) grad[slack(k + 1)] = penalty_;
  }
}

void NmpcProgram::constraint(const Point& x, Ref<VectorXd> g) const
{
  for (int k = 0; k < stages_; ++k)
  {
    const int at = row(k);
    const Vector4d from = k == 0 ? data.state : Vector4d(x.segment<4>(state(k)));
    const Vector4d to = x.segment<4>(state(k + 1));
    g.segment<4>(at) = to - from - step_ * x.segment<4>(input(k));
    for (int j = 0; j < rows_; ++j)
      g[at + 4 + j] = keepOut(k + 1, j).normal.dot(to.head<3>()) + x[slack(k + 1)];
    if (k > 0) g.segment<3>(at + 4 + rows_) = x.segment<3>(input(k)) - x.segment<3>(input(k - 1));
  }
}

template <class Visit>
void NmpcProgram::walkJacobian(Visit&& visit) const
{
  for (int k = 0; k < stages_; ++k)
  {
    const int at = row(k);
    for (int i = 0; i < 4; ++i)
    {
      visit(at + i, input(k) + i, -step_);
      visit(at + i, state(k + 1) + i, 1.0);
      if (k > 0) visit(at + i, state(k) + i, -1.0);
    }
    for (int j = 0; j < rows_; ++j)
    {
      for (int i = 0; i < 3; ++i) visit(at + 4 + j, state(k + 1) + i, keepOut(k + 1, j).normal[i]);
      visit(at + 4 + j, slack(k + 1), 1.0);
    }
    for (int i = 0; k > 0 && i < 3; ++i)
    {
      visit(at + 4 + rows_ + i, input(k) + i, 1.0);
      visit(at + 4 + rows_ + i, input(k - 1) + i, -1.0);
    }
  }
}

template <class Visit>
void NmpcProgram::walkHessian(double sigma, Visit&& visit) const
{
  for (int k = 0; k < stages_; ++k)
    for (int i = 0; i < 4; ++i)
    {
      const double later = k + 1 < stages_ ? s_[i] : 0.0;
      visit(input(k) + i, input(k) + i, 2.0 * sigma * (r_[i] + s_[i] + later));
      if (k > 0) visit(input(k) + i, input(k - 1) + i, -2.0 * sigma * s_[i]);
      visit(state(k + 1) + i, state(k + 1) + i, 2.0 * sigma * q_[i]);
    }
}

void NmpcProgram::jacobian(const Point&, Ref<VectorXd> values) const
{
  Eigen::Index i = 0;
  walkJacobian([&](int, int, double value) { values[i++] = value; });
}

void NmpcProgram::hessian(const Point&, double sigma, const Point&, Ref<VectorXd> values) const
{
  // Every constraint is linear: only the cost bends.
  Eigen::Index i = 0;
  walkHessian(sigma, [&](int, int, double value) { values[i++] = value; });
}

}  // namespace slalom::local_planner::detail
