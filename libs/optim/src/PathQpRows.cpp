// SPDX-License-Identifier: BSD-3-Clause
#include "PathQpRows.h"

#include <algorithm>
#include <cmath>

namespace slalom::optim::detail
{
namespace
{
/// Shrinks `step` so that value + step * change stays >= 0.
void limit(double value, double change, double& step)
{
  if (change < 0.0) step = std::min(step, -value / change);
}
}  // namespace

void PathQpRows::add(Eigen::Index point, const Eigen::Vector3d& normal, double bound)
{
  Row row;
  row.point = point;
  row.normal = normal;
  row.bound = bound;
  rows_.push_back(row);
}

void PathQpRows::initialize(const Eigen::Matrix3Xd& p, double length, double price)
{
  for (Row& row : rows_)
  {
    const double inside = row.bound - row.normal.dot(p.col(row.point));
    if (capped())
    {
      row.xi = 0.5 * cap_;
      row.t = 0.5 * cap_;
      row.u = price;
    }
    row.s = std::max(inside + row.xi, length);
    row.z = price * length / row.s;
  }
}

void PathQpRows::updateResiduals(const Eigen::Matrix3Xd& p)
{
  for (Row& row : rows_)
  {
    row.r_c = row.normal.dot(p.col(row.point)) - row.bound - row.xi + row.s;
    if (relaxation_ == Relaxation::Hard) continue;
    row.r_xi = 2.0 * weight_ * row.xi - row.z + row.u;
    if (capped()) row.r_t = row.xi + row.t - cap_;
  }
}

double PathQpRows::mu() const
{
  double sum = 0.0;
  for (const Row& row : rows_) sum += row.s * row.z + (capped() ? row.t * row.u : 0.0);
  return rows_.empty() ? 0.0 : sum / pairs();
}

double PathQpRows::primalResidual() const
{
  double worst = 0.0;
  for (const Row& row : rows_) worst = std::max({worst, std::abs(row.r_c), std::abs(row.r_t)});
  return worst;
}

double PathQpRows::multiplierResidual() const
{
  double worst = 0.0;
  for (const Row& row : rows_) worst = std::max(worst, std::abs(row.r_xi));
  return worst;
}

double PathQpRows::largestMultiplier() const
{
  double largest = 0.0;
  for (const Row& row : rows_) largest = std::max({largest, row.z, row.u});
  return largest;
}

double PathQpRows::relaxationCost() const
{
  double cost = 0.0;
  for (const Row& row : rows_) cost += weight_ * row.xi * row.xi;
  return relaxation_ == Relaxation::Hard ? 0.0 : cost;
}

void PathQpRows::addMultipliers(Eigen::Matrix3Xd& gradient) const
{
  for (const Row& row : rows_) gradient.col(row.point) += row.z * row.normal;
}

void PathQpRows::condense(BlockBand& matrix)
{
  for (Row& row : rows_)
  {
    const double a = row.z / row.s;
    const double d = capped() ? row.u / row.t : 0.0;
    const double soft = 2.0 * weight_ + d;
    // a (soft) / (soft + a) is the series connection of the two springs; no cancellation.
    row.w = relaxation_ == Relaxation::Hard ? a : a * soft / (soft + a);
    matrix.diagonal[row.point].noalias() += (row.w * row.normal) * row.normal.transpose();
  }
}

void PathQpRows::addRightHandSide(double centre, bool corrected, Eigen::Matrix3Xd& rhs)
{
  for (Row& row : rows_)
  {
    row.c_s = row.s * row.z - centre + (corrected ? row.ds * row.dz : 0.0);
    const double a = row.z / row.s;
    if (relaxation_ == Relaxation::Hard)
      row.e = a * row.r_c - row.c_s / row.s;
    else
    {
      double d = 0.0, push = row.r_xi;
      if (capped())
      {
        row.c_t = row.t * row.u - centre + (corrected ? row.dt * row.du : 0.0);
        d = row.u / row.t;
        push += d * row.r_t - row.c_t / row.t;
      }
      const double soft = 2.0 * weight_ + d;
      row.e = (a * (soft * row.r_c + push) - soft * row.c_s / row.s) / (soft + a);
    }
    rhs.col(row.point) -= row.e * row.normal;
  }
}

void PathQpRows::expand(const Eigen::Matrix3Xd& dp)
{
  for (Row& row : rows_)
  {
    const double along = row.normal.dot(dp.col(row.point));
    row.dz = row.e + row.w * along;
    if (relaxation_ != Relaxation::Hard)
    {
      const double a = row.z / row.s;
      double d = 0.0, push = -row.r_xi - row.c_s / row.s + a * (row.r_c + along);
      if (capped())
      {
        d = row.u / row.t;
        push += row.c_t / row.t - d * row.r_t;
      }
      row.dxi = push / (2.0 * weight_ + d + a);
      if (capped())
      {
        row.dt = -row.r_t - row.dxi;
        row.du = -row.c_t / row.t - d * row.dt;
      }
    }
    row.ds = -row.r_c - along + row.dxi;
  }
}

double PathQpRows::longestStep() const
{
  double step = 1.0;
  for (const Row& row : rows_)
  {
    limit(row.s, row.ds, step);
    limit(row.z, row.dz, step);
    if (!capped()) continue;
    limit(row.t, row.dt, step);
    limit(row.u, row.du, step);
  }
  return step;
}

double PathQpRows::muAfter(double step) const
{
  double sum = 0.0;
  for (const Row& row : rows_)
  {
    sum += (row.s + step * row.ds) * (row.z + step * row.dz);
    if (capped()) sum += (row.t + step * row.dt) * (row.u + step * row.du);
  }
  return rows_.empty() ? 0.0 : sum / pairs();
}

void PathQpRows::move(double step)
{
  for (Row& row : rows_)
  {
    row.s += step * row.ds;
    row.z += step * row.dz;
    row.xi += step * row.dxi;
    row.t += step * row.dt;
    row.u += step * row.du;
  }
}

}  // namespace slalom::optim::detail
