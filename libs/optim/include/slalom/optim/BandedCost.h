// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "slalom/optim/BlockBand.h"

namespace slalom::optim
{
/** A cost over the points of a path: the variables are points in space, stacked (x1 y1 z1 x2 ...),
 * and each point is coupled with no more than its next two neighbours on either side. */
class BandedCost
{
 public:
  virtual ~BandedCost() = default;

  /// Value at x; fills the gradient, which comes with the size of x.
  [[nodiscard]] virtual double evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& gradient) = 0;

  /** Second derivatives at x; overwrites all blocks of `hessian`, which comes with x.size() / 3 of
   * them. Where the gradient has a kink, those of either side. Only second-order methods ask. */
  virtual void curvature(const Eigen::VectorXd& x, BlockBand& hessian) = 0;
};

/** Limits on the differences between the points of a path that may be exceeded at a price:
 *
 *    weight * sum over axes and neighbours of (|d| - limit)_+^2,
 *    d = c_{i+1} - c_i (order 1) or c_{i+2} - 2 c_{i+1} + c_i (order 2).
 *
 *  The path is `before` (fixed), the variables, `behind` (fixed). Differences of all axes lie in
 * one array d(x) = D x + constant; terms that no variable moves are left out of it. */
class SoftLimits
{
 public:
  struct Limit
  {
    int order = 1;        ///< 1 or 2
    double limit = 1.0;   ///< [unit of x], > 0
    double weight = 1.0;  ///< >= 0
  };

  /// @param before, behind fixed points, one per column; may be empty
  SoftLimits(const Eigen::Matrix3Xd& before, Eigen::Index variables, const Eigen::Matrix3Xd& behind,
             std::vector<Limit> limits);

  [[nodiscard]] Eigen::Index rows() const { return limit_.size(); }
  [[nodiscard]] const Eigen::ArrayXd& limit() const { return limit_; }    ///< of each row
  [[nodiscard]] const Eigen::ArrayXd& weight() const { return weight_; }  ///< of each row
  /// Cost of the terms between fixed points.
  [[nodiscard]] double constantCost() const { return constant_cost_; }

  /// d = D x + constant.
  void differences(const Eigen::VectorXd& x, Eigen::ArrayXd& d) const;
  /// d = D dx.
  void changes(const Eigen::VectorXd& dx, Eigen::ArrayXd& d) const;
  /// gradient += D^T force.
  void addForce(const Eigen::ArrayXd& force, Eigen::VectorXd& gradient) const;
  /// hessian += D^T diag(stiffness) D.
  void addStiffness(const Eigen::ArrayXd& stiffness, BlockBand& hessian) const;

 private:
  struct Group  // the rows of one limit
  {
    int order;
    Eigen::Index first_row, first_point, count;  // of differences; point 0 is the first variable
  };

  Eigen::ArrayXd offset_, limit_, weight_;
  std::vector<Group> groups_;
  double constant_cost_ = 0.0;
};

/** A twice differentiable cost plus soft limits. Saying so lets BoxMethod::Newton take the limits
 * for what they are instead of running into their kinks: some ten iterations instead of fifty. */
class LimitedCost : public BandedCost
{
 public:
  explicit LimitedCost(SoftLimits limits);

  /// The part without the limits; the gradient comes with the size of x.
  [[nodiscard]] virtual double evaluateSmooth(const Eigen::VectorXd& x,
                                              Eigen::VectorXd& gradient) = 0;
  /// Overwrites the blocks by the second derivatives of that part.
  virtual void curvatureSmooth(const Eigen::VectorXd& x, BlockBand& hessian) = 0;

  [[nodiscard]] double evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& gradient) final;
  void curvature(const Eigen::VectorXd& x, BlockBand& hessian) final;

  [[nodiscard]] const SoftLimits& limits() const { return limits_; }

 private:
  SoftLimits limits_;
  Eigen::ArrayXd differences_, over_;
};

}  // namespace slalom::optim
