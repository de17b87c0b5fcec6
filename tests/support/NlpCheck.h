// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace slalom::test
{
/** Compares every derivative of a slalom::optim::NonlinearProgram with central differences: the
 * gradient with the cost, the Jacobian with the constraints, the Hessian of
 * sigma f + sum lambda g with the first derivatives. A derivative outside the announced structure
 * shows as a difference, too. Relative to 1 + the largest entry.
 *  @param tolerance of first derivatives; second ones get ten times that */
template <class Program>
void expectExactDerivatives(const Program& program, const Eigen::VectorXd& x, double sigma,
                            const Eigen::VectorXd& lambda, double tolerance = 1e-6)
{
  using Eigen::MatrixXd;
  using Eigen::VectorXd;
  const int n = program.variables(), m = program.constraints();
  const auto jacobian_at = [&](const VectorXd& at)
  {
    const auto entries = program.jacobianStructure();
    VectorXd values(entries.size());
    program.jacobian(at, values);
    MatrixXd dense = MatrixXd::Zero(m, n);
    for (std::size_t i = 0; i < entries.size(); ++i)
      dense(entries[i].row, entries[i].col) += values[i];
    return dense;
  };
  const auto gradient_at = [&](const VectorXd& at)
  {
    VectorXd gradient(n);
    program.gradient(at, gradient);
    return gradient;
  };
  const auto entries = program.hessianStructure();
  VectorXd values(entries.size());
  program.hessian(x, sigma, lambda, values);
  MatrixXd hessian = MatrixXd::Zero(n, n);
  for (std::size_t i = 0; i < entries.size(); ++i)
  {
    ASSERT_GE(entries[i].row, entries[i].col) << "lower triangle only";
    hessian(entries[i].row, entries[i].col) += values[i];
    if (entries[i].row != entries[i].col) hessian(entries[i].col, entries[i].row) += values[i];
  }

  VectorXd gradient_difference(n);
  MatrixXd jacobian_difference(m, n), hessian_difference(n, n);
  for (int i = 0; i < n; ++i)
  {
    const double h = 1e-5 * std::max(1.0, std::abs(x[i]));
    VectorXd up = x, down = x;
    up[i] += h;
    down[i] -= h;
    gradient_difference[i] = (program.cost(up) - program.cost(down)) / (2.0 * h);
    VectorXd g_up(m), g_down(m);
    program.constraint(up, g_up);
    program.constraint(down, g_down);
    jacobian_difference.col(i) = (g_up - g_down) / (2.0 * h);
    const auto lagrangian = [&](const VectorXd& at) -> VectorXd
    { return sigma * gradient_at(at) + jacobian_at(at).transpose() * lambda; };
    hessian_difference.col(i) = (lagrangian(up) - lagrangian(down)) / (2.0 * h);
  }
  const auto expect_equal =
      [](const MatrixXd& exact, const MatrixXd& difference, double bound, const char* what)
  {
    if (exact.size() == 0) return;
    const double scale = 1.0 + difference.cwiseAbs().maxCoeff();
    EXPECT_LE((exact - difference).cwiseAbs().maxCoeff() / scale, bound) << what;
  };
  expect_equal(gradient_at(x), gradient_difference, tolerance, "gradient of the cost");
  expect_equal(jacobian_at(x), jacobian_difference, tolerance, "Jacobian of the constraints");
  expect_equal(hessian, hessian_difference, 10.0 * tolerance, "Hessian of the Lagrangian");
}

}  // namespace slalom::test
