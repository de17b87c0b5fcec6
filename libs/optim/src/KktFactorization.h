// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

namespace slalom::optim::detail
{
/** L D L^T of the symmetric indefinite systems of an interior-point method, without pivoting.
 *
 *  Such a matrix is [W A^T; A -C] with W > 0 near a minimum. Zeros on its diagonal (C = 0) are
 * replaced by a tiny negative number, which makes it quasi-definite: then L D L^T exists for every
 * ordering, so one fill-reducing ordering serves all iterations. Refinement against the unchanged
 * matrix takes the replacement back. Signs of D are the inertia. For the small banded systems of a
 * horizon this is far cheaper than a pivoting solver. */
class KktFactorization
{
 public:
  /// Takes the pattern of the triplets (either triangle, repeated entries add up) and orders it.
  [[nodiscard]] bool analyze(int size, int entries, const int* rows, const int* cols, int base);
  [[nodiscard]] bool matches(int size, int entries) const
  {
    return size == size_ && entries == static_cast<int>(position_.size());
  }
  /// Values in the order of the analysed triplets. False if singular or not finite.
  [[nodiscard]] bool factorize(const double* values);
  [[nodiscard]] int negativeEigenvalues() const;
  /// Overwrites the right-hand side by the solution.
  void solveInPlace(Eigen::Ref<Eigen::VectorXd> x) const;

 private:
  using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
  int size_ = -1;
  std::vector<int> position_;  // of each triplet among the values of matrix_
  std::vector<int> diagonal_;  // of each diagonal entry
  Matrix matrix_, regular_;    // lower triangles: as given, and as factorised
  Eigen::SimplicialLDLT<Matrix, Eigen::Lower, Eigen::AMDOrdering<int>> ldlt_;
};

}  // namespace slalom::optim::detail
