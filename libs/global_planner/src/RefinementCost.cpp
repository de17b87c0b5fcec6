// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/global_planner/RefinementCost.h"

#include <algorithm>
#include <cmath>

namespace slalom::global_planner
{
namespace
{
using Eigen::Index;

constexpr double kAlongWeight = 1.0 / 25.0;  // sliding along R is cheap, leaving it is not

// A difference with the stencil s has the curvature s s^T in its points; these are its entries.
constexpr double kBend[] = {1.0, -2.0, 1.0};
constexpr double kKnot[] = {1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0};

/// Adds s s^T (x) block, s over the columns first..first+2, where those are variables.
void addStencil(optim::BlockBand& hessian, Index first, const double (&s)[3],
                const Eigen::Matrix3d& block)
{
  const auto isFree = [&](Index i) { return i >= 0 && i < hessian.blocks(); };
  for (Index i = 0; i < 3; ++i)
  {
    if (!isFree(first + i)) continue;
    hessian.diagonal[first + i] += s[i] * s[i] * block;
    if (i < 2 && isFree(first + i + 1)) hessian.first[first + i] += s[i] * s[i + 1] * block;
    if (i < 1 && isFree(first + i + 2)) hessian.second[first + i] += s[i] * s[i + 2] * block;
  }
}

/// J_feas is in terms of v and a; in terms of differences of control points it is the same with
/// the limits times D, D^2 and the weights over D^4.
optim::SoftLimits limitsOf(const RefinementCost::Problem& problem, double weight,
                           const core::Vehicle& vehicle)
{
  const double d = problem.knot_span;
  const double scaled = weight / (d * d * d * d);
  const Index behind = problem.points.cols() - 1 - problem.last_free;
  return {
      problem.points.leftCols(problem.first_free),
      problem.last_free - problem.first_free + 1,
      problem.points.rightCols(behind),
      {{1, vehicle.max_speed_mps * d, scaled}, {2, vehicle.max_acceleration_mps2 * d * d, scaled}}};
}

}  // namespace

Penalty clearancePenalty(const Eigen::Vector3d& p_L, const Push& push, double clearance,
                         HingeTail tail)
{
  const double e = clearance - (p_L - push.anchor_L).dot(push.normal_L);
  const double s = clearance;
  if (e <= 0.0) return {};
  if (e <= s || tail == HingeTail::Cubic) return {e * e * e, -3.0 * e * e, 6.0 * e};
  return {3.0 * s * e * e - 3.0 * s * s * e + s * s * s, -(6.0 * s * e - 3.0 * s * s), 6.0 * s};
}

RefinementCost::RefinementCost(Problem problem, const GlobalPlannerConfig& config,
                               const core::Vehicle& vehicle)
    : LimitedCost(limitsOf(problem, config.lambda_feas, vehicle)),
      problem_(std::move(problem)),
      free_(problem_.last_free - problem_.first_free + 1),
      clearance_(config.clearance_m),
      weight_smooth_(config.lambda_smooth),
      weight_obs_(config.lambda_obs * problem_.obstacle_gain),
      constant_(free_),
      work_(problem_.points),
      gradient_(3, work_.cols())
{
  makeFits(config.lambda_fit);
  makeConstantCurvature();
}

void RefinementCost::makeFits(double weight)
{
  for (Index i = 1; i + 1 < work_.cols(); ++i)
  {
    const double share = weight * problem_.fit_weight[i];
    if (share == 0.0) continue;
    const Eigen::Vector3d along = problem_.reference.col(i + 1) - problem_.reference.col(i - 1);
    Eigen::Vector3d t = Eigen::Vector3d::Zero();
    if (along.norm() > 1e-9) t = along.normalized();
    fits_.push_back(
        {i, share * (Eigen::Matrix3d::Identity() - (1.0 - kAlongWeight) * t * t.transpose())});
  }
}

void RefinementCost::makeConstantCurvature()
{
  const Index first = problem_.first_free;
  for (Index i = 0; i + 2 < work_.cols(); ++i)
    addStencil(constant_, i - first, kBend, 2.0 * weight_smooth_ * Eigen::Matrix3d::Identity());
  for (const Fit& fit : fits_)
    addStencil(constant_, fit.point - 1 - first, kKnot, 2.0 * fit.metric);
}

Eigen::VectorXd RefinementCost::start() const
{
  return problem_.points.middleCols(problem_.first_free, free_).reshaped();
}

Eigen::Matrix3Xd RefinementCost::points(const Eigen::VectorXd& x) const
{
  Eigen::Matrix3Xd all = problem_.points;
  all.middleCols(problem_.first_free, free_) = x.reshaped(3, free_);
  return all;
}

double RefinementCost::evaluateSmooth(const Eigen::VectorXd& x, Eigen::VectorXd& gradient)
{
  work_.middleCols(problem_.first_free, free_) = x.reshaped(3, free_);
  gradient_.setZero();
  const double cost = smoothness() + obstacles() + fitness();
  gradient = gradient_.middleCols(problem_.first_free, free_).reshaped();
  return cost;
}

double RefinementCost::smoothness()
{
  // Columns follow each other in memory, so the differences of all axes are one long array.
  const auto points = work_.reshaped().array();
  auto slope = gradient_.reshaped().array();
  const Index n = points.size() - 6;
  bend_ = points.tail(n) - 2.0 * points.segment(3, n) + points.head(n);
  if (problem_.bend.size() > 0) bend_ -= problem_.bend.reshaped().array();
  const double cost = weight_smooth_ * bend_.square().sum();
  bend_ *= 2.0 * weight_smooth_;
  slope.head(n) += bend_;
  slope.segment(3, n) -= 2.0 * bend_;
  slope.tail(n) += bend_;
  return cost;
}

double RefinementCost::obstacles()
{
  double cost = 0.0;
  for (const Push& push : problem_.pushes)
  {
    const Penalty penalty =
        clearancePenalty(work_.col(push.point), push, clearance_, problem_.tail);
    cost += penalty.cost;
    gradient_.col(push.point) += weight_obs_ * penalty.slope * push.normal_L;
  }
  return weight_obs_ * cost;
}

double RefinementCost::fitness()
{
  double cost = 0.0;
  const auto offset = [this](Index i) { return work_.col(i) - problem_.reference.col(i); };
  for (const Fit& fit : fits_)
  {
    const Index i = fit.point;
    const Eigen::Vector3d x =
        kKnot[0] * offset(i - 1) + kKnot[1] * offset(i) + kKnot[2] * offset(i + 1);
    const Eigen::Vector3d slope = 2.0 * fit.metric * x;
    cost += 0.5 * x.dot(slope);
    gradient_.col(i - 1) += kKnot[0] * slope;
    gradient_.col(i) += kKnot[1] * slope;
    gradient_.col(i + 1) += kKnot[2] * slope;
  }
  return cost;
}

void RefinementCost::curvatureSmooth(const Eigen::VectorXd& x, optim::BlockBand& hessian)
{
  hessian = constant_;
  for (const Push& push : problem_.pushes)
  {
    const Index k = push.point - problem_.first_free;
    if (k < 0 || k >= free_) continue;
    const double curvature =
        weight_obs_ *
        clearancePenalty(x.segment<3>(3 * k), push, clearance_, problem_.tail).curvature;
    hessian.diagonal[k] += (curvature * push.normal_L) * push.normal_L.transpose();
  }
}

}  // namespace slalom::global_planner
