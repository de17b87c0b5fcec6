// SPDX-License-Identifier: BSD-3-Clause
#include "BlockBandCholesky.h"

#include <cmath>

namespace slalom::optim::detail
{
namespace
{
using Eigen::Index;
using Eigen::Matrix3d;

/// In-place lower Cholesky of one block; written out, because at this size
/// a general routine costs more in calls than in arithmetic.
bool choleskyOfBlock(Matrix3d& a)
{
  for (int j = 0; j < 3; ++j)
  {
    for (int i = 0; i < j; ++i) a(j, j) -= a(j, i) * a(j, i);
    if (!(a(j, j) > 0.0) || !std::isfinite(a(j, j))) return false;
    a(j, j) = std::sqrt(a(j, j));
    for (int r = j + 1; r < 3; ++r)
    {
      for (int i = 0; i < j; ++i) a(r, j) -= a(r, i) * a(j, i);
      a(r, j) /= a(j, j);
    }
    for (int c = j + 1; c < 3; ++c) a(j, c) = 0.0;
  }
  return true;
}

/// X <- X L^-T for lower-triangular L.
void divideByTranspose(Matrix3d& x, const Matrix3d& l)
{
  for (int j = 0; j < 3; ++j)
  {
    for (int i = 0; i < j; ++i) x.col(j) -= l(j, i) * x.col(i);
    x.col(j) /= l(j, j);
  }
}

Eigen::Vector3d forward(const Matrix3d& l, Eigen::Vector3d y)
{
  y[0] /= l(0, 0);
  y[1] = (y[1] - l(1, 0) * y[0]) / l(1, 1);
  y[2] = (y[2] - l(2, 0) * y[0] - l(2, 1) * y[1]) / l(2, 2);
  return y;
}

Eigen::Vector3d backward(const Matrix3d& l, Eigen::Vector3d y)
{
  y[2] /= l(2, 2);
  y[1] = (y[1] - l(2, 1) * y[2]) / l(1, 1);
  y[0] = (y[0] - l(1, 0) * y[1] - l(2, 0) * y[2]) / l(0, 0);
  return y;
}
}  // namespace

bool BlockBandCholesky::compute(const BlockBand& matrix)
{
  const Index n = matrix.blocks();
  auto& [diagonal, first, second] = factor_;
  for (Index k = 0; k < n; ++k)
  {
    diagonal[k] = matrix.diagonal[k];
    if (k >= 1) diagonal[k].noalias() -= first[k - 1] * first[k - 1].transpose();
    if (k >= 2) diagonal[k].noalias() -= second[k - 2] * second[k - 2].transpose();
    if (!choleskyOfBlock(diagonal[k])) return false;
    if (k + 1 < n)
    {
      first[k] = matrix.first[k];
      if (k >= 1) first[k].noalias() -= second[k - 1] * first[k - 1].transpose();
      divideByTranspose(first[k], diagonal[k]);
    }
    if (k + 2 < n)
    {
      second[k] = matrix.second[k];
      divideByTranspose(second[k], diagonal[k]);
    }
  }
  return true;
}

void BlockBandCholesky::solveInPlace(Eigen::Matrix3Xd& x) const
{
  const Index n = factor_.blocks();
  for (Index k = 0; k < n; ++k)
  {
    if (k >= 1) x.col(k) -= factor_.first[k - 1] * x.col(k - 1);
    if (k >= 2) x.col(k) -= factor_.second[k - 2] * x.col(k - 2);
    x.col(k) = forward(factor_.diagonal[k], x.col(k));
  }
  for (Index k = n - 1; k >= 0; --k)
  {
    if (k + 1 < n) x.col(k) -= factor_.first[k].transpose() * x.col(k + 1);
    if (k + 2 < n) x.col(k) -= factor_.second[k].transpose() * x.col(k + 2);
    x.col(k) = backward(factor_.diagonal[k], x.col(k));
  }
}

}  // namespace slalom::optim::detail
