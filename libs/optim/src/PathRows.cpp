// SPDX-License-Identifier: BSD-3-Clause
#include "PathRows.h"

#include <algorithm>
#include <type_traits>

namespace slalom::optim::detail
{
namespace
{
using Eigen::Index;
using Eigen::Matrix3Xd;
using Four = Eigen::Array4d;

/// Sums over the rows of one point of the terms c a a^T and f a.
struct PointSums
{
  Four xx = Four::Zero(), xy = Four::Zero(), xz = Four::Zero();
  Four yy = Four::Zero(), yz = Four::Zero(), zz = Four::Zero();
  Four fx = Four::Zero(), fy = Four::Zero(), fz = Four::Zero();

  template <class Lanes>
  void addCurvature(const Lanes& row, const Four& c)
  {
    const Four cx = c * row.nx, cy = c * row.ny, cz = c * row.nz;
    xx += cx * row.nx, xy += cx * row.ny, xz += cx * row.nz;
    yy += cy * row.ny, yz += cy * row.nz, zz += cz * row.nz;
  }
  template <class Lanes>
  void addForce(const Lanes& row, const Four& f)
  {
    fx += f * row.nx, fy += f * row.ny, fz += f * row.nz;
  }
  [[nodiscard]] Eigen::Matrix3d curvature() const
  {
    Eigen::Matrix3d m;
    m(0, 0) = xx.sum(), m(1, 1) = yy.sum(), m(2, 2) = zz.sum();
    m(1, 0) = m(0, 1) = xy.sum();
    m(2, 0) = m(0, 2) = xz.sum();
    m(2, 1) = m(1, 2) = yz.sum();
    return m;
  }
  [[nodiscard]] Eigen::Vector3d force() const { return {fx.sum(), fy.sum(), fz.sum()}; }
};
}  // namespace

PathRows::PathRows(const PathSets& sets, const Eigen::Vector3d& origin, double tighten,
                   Relaxation relaxation, double weight, double cap)
    : relaxation_(relaxation), weight_(weight), cap_(cap)
{
  std::size_t lanes = 0;
  for (const auto& of_point : sets)
  {
    Index rows = 0;
    for (const core::HalfSpaces* set : of_point) rows += set->rows();
    lanes += static_cast<std::size_t>((rows + 3) / 4);
  }
  lanes_.reserve(lanes);
  groups_.reserve(sets.size());
  for (std::size_t k = 0; k < sets.size(); ++k)
  {
    const std::size_t begin = lanes_.size();
    int lane = 4;
    for (const core::HalfSpaces* set : sets[k])
      for (Index i = 0; i < set->rows(); ++i)
      {
        if (lane == 4)
        {
          lanes_.emplace_back();
          lane = 0;
        }
        Lanes& row = lanes_.back();
        const auto normal = set->A.row(i);
        row.nx[lane] = normal.x(), row.ny[lane] = normal.y(), row.nz[lane] = normal.z();
        row.bound[lane] = set->b[i] - normal.dot(origin) - tighten;
        ++lane;
      }
    if (lanes_.size() > begin) groups_.push_back({static_cast<Index>(k), begin, lanes_.size()});
  }
}

template <class Call>
auto PathRows::dispatch(Call&& call)
{
  using Kind = Relaxation;
  switch (relaxation_)
  {
    case Kind::Capped:
      return call(std::integral_constant<Kind, Kind::Capped>{});
    case Kind::Elastic:
      return call(std::integral_constant<Kind, Kind::Elastic>{});
    case Kind::Hard:
      break;
  }
  return call(std::integral_constant<Kind, Kind::Hard>{});
}

void PathRows::initialize(const Matrix3Xd& p, double length, double price)
{
  for (const Group& group : groups_)
    for (std::size_t i = group.begin; i < group.end; ++i)
    {
      Lanes& row = lanes_[i];
      if (relaxation_ == Relaxation::Capped)
      {
        row.xi.setConstant(0.5 * cap_);
        row.t.setConstant(0.5 * cap_);
        row.u.setConstant(price);
      }
      row.s = (row.bound - row.along(p.col(group.point)) + row.xi).max(length);
      row.z = price * length / row.s;
    }
}

template <PathRows::Relaxation kind>
PartState PathRows::linearizeAs(const Matrix3Xd& p, BlockBand& matrix, Matrix3Xd& gradient)
{
  Four pairs = Four::Zero(), primal = Four::Zero(), dual = Four::Zero(), largest = Four::Zero();
  for (const Group& group : groups_)
  {
    const Eigen::Vector3d at = p.col(group.point);
    PointSums sums;
    for (std::size_t i = group.begin; i < group.end; ++i)
    {
      Lanes& row = lanes_[i];
      row.r_c = row.along(at) - row.bound + row.s;
      row.over_s = row.s.inverse();
      row.w = row.z * row.over_s;
      pairs += row.s * row.z;
      largest = largest.max(row.z);
      if constexpr (kind != Relaxation::Hard)
      {
        row.r_c -= row.xi;
        row.r_xi = 2.0 * weight_ * row.xi - row.z;
        Four soft = Four::Constant(2.0 * weight_);
        if constexpr (kind == Relaxation::Capped)
        {
          row.r_xi += row.u;
          row.r_t = row.xi + row.t - cap_;
          row.over_t = row.t.inverse();
          soft += row.u * row.over_t;
          pairs += row.t * row.u;
          largest = largest.max(row.u);
          primal = primal.max(row.r_t.abs());
        }
        dual = dual.max(row.r_xi.abs());
        // The series connection of the two springs; no cancellation.
        row.over_stiffness = (soft + row.w).inverse();
        row.w *= soft * row.over_stiffness;
      }
      primal = primal.max(row.r_c.abs());
      sums.addCurvature(row, row.w);
      sums.addForce(row, row.z);
    }
    matrix.diagonal[static_cast<std::size_t>(group.point)] += sums.curvature();
    gradient.col(group.point) += sums.force();
  }
  PartState state;
  state.pairs = 4.0 * static_cast<double>(lanes_.size()) * (kind == Relaxation::Capped ? 2.0 : 1.0);
  state.complementarity = pairs.sum();
  state.primal_residual = primal.maxCoeff();
  state.multiplier_residual = dual.maxCoeff();
  state.largest_multiplier = largest.maxCoeff();
  return state;
}

template <PathRows::Relaxation kind>
void PathRows::addRightHandSideAs(double centre, double corrected, Matrix3Xd& rhs)
{
  for (const Group& group : groups_)
  {
    PointSums sums;
    for (std::size_t i = group.begin; i < group.end; ++i)
    {
      Lanes& row = lanes_[i];
      row.c_s = row.s * row.z - centre + corrected * row.ds * row.dz;
      const Four a = row.z * row.over_s;
      if constexpr (kind == Relaxation::Hard)
        row.e = a * row.r_c - row.c_s * row.over_s;
      else
      {
        Four soft = Four::Constant(2.0 * weight_), push = row.r_xi;
        if constexpr (kind == Relaxation::Capped)
        {
          row.c_t = row.t * row.u - centre + corrected * row.dt * row.du;
          const Four d = row.u * row.over_t;
          soft += d;
          push += d * row.r_t - row.c_t * row.over_t;
        }
        row.e = (a * (soft * row.r_c + push) - soft * row.c_s * row.over_s) * row.over_stiffness;
      }
      sums.addForce(row, row.e);
    }
    rhs.col(group.point) -= sums.force();
  }
}

template <PathRows::Relaxation kind>
Reach PathRows::expandAs(const Matrix3Xd& dp)
{
  // The longest step is the inverse of the largest relative decrease.
  Four decrease = Four::Ones(), linear = Four::Zero(), quadratic = Four::Zero();
  for (const Group& group : groups_)
  {
    const Eigen::Vector3d change = dp.col(group.point);
    for (std::size_t i = group.begin; i < group.end; ++i)
    {
      Lanes& row = lanes_[i];
      const Four along = row.along(change);
      row.dz = row.e + row.w * along;
      row.ds = -row.r_c - along;
      if constexpr (kind != Relaxation::Hard)
      {
        Four push = row.z * row.over_s * (row.r_c + along) - row.r_xi - row.c_s * row.over_s;
        if constexpr (kind == Relaxation::Capped)
          push += row.c_t * row.over_t - row.u * row.over_t * row.r_t;
        row.dxi = push * row.over_stiffness;
        row.ds += row.dxi;
        if constexpr (kind == Relaxation::Capped)
        {
          row.dt = -row.r_t - row.dxi;
          row.du = -row.over_t * (row.c_t + row.u * row.dt);
          decrease = decrease.max(-row.dt * row.over_t).max(-row.du / row.u);
          linear += row.t * row.du + row.u * row.dt;
          quadratic += row.dt * row.du;
        }
      }
      decrease = decrease.max(-row.ds * row.over_s).max(-row.dz / row.z);
      linear += row.s * row.dz + row.z * row.ds;
      quadratic += row.ds * row.dz;
    }
  }
  return {1.0 / decrease.maxCoeff(), linear.sum(), quadratic.sum()};
}

PartState PathRows::linearize(const Matrix3Xd& p, BlockBand& matrix, Matrix3Xd& gradient)
{
  return dispatch([&](auto kind) { return linearizeAs<kind>(p, matrix, gradient); });
}

void PathRows::addRightHandSide(double centre, bool corrected, Matrix3Xd& rhs)
{
  dispatch([&](auto kind) { addRightHandSideAs<kind>(centre, corrected ? 1.0 : 0.0, rhs); });
}

Reach PathRows::expand(const Matrix3Xd& dp)
{
  return dispatch([&](auto kind) { return expandAs<kind>(dp); });
}

void PathRows::move(double step)
{
  for (Lanes& row : lanes_)
  {
    row.s += step * row.ds;
    row.z += step * row.dz;
    if (relaxation_ == Relaxation::Hard) continue;
    row.xi += step * row.dxi;
    row.t += step * row.dt;
    row.u += step * row.du;
  }
}

double PathRows::relaxationCost() const
{
  if (relaxation_ == Relaxation::Hard) return 0.0;
  double cost = 0.0;
  for (const Lanes& row : lanes_) cost += weight_ * row.xi.square().sum();
  return cost;
}

double PathRows::multiplierSlack(const Matrix3Xd& p) const
{
  double sum = 0.0;
  for (const Group& group : groups_)
    for (std::size_t i = group.begin; i < group.end; ++i)
      sum += (lanes_[i].z * (lanes_[i].bound - lanes_[i].along(p.col(group.point)))).sum();
  return sum;
}

}  // namespace slalom::optim::detail
