// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "slalom/core/Rng.h"
#include "slalom/optim/BoxMinimizer.h"

namespace slalom::optim::test
{
/// A cost made of functions; the curvature may be left out where L-BFGS only is used.
struct FunctionCost final : BandedCost
{
  using Value = std::function<double(const Eigen::VectorXd&, Eigen::VectorXd&)>;
  using Curvature = std::function<void(const Eigen::VectorXd&, BlockBand&)>;
  explicit FunctionCost(Value v, Curvature c = {}) : value(std::move(v)), second(std::move(c)) {}
  double evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& gradient) override
  {
    return value(x, gradient);
  }
  void curvature(const Eigen::VectorXd& x, BlockBand& hessian) override
  {
    hessian.setZero();
    if (second) second(x, hessian);
  }
  Value value;
  Curvature second;
};

/// The blocks of a dense matrix that lie in the band.
inline void toBand(const Eigen::MatrixXd& dense, BlockBand& band)
{
  const Eigen::Index n = band.blocks();
  for (Eigen::Index k = 0; k < n; ++k)
  {
    band.diagonal[k] = dense.block<3, 3>(3 * k, 3 * k);
    if (k + 1 < n) band.first[k] = dense.block<3, 3>(3 * k + 3, 3 * k);
    if (k + 2 < n) band.second[k] = dense.block<3, 3>(3 * k + 6, 3 * k);
  }
}

/// L L^T + ridge with a random lower factor of the band's width.
inline Eigen::MatrixXd randomBandedMatrix(core::Rng& rng, Eigen::Index points, double ridge)
{
  const Eigen::Index n = 3 * points;
  Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j)
      if (i / 3 - j / 3 <= 2) factor(i, j) = rng.normal();
  return factor * factor.transpose() / 9.0 + ridge * Eigen::MatrixXd::Identity(n, n);
}

/// A convex quadratic whose minimum in its box is known by construction.
struct KnownMinimum final : BandedCost
{
  explicit KnownMinimum(std::uint64_t seed)
  {
    core::Rng rng(seed);
    const int points = rng.integer(1, 13), n = 3 * points;
    Q = randomBandedMatrix(rng, points, 0.5);
    minimum.resize(n), slope.resize(n), lower.resize(n), upper.resize(n), start.resize(n);
    for (int i = 0; i < n; ++i)
    {
      minimum[i] = rng.uniform(-3.0, 3.0);
      const int kind = rng.integer(0, 3);  // 0, 1: free; 2: at the lower bound; 3: at the upper
      slope[i] = kind < 2 ? 0.0 : (kind == 2 ? 1.0 : -1.0) * rng.uniform(0.1, 3.0);
      lower[i] = minimum[i] - (kind == 2 ? 0.0 : rng.uniform(0.1, 2.0));
      upper[i] = minimum[i] + (kind == 3 ? 0.0 : rng.uniform(0.1, 2.0));
      start[i] = rng.uniform(lower[i] - 1.0, upper[i] + 1.0);
    }
  }
  double evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& gradient) override
  {
    const Eigen::VectorXd e = x - minimum;
    gradient = Q * e + slope;
    return 0.5 * e.dot(Q * e) + slope.dot(e) + 1.0;
  }
  void curvature(const Eigen::VectorXd&, BlockBand& hessian) override { toBand(Q, hessian); }

  Eigen::MatrixXd Q;
  Eigen::VectorXd minimum, slope, lower, upper, start;
};

/// A quadratic and a quartic well per point, limits on both differences, and a box of which some
/// sides are active, some are missing and some leave no room.
struct LimitedProblem final : LimitedCost
{
  explicit LimitedProblem(std::uint64_t seed) : LimitedProblem(core::Rng(seed)) {}

  double evaluateSmooth(const Eigen::VectorXd& x, Eigen::VectorXd& gradient) override
  {
    const Eigen::VectorXd e = x - centre;
    const Eigen::ArrayXd cube = quartic * e.array().cube();
    gradient = Q * e + 4.0 * cube.matrix();
    return 0.5 * e.dot(Q * e) + (cube * e.array()).sum();
  }
  void curvatureSmooth(const Eigen::VectorXd& x, BlockBand& hessian) override
  {
    toBand(Q, hessian);
    for (Eigen::Index i = 0; i < x.size(); ++i)
      hessian.diagonal[i / 3](i % 3, i % 3) +=
          12.0 * quartic * (x[i] - centre[i]) * (x[i] - centre[i]);
  }

  Eigen::MatrixXd Q;
  double quartic;
  Eigen::VectorXd centre, start, lower, upper;

 private:
  explicit LimitedProblem(core::Rng rng) : LimitedCost(makeLimits(rng))
  {
    const Eigen::Index n = 3 * rng.integer(1, 20);  // the first number, here and in makeLimits()
    Q = randomBandedMatrix(rng, n / 3, rng.integer(0, 1) ? 0.1 : 1e-3);
    quartic = rng.integer(0, 1) ? rng.uniform(0.0, 0.3) : 0.0;
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    centre.resize(n), start.resize(n), lower.resize(n), upper.resize(n);
    for (Eigen::Index i = 0; i < n; ++i)
    {
      centre[i] = rng.uniform(-3.0, 3.0);
      start[i] = rng.uniform(-4.0, 4.0);
      lower[i] = rng.integer(0, 4) == 0 ? -kInfinity : rng.uniform(-4.0, 1.0);
      upper[i] = rng.integer(0, 4) == 0 ? kInfinity : rng.uniform(1.0, 4.0);
      if (rng.integer(0, 19) == 0) lower[i] = upper[i] = rng.uniform(-2.0, 2.0);
    }
  }
  static SoftLimits makeLimits(core::Rng rng)
  {
    const Eigen::Index n = rng.integer(1, 20);
    const auto fixed = [&rng]
    {
      Eigen::Matrix3Xd points(3, rng.integer(0, 3));
      for (Eigen::Index i = 0; i < points.cols(); ++i) points.col(i) = rng.uniform3(-3.0, 3.0);
      return points;
    };
    const auto weight = [&rng] { return std::pow(10.0, rng.uniform(-1.0, 3.0)); };
    std::vector<SoftLimits::Limit> limits{{1, rng.uniform(0.05, 2.0), weight()},
                                          {2, rng.uniform(0.02, 2.0), weight()}};
    if (rng.integer(0, 4) == 0) limits.pop_back();
    return SoftLimits(fixed(), n, fixed(), std::move(limits));
  }
};

}  // namespace slalom::optim::test
