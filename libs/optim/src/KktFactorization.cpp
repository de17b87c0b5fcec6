// SPDX-License-Identifier: BSD-3-Clause
#include "KktFactorization.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slalom::optim::detail
{
namespace
{
constexpr double kReplacement = 1e-8;  // for a zero on the diagonal
constexpr int kMaxRefinements = 4;
constexpr double kAccuracy = 1e-12;  // of the residual, relative to the right-hand side
}  // namespace

bool KktFactorization::analyze(int size, int entries, const int* rows, const int* cols, int base)
{
  size_ = size;
  std::vector<Eigen::Triplet<double, int>> triplets;
  triplets.reserve(static_cast<std::size_t>(entries + size));
  for (int i = 0; i < entries; ++i)
  {
    const int low = std::min(rows[i], cols[i]) - base, high = std::max(rows[i], cols[i]) - base;
    if (low < 0 || high >= size) return false;
    triplets.emplace_back(high, low, 0.0);
  }
  for (int i = 0; i < size; ++i) triplets.emplace_back(i, i, 0.0);  // room for replacements
  matrix_.resize(size, size);
  matrix_.setFromTriplets(triplets.begin(), triplets.end());
  const auto find = [this](int row, int col)
  {
    const int* begin = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[col];
    const int* end = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[col + 1];
    return static_cast<int>(std::lower_bound(begin, end, row) - matrix_.innerIndexPtr());
  };
  position_.resize(static_cast<std::size_t>(entries));
  for (int i = 0; i < entries; ++i) position_[i] = find(triplets[i].row(), triplets[i].col());
  diagonal_.resize(static_cast<std::size_t>(size));
  for (int i = 0; i < size; ++i) diagonal_[i] = find(i, i);
  regular_ = matrix_;
  ldlt_.analyzePattern(regular_);
  return true;
}

bool KktFactorization::factorize(const double* values)
{
  double* sum = matrix_.valuePtr();
  std::fill(sum, sum + matrix_.nonZeros(), 0.0);
  for (std::size_t i = 0; i < position_.size(); ++i) sum[position_[i]] += values[i];
  std::copy(sum, sum + matrix_.nonZeros(), regular_.valuePtr());
  for (const int at : diagonal_)
    if (std::abs(regular_.valuePtr()[at]) < kReplacement) regular_.valuePtr()[at] = -kReplacement;
  ldlt_.factorize(regular_);
  return ldlt_.info() == Eigen::Success && ldlt_.vectorD().allFinite();
}

int KktFactorization::negativeEigenvalues() const
{
  return static_cast<int>((ldlt_.vectorD().array() < 0.0).count());
}

void KktFactorization::solveInPlace(Eigen::Ref<Eigen::VectorXd> x) const
{
  const Eigen::VectorXd rhs = x;
  const double enough = kAccuracy * rhs.lpNorm<Eigen::Infinity>();
  Eigen::VectorXd best = ldlt_.solve(rhs), residual(rhs.size());
  double best_error = std::numeric_limits<double>::infinity();
  Eigen::VectorXd trial = best;
  for (int i = 0; i <= kMaxRefinements; ++i)
  {
    residual = rhs;
    residual.noalias() -= matrix_.selfadjointView<Eigen::Lower>() * trial;
    const double error = residual.lpNorm<Eigen::Infinity>();
    if (!(error < 0.5 * best_error)) break;  // also when not finite
    best = trial;
    best_error = error;
    if (error <= enough) break;
    trial += ldlt_.solve(residual);
  }
  x = best;
}

}  // namespace slalom::optim::detail
