// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/optim/BandedCost.h"

#include <algorithm>

namespace slalom::optim
{
namespace
{
using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::VectorXd;

constexpr double kStencil[3][3] = {{}, {-1.0, 1.0, 0.0}, {1.0, -2.0, 1.0}};  // by order

/// The price of the terms between the columns of `points`.
double costWithin(const Eigen::Matrix3Xd& points, const SoftLimits::Limit& limit)
{
  double cost = 0.0;
  for (Index i = 0; i + limit.order < points.cols(); ++i)
  {
    Eigen::Vector3d d = Eigen::Vector3d::Zero();
    for (int a = 0; a <= limit.order; ++a) d += kStencil[limit.order][a] * points.col(i + a);
    cost += limit.weight * (d.cwiseAbs().array() - limit.limit).max(0.0).square().sum();
  }
  return cost;
}

/// The rows i of a group for which the a-th point of the difference is one of n points.
struct Overlap
{
  template <class Group>
  Overlap(const Group& group, int a, Index n)
  {
    const Index first = std::max<Index>(group.first_point, -a);
    const Index end = std::min(group.first_point + group.count, n - a);
    if (end <= first) return;
    row = group.first_row + 3 * (first - group.first_point);
    variable = 3 * (first + a);
    size = 3 * (end - first);
  }
  Index row = 0, variable = 0, size = 0;
};

}  // namespace

SoftLimits::SoftLimits(const Eigen::Matrix3Xd& before, Index variables,
                       const Eigen::Matrix3Xd& behind, std::vector<Limit> limits)
{
  std::erase_if(limits, [](const Limit& limit) { return limit.weight == 0.0; });
  Index rows = 0;
  for (const Limit& limit : limits)
  {
    const Index ahead = std::min<Index>(limit.order, before.cols());
    const Index after = std::min<Index>(limit.order, behind.cols());
    const Index count = std::max<Index>(0, ahead + variables + after - limit.order);
    groups_.push_back({limit.order, rows, -ahead, count});
    rows += 3 * count;
    constant_cost_ += costWithin(before, limit) + costWithin(behind, limit);
  }
  offset_ = ArrayXd::Zero(rows);
  limit_.resize(rows);
  weight_.resize(rows);
  for (std::size_t k = 0; k < groups_.size(); ++k)
  {
    const Group& group = groups_[k];
    limit_.segment(group.first_row, 3 * group.count) = limits[k].limit;
    weight_.segment(group.first_row, 3 * group.count) = limits[k].weight;
    for (Index i = 0; i < group.count; ++i)
      for (int a = 0; a <= group.order; ++a)
      {
        const Index point = group.first_point + i + a;
        const double s = kStencil[group.order][a];
        auto offset = offset_.segment<3>(group.first_row + 3 * i);
        if (point < 0) offset += s * before.col(before.cols() + point).array();
        if (point >= variables) offset += s * behind.col(point - variables).array();
      }
  }
}

void SoftLimits::changes(const VectorXd& dx, ArrayXd& d) const
{
  d.setZero(rows());
  for (const Group& group : groups_)
    for (int a = 0; a <= group.order; ++a)
    {
      const Overlap at(group, a, dx.size() / 3);
      d.segment(at.row, at.size) +=
          kStencil[group.order][a] * dx.segment(at.variable, at.size).array();
    }
}

void SoftLimits::differences(const VectorXd& x, ArrayXd& d) const
{
  changes(x, d);
  d += offset_;
}

void SoftLimits::addForce(const ArrayXd& force, VectorXd& gradient) const
{
  for (const Group& group : groups_)
    for (int a = 0; a <= group.order; ++a)
    {
      const Overlap at(group, a, gradient.size() / 3);
      gradient.segment(at.variable, at.size) +=
          kStencil[group.order][a] * force.segment(at.row, at.size).matrix();
    }
}

void SoftLimits::addStiffness(const ArrayXd& stiffness, BlockBand& hessian) const
{
  std::vector<Eigen::Matrix3d>* const bands[] = {&hessian.diagonal, &hessian.first,
                                                 &hessian.second};
  const Index n = hessian.blocks();
  for (const Group& group : groups_)
    for (int a = 0; a <= group.order; ++a)
      for (int b = a; b <= group.order; ++b)
      {
        const double s = kStencil[group.order][a] * kStencil[group.order][b];
        const Overlap at(group, a, n + a - b);  // both points are variables
        for (Index i = 0; i < at.size; i += 3)
          (*bands[b - a])[(at.variable + i) / 3].diagonal() +=
              s * stiffness.segment<3>(at.row + i).matrix();
      }
}

LimitedCost::LimitedCost(SoftLimits limits) : limits_(std::move(limits)), over_(limits_.rows()) {}

double LimitedCost::evaluate(const VectorXd& x, VectorXd& gradient)
{
  const double smooth = evaluateSmooth(x, gradient);
  limits_.differences(x, differences_);
  const ArrayXd& limit = limits_.limit();
  over_ = differences_ - differences_.max(-limit).min(limit);
  const double exceeding = (limits_.weight() * over_.square()).sum();
  over_ *= 2.0 * limits_.weight();
  limits_.addForce(over_, gradient);
  return smooth + exceeding + limits_.constantCost();
}

void LimitedCost::curvature(const VectorXd& x, BlockBand& hessian)
{
  curvatureSmooth(x, hessian);
  limits_.differences(x, differences_);
  over_ = (differences_.abs() > limits_.limit()).cast<double>() * 2.0 * limits_.weight();
  limits_.addStiffness(over_, hessian);
}

}  // namespace slalom::optim
