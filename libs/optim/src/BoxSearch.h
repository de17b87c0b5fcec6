// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <exception>
#include <limits>
#include <string>

#include "slalom/optim/BoxMinimizer.h"

namespace slalom::optim::detail
{
/// What both methods are given; the start lies inside the box.
struct BoxProblem
{
  BandedCost& cost;
  const Eigen::VectorXd& start;
  const Eigen::VectorXd& lower;
  const Eigen::VectorXd& upper;
  const BoxMinimizerConfig& config;
  const core::Deadline& deadline;
};

/// What both methods hand back: the best point seen with its cost and gradient, and why they
/// stopped.
struct BoxResult
{
  Eigen::VectorXd x, gradient;  ///< empty until a finite cost was seen
  double cost = std::numeric_limits<double>::infinity();
  int evaluations = 0, iterations = 0;
  core::Termination termination = core::Termination::NumericalFailure;
  std::string message;

  void stop(core::Termination why, std::string in_words)
  {
    termination = why;
    message = std::move(in_words);
  }
};

/// False, and says why in `result`, when no further evaluation is allowed. The first one always is:
/// its point is the best there is.
[[nodiscard]] bool mayEvaluate(const BoxProblem& problem, BoxResult& result);

/// evaluate() fills `gradient`, which shall have n entries, and returns the cost. Says why in
/// `failure` when it throws or anything is not finite.
template <class Evaluate>
[[nodiscard]] double evaluateSafely(const Evaluate& evaluate, Eigen::Index n,
                                    const Eigen::VectorXd& gradient, std::string& failure)
{
  double cost = std::numeric_limits<double>::infinity();
  try
  {
    cost = evaluate();
  }
  catch (const std::exception& error)
  {
    failure = std::string("the cost function threw: ") + error.what();
  }
  catch (...)
  {
    failure = "the cost function threw";
  }
  if (failure.empty() && (!std::isfinite(cost) || gradient.size() != n || !gradient.allFinite()))
    failure = "cost or gradient is not finite";
  return cost;
}

/// Largest move of one gradient step that the box permits; zero exactly at a KKT point.
[[nodiscard]] double projectedGradient(const BoxProblem& problem, const Eigen::VectorXd& x,
                                       const Eigen::VectorXd& gradient);

void addToDiagonal(BlockBand& matrix, const Eigen::ArrayXd& values);

/// Takes the variables i with held(i) out of a symmetric system: their rows and columns become
/// those of the identity.
template <class Held>
void hold(BlockBand& matrix, const Held& held)
{
  for (Eigen::Index k = 0; k < matrix.blocks(); ++k)
    for (int j = 0; j < 3; ++j)
    {
      if (!held(3 * k + j)) continue;
      matrix.diagonal[k].row(j).setZero();
      matrix.diagonal[k].col(j).setZero();
      matrix.diagonal[k](j, j) = 1.0;
      matrix.first[k].col(j).setZero();
      matrix.second[k].col(j).setZero();
      if (k >= 1) matrix.first[k - 1].row(j).setZero();
      if (k >= 2) matrix.second[k - 2].row(j).setZero();
    }
}

[[nodiscard]] BoxResult minimizeByLbfgs(const BoxProblem& problem);
[[nodiscard]] BoxResult minimizeByNewton(const BoxProblem& problem);

}  // namespace slalom::optim::detail
