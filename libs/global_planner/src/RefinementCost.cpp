// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/global_planner/RefinementCost.h"

#include <algorithm>
#include <cmath>

namespace slalom::global_planner
{
namespace
{
constexpr double kAlongWeight = 1.0 / 25.0;  // sliding along R is cheap, leaving it is not

/// (|x| - limit)_+ with the sign of x, per axis.
Eigen::Vector3d excess(const Eigen::Vector3d& x, double limit)
{
  return x.unaryExpr([limit](double v)
                     { return v > limit ? v - limit : (v < -limit ? v + limit : 0.0); });
}

}  // namespace

Penalty clearancePenalty(const Eigen::Vector3d& p_L, const Push& push, double clearance)
{
  const double e = clearance - (p_L - push.anchor_L).dot(push.normal_L);
  const double s = clearance;
  if (e <= 0.0) return {0.0, Eigen::Vector3d::Zero()};
  if (e <= s) return {e * e * e, -3.0 * e * e * push.normal_L};
  return {3.0 * s * e * e - 3.0 * s * s * e + s * s * s,
          -(6.0 * s * e - 3.0 * s * s) * push.normal_L};
}

RefinementCost::RefinementCost(Problem problem, const GlobalPlannerConfig& config,
                               const core::Vehicle& vehicle)
    : problem_(std::move(problem)), config_(config), vehicle_(vehicle), work_(problem_.points)
{
  const Eigen::Index n = problem_.points.cols();
  tangents_ = Eigen::Matrix3Xd::Zero(3, n);
  for (Eigen::Index i = 1; i + 1 < n; ++i)
  {
    const Eigen::Vector3d along = problem_.reference.col(i + 1) - problem_.reference.col(i - 1);
    if (along.norm() > 1e-9) tangents_.col(i) = along.normalized();
  }
}

Eigen::VectorXd RefinementCost::start() const
{
  return problem_.points
      .middleCols(problem_.first_free, problem_.last_free - problem_.first_free + 1)
      .reshaped();
}

Eigen::Matrix3Xd RefinementCost::points(const Eigen::VectorXd& x) const
{
  Eigen::Matrix3Xd all = problem_.points;
  all.middleCols(problem_.first_free, x.size() / 3) = x.reshaped(3, x.size() / 3);
  return all;
}

double RefinementCost::operator()(const Eigen::VectorXd& x, Eigen::VectorXd& gradient)
{
  work_.middleCols(problem_.first_free, x.size() / 3) = x.reshaped(3, x.size() / 3);
  gradient_.setZero(3, work_.cols());
  const double cost = smoothness() + obstacles() + feasibility() + fitness();
  gradient = gradient_.middleCols(problem_.first_free, x.size() / 3).reshaped();
  return cost;
}

double RefinementCost::smoothness()
{
  double cost = 0.0;
  for (Eigen::Index i = 0; i + 2 < work_.cols(); ++i)
  {
    const Eigen::Vector3d a = work_.col(i + 2) - 2.0 * work_.col(i + 1) + work_.col(i);
    cost += config_.lambda_smooth * a.squaredNorm();
    const Eigen::Vector3d slope = 2.0 * config_.lambda_smooth * a;
    gradient_.col(i) += slope;
    gradient_.col(i + 1) -= 2.0 * slope;
    gradient_.col(i + 2) += slope;
  }
  return cost;
}

double RefinementCost::obstacles()
{
  const double weight = config_.lambda_obs * problem_.obstacle_gain;
  double cost = 0.0;
  for (const Push& push : problem_.pushes)
  {
    const Penalty penalty = clearancePenalty(work_.col(push.point), push, config_.clearance_m);
    cost += weight * penalty.cost;
    gradient_.col(push.point) += weight * penalty.gradient;
  }
  return cost;
}

double RefinementCost::feasibility()
{
  const double d = problem_.knot_span;
  double cost = 0.0;
  for (Eigen::Index i = 0; i + 1 < work_.cols(); ++i)
  {
    const Eigen::Vector3d over =
        excess((work_.col(i + 1) - work_.col(i)) / d, vehicle_.max_speed_mps) / d;
    cost += config_.lambda_feas * over.squaredNorm();
    const Eigen::Vector3d slope = 2.0 * config_.lambda_feas / (d * d) * over;
    gradient_.col(i + 1) += slope;
    gradient_.col(i) -= slope;
  }
  for (Eigen::Index i = 0; i + 2 < work_.cols(); ++i)
  {
    const Eigen::Vector3d over =
        excess((work_.col(i + 2) - 2.0 * work_.col(i + 1) + work_.col(i)) / (d * d),
               vehicle_.max_acceleration_mps2);
    cost += config_.lambda_feas * over.squaredNorm();
    const Eigen::Vector3d slope = 2.0 * config_.lambda_feas / (d * d) * over;
    gradient_.col(i) += slope;
    gradient_.col(i + 1) -= 2.0 * slope;
    gradient_.col(i + 2) += slope;
  }
  return cost;
}

double RefinementCost::fitness()
{
  double cost = 0.0;
  for (Eigen::Index i = 1; i + 1 < work_.cols(); ++i)
  {
    const double weight = config_.lambda_fit * problem_.fit_weight[i];
    if (weight == 0.0) continue;
    const Eigen::Vector3d offset = ((work_.col(i - 1) - problem_.reference.col(i - 1)) +
                                    4.0 * (work_.col(i) - problem_.reference.col(i)) +
                                    (work_.col(i + 1) - problem_.reference.col(i + 1))) /
                                   6.0;
    const double along = offset.dot(tangents_.col(i));
    const Eigen::Vector3d across = offset - along * tangents_.col(i);
    cost += weight * (kAlongWeight * along * along + across.squaredNorm());
    const Eigen::Vector3d slope =
        2.0 * weight * (kAlongWeight * along * tangents_.col(i) + across) / 6.0;
    gradient_.col(i - 1) += slope;
    gradient_.col(i) += 4.0 * slope;
    gradient_.col(i + 1) += slope;
  }
  return cost;
}

}  // namespace slalom::global_planner
