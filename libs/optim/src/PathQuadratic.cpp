// SPDX-License-Identifier: BSD-3-Clause
#include "PathQuadratic.h"

namespace slalom::optim::detail
{
namespace
{
using Eigen::Index;
using Eigen::Matrix3Xd;

void addIsotropic(Eigen::Matrix3d& block, double value)
{
  block.diagonal().array() += value;
}
}  // namespace

double PathQuadratic::cost(const Matrix3Xd& p) const
{
  double sum =
      w_start * (p.col(0) - first).squaredNorm() + w_end * (p.col(points - 1) - last).squaredNorm();
  for (Index k = 0; k + 1 < points; ++k) sum += w_length * (p.col(k + 1) - p.col(k)).squaredNorm();
  for (Index k = 1; k + 1 < points; ++k)
    sum += w_bend * (p.col(k + 1) - 2.0 * p.col(k) + p.col(k - 1)).squaredNorm();
  return sum;
}

PartState PathQuadratic::linearize(const Matrix3Xd& p, BlockBand& matrix, Matrix3Xd& gradient)
{
  const auto n = static_cast<std::size_t>(points);
  addIsotropic(matrix.diagonal[0], 2.0 * w_start);
  addIsotropic(matrix.diagonal[n - 1], 2.0 * w_end);
  gradient.col(0) += 2.0 * w_start * (p.col(0) - first);
  gradient.col(points - 1) += 2.0 * w_end * (p.col(points - 1) - last);
  for (std::size_t k = 0; k + 1 < n; ++k)
  {
    const auto i = static_cast<Index>(k);
    addIsotropic(matrix.diagonal[k], 2.0 * w_length);
    addIsotropic(matrix.diagonal[k + 1], 2.0 * w_length);
    addIsotropic(matrix.first[k], -2.0 * w_length);
    const Eigen::Vector3d pull = 2.0 * w_length * (p.col(i + 1) - p.col(i));
    gradient.col(i) -= pull;
    gradient.col(i + 1) += pull;
  }
  for (std::size_t k = 0; k + 2 < n; ++k)
  {
    const auto i = static_cast<Index>(k);
    addIsotropic(matrix.diagonal[k], 2.0 * w_bend);
    addIsotropic(matrix.diagonal[k + 1], 8.0 * w_bend);
    addIsotropic(matrix.diagonal[k + 2], 2.0 * w_bend);
    addIsotropic(matrix.first[k], -4.0 * w_bend);
    addIsotropic(matrix.first[k + 1], -4.0 * w_bend);
    addIsotropic(matrix.second[k], 2.0 * w_bend);
    const Eigen::Vector3d bend = 2.0 * w_bend * (p.col(i + 2) - 2.0 * p.col(i + 1) + p.col(i));
    gradient.col(i) += bend;
    gradient.col(i + 1) -= 2.0 * bend;
    gradient.col(i + 2) += bend;
  }
  return {};
}

}  // namespace slalom::optim::detail
