// SPDX-License-Identifier: BSD-3-Clause
#include "BlockBandCholesky.h"

#include <algorithm>
#include <cmath>

namespace slalom::optim::detail
{
namespace
{
using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// In-place lower Cholesky of one block with inverted diagonal; written out, because at this size
/// a general routine costs more in calls than in arithmetic, and divisions more than all the rest.
bool choleskyOfBlock(Matrix3d& a)
{
  double smallest = a(0, 0);
  const double i0 = 1.0 / std::sqrt(a(0, 0));
  const double l10 = a(1, 0) * i0, l20 = a(2, 0) * i0;
  const double d1 = a(1, 1) - l10 * l10;
  smallest = std::min(smallest, d1);
  const double i1 = 1.0 / std::sqrt(d1);
  const double l21 = (a(2, 1) - l20 * l10) * i1;
  const double d2 = a(2, 2) - l20 * l20 - l21 * l21;
  smallest = std::min(smallest, d2);
  const double i2 = 1.0 / std::sqrt(d2);
  a << i0, 0.0, 0.0, l10, i1, 0.0, l20, l21, i2;
  return smallest > 0.0 && std::isfinite(i0 + i1 + i2);
}

/// X <- X L^-T for a factor of choleskyOfBlock().
void divideByTranspose(Matrix3d& x, const Matrix3d& l)
{
  x.col(0) *= l(0, 0);
  x.col(1) = (x.col(1) - l(1, 0) * x.col(0)) * l(1, 1);
  x.col(2) = (x.col(2) - l(2, 0) * x.col(0) - l(2, 1) * x.col(1)) * l(2, 2);
}

Vector3d forward(const Matrix3d& l, Vector3d y)
{
  y[0] *= l(0, 0);
  y[1] = (y[1] - l(1, 0) * y[0]) * l(1, 1);
  y[2] = (y[2] - l(2, 0) * y[0] - l(2, 1) * y[1]) * l(2, 2);
  return y;
}

Vector3d backward(const Matrix3d& l, Vector3d y)
{
  y[2] *= l(2, 2);
  y[1] = (y[1] - l(2, 1) * y[2]) * l(1, 1);
  y[0] = (y[0] - l(1, 0) * y[1] - l(2, 0) * y[2]) * l(0, 0);
  return y;
}
}  // namespace

bool BlockBandCholesky::compute(const BlockBand& matrix)
{
  const std::size_t n = matrix.diagonal.size();
  const bool wide = !matrix.second.empty();
  auto& [diagonal, first, second] = factor_;
  for (std::size_t k = 0; k < n; ++k)
  {
    Matrix3d pivot = matrix.diagonal[k];
    if (k >= 1) pivot.noalias() -= first[k - 1] * first[k - 1].transpose();
    if (wide && k >= 2) pivot.noalias() -= second[k - 2] * second[k - 2].transpose();
    if (!choleskyOfBlock(pivot)) return false;
    diagonal[k] = pivot;
    if (k + 1 < n)
    {
      Matrix3d next = matrix.first[k];
      if (wide && k >= 1) next.noalias() -= second[k - 1] * first[k - 1].transpose();
      divideByTranspose(next, pivot);
      first[k] = next;
    }
    if (wide && k + 2 < n)
    {
      Matrix3d over_next = matrix.second[k];
      divideByTranspose(over_next, pivot);
      second[k] = over_next;
    }
  }
  return true;
}

void BlockBandCholesky::solveInPlace(Eigen::Matrix3Xd& x) const
{
  const Index n = factor_.blocks();
  const bool wide = !factor_.second.empty();
  for (Index k = 0; k < n; ++k)
  {
    Vector3d y = x.col(k);
    if (k >= 1) y.noalias() -= factor_.first[k - 1] * x.col(k - 1);
    if (wide && k >= 2) y.noalias() -= factor_.second[k - 2] * x.col(k - 2);
    x.col(k) = forward(factor_.diagonal[k], y);
  }
  for (Index k = n - 1; k >= 0; --k)
  {
    Vector3d y = x.col(k);
    if (k + 1 < n) y.noalias() -= factor_.first[k].transpose() * x.col(k + 1);
    if (wide && k + 2 < n) y.noalias() -= factor_.second[k].transpose() * x.col(k + 2);
    x.col(k) = backward(factor_.diagonal[k], y);
  }
}

}  // namespace slalom::optim::detail
