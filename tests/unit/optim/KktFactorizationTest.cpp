// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <limits>
#include <vector>

#include "KktFactorization.h"
#include "slalom/core/Rng.h"

namespace
{
using Eigen::MatrixXd;
using Eigen::VectorXd;
using slalom::core::Rng;
using slalom::optim::detail::KktFactorization;

/// [W A^T; A 0] as triplets of mixed triangles with repeated entries, and dense.
struct Kkt
{
  explicit Kkt(std::uint64_t seed)
  {
    Rng rng(seed);
    const int n = rng.integer(2, 40), m = rng.integer(1, n - 1);
    dense = MatrixXd::Zero(n + m, n + m);
    for (int i = 0; i < n; ++i) add(i, i, rng.uniform(0.1, 5.0));
    for (int i = 0; i + 1 < n; ++i)
      if (rng.integer(0, 2) == 0) add(i + 1, i, rng.uniform(-0.04, 0.04));
    for (int i = 0; i < m; ++i)
    {
      add(n + i, i, rng.uniform(0.5, 2.0));  // full row rank
      add(i, n + i, rng.uniform(0.1, 0.5));
      for (int k = i + 1; k < n; ++k)
        if (rng.integer(0, 5) == 0) add(n + i, k, rng.normal());
    }
    constraints = m;
  }
  void add(int row, int col, double value)
  {
    rows.push_back(row + 1);
    cols.push_back(col + 1);
    values.push_back(value);
    dense(row, col) += value;
    if (row != col) dense(col, row) += value;
  }
  [[nodiscard]] int entries() const { return static_cast<int>(values.size()); }
  [[nodiscard]] int size() const { return static_cast<int>(dense.rows()); }
  std::vector<int> rows, cols;
  std::vector<double> values;
  MatrixXd dense;
  int constraints = 0;
};

TEST(KktFactorization, SolvesAndCountsNegativeEigenvalues)
{
  for (std::uint64_t seed = 1; seed <= 300; ++seed)
  {
    SCOPED_TRACE(seed);
    const Kkt kkt(seed);
    KktFactorization factorization;
    ASSERT_TRUE(
        factorization.analyze(kkt.size(), kkt.entries(), kkt.rows.data(), kkt.cols.data(), 1));
    ASSERT_TRUE(factorization.factorize(kkt.values.data()));
    EXPECT_EQ(factorization.negativeEigenvalues(), kkt.constraints);
    Rng rng(seed);
    const VectorXd rhs = VectorXd::NullaryExpr(kkt.size(), [&] { return rng.normal(); });
    VectorXd x = rhs;
    factorization.solveInPlace(x);
    EXPECT_LE((kkt.dense * x - rhs).lpNorm<Eigen::Infinity>(), 1e-10);
  }
}

TEST(KktFactorization, AWrongCurvatureShowsInTheInertia)
{
  for (std::uint64_t seed = 1; seed <= 100; ++seed)
  {
    SCOPED_TRACE(seed);
    Kkt kkt(seed);
    const int at = kkt.size() - kkt.constraints - 1;  // the last variable, tied by no pivot row
    kkt.add(at, at, -20.0);
    const auto exact = Eigen::SelfAdjointEigenSolver<MatrixXd>(kkt.dense).eigenvalues();
    KktFactorization factorization;
    ASSERT_TRUE(
        factorization.analyze(kkt.size(), kkt.entries(), kkt.rows.data(), kkt.cols.data(), 1));
    ASSERT_TRUE(factorization.factorize(kkt.values.data()));
    EXPECT_EQ(factorization.negativeEigenvalues(), (exact.array() < 0.0).count());
  }
}

TEST(KktFactorization, RefusesWhatIsNotFinite)
{
  Kkt kkt(4);
  KktFactorization factorization;
  ASSERT_TRUE(
      factorization.analyze(kkt.size(), kkt.entries(), kkt.rows.data(), kkt.cols.data(), 1));
  kkt.values[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(factorization.factorize(kkt.values.data()));
  kkt.rows[0] = kkt.size() + 5;
  EXPECT_FALSE(
      factorization.analyze(kkt.size(), kkt.entries(), kkt.rows.data(), kkt.cols.data(), 1));
}

}  // namespace
