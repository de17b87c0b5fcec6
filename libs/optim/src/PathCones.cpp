// SPDX-License-Identifier: BSD-3-Clause
#include "PathCones.h"

#include <algorithm>
#include <cmath>

namespace slalom::optim::detail
{
namespace
{
using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::Vector4d;

/// x0^2 - |x1|^2 without the worst of the cancellation; positive inside the cone.
double determinant(const Vector4d& x)
{
  const double radius = x.tail<3>().norm();
  return (x[0] - radius) * (x[0] + radius);
}

/// Largest relative decrease of a cone element along d: its inverse is the step to the boundary.
double decrease(const Vector4d& x, double det, const Vector4d& d)
{
  const double b = x[0] * d[0] - x.tail<3>().dot(d.tail<3>());
  const double a = d[0] * d[0] - d.tail<3>().squaredNorm();
  const double discriminant = b * b - a * det;
  return discriminant > 0.0 ? (std::sqrt(discriminant) - b) / det : 0.0;
}

/// x with l o x = r (Jordan product of the cone).
Vector4d jordanDivide(const Vector4d& l, const Vector4d& r)
{
  Vector4d x;
  x[0] = (l[0] * r[0] - l.tail<3>().dot(r.tail<3>())) / determinant(l);
  x.tail<3>() = (r.tail<3>() - x[0] * l.tail<3>()) / l[0];
  return x;
}

Vector4d jordanProduct(const Vector4d& a, const Vector4d& b)
{
  Vector4d x;
  x[0] = a.dot(b);
  x.tail<3>() = a[0] * b.tail<3>() + b[0] * a.tail<3>();
  return x;
}
}  // namespace

PathCones::PathCones(const Vector3d& first, const Vector3d& last, Index points, double w_start,
                     double w_end, double w_length)
    : first_(first), last_(last), cones_(static_cast<std::size_t>(points) + 1)
{
  for (Cone& cone : cones_) cone.weight = w_length;
  cones_.front().weight = w_start;
  cones_.back().weight = w_end;
}

Vector3d PathCones::span(const Matrix3Xd& p, std::size_t e, const Vector3d& first,
                         const Vector3d& last) const
{
  const auto k = static_cast<Index>(e);
  if (k == 0) return p.col(0) - first;
  if (k == p.cols()) return last - p.col(k - 1);
  return p.col(k) - p.col(k - 1);
}

void PathCones::addPull(Matrix3Xd& at, std::size_t e, const Vector3d& force)
{
  const auto k = static_cast<Index>(e);
  if (k > 0) at.col(k - 1) += force;
  if (k < at.cols()) at.col(k) -= force;
}

double PathCones::cost(const Matrix3Xd& p) const
{
  double sum = 0.0;
  for (std::size_t e = 0; e < cones_.size(); ++e)
    sum += cones_[e].weight * span(p, e, first_, last_).norm();
  return sum;
}

Matrix3Xd PathCones::tensions() const
{
  Matrix3Xd y(3, static_cast<Index>(cones_.size()));
  for (std::size_t e = 0; e < cones_.size(); ++e)
    y.col(static_cast<Index>(e)) = -cones_[e].z.tail<3>();
  return y;
}

double PathCones::multiplierSlack(const Matrix3Xd& p) const
{
  double sum = 0.0;
  for (std::size_t e = 0; e < cones_.size(); ++e)
  {
    const Vector3d v = span(p, e, first_, last_);
    sum += cones_[e].weight * v.norm() + cones_[e].z.tail<3>().dot(v);
  }
  return sum;
}

void PathCones::initialize(const Matrix3Xd& p, double length, double)
{
  for (std::size_t e = 0; e < cones_.size(); ++e)
  {
    Cone& cone = cones_[e];
    cone.s.tail<3>() = span(p, e, first_, last_);
    cone.s[0] = cone.s.tail<3>().norm() + length;
    cone.z = Vector4d(cone.weight, 0.0, 0.0, 0.0);
  }
}

Vector4d PathCones::Cone::times(const Vector4d& x) const
{
  const double along = w.tail<3>().dot(x.tail<3>());
  Vector4d y;
  y[0] = w[0] * x[0] + along;
  y.tail<3>() = x.tail<3>() + w.tail<3>() * (x[0] + along / (1.0 + w[0]));
  return eta * y;
}

Vector4d PathCones::Cone::divided(const Vector4d& x) const
{
  const double along = w.tail<3>().dot(x.tail<3>());
  Vector4d y;
  y[0] = w[0] * x[0] - along;
  y.tail<3>() = x.tail<3>() + w.tail<3>() * (along / (1.0 + w[0]) - x[0]);
  return y / eta;
}

void PathCones::Cone::scale()
{
  const double det_s = determinant(s), det_z = determinant(z);
  const double root_s = std::sqrt(det_s), root_z = std::sqrt(det_z);
  const double gamma = std::sqrt(0.5 * (1.0 + s.dot(z) / (root_s * root_z)));
  w[0] = (s[0] / root_s + z[0] / root_z) / (2.0 * gamma);
  w.tail<3>() = (s.tail<3>() / root_s - z.tail<3>() / root_z) / (2.0 * gamma);
  // What rounding took from w0^2 - |w1|^2 = 1 would show in W^-1 W.
  w[0] = std::sqrt(1.0 + w.tail<3>().squaredNorm());
  eta = std::sqrt(root_s / root_z);
  lambda = times(z);
  softness = 1.0 + 2.0 * w.tail<3>().squaredNorm();
  stiffness.noalias() = (-2.0 / softness) * w.tail<3>() * w.tail<3>().transpose();
  stiffness.diagonal().array() += 1.0;
  stiffness /= eta * eta;
}

PartState PathCones::linearize(const Matrix3Xd& p, BlockBand& matrix, Matrix3Xd& gradient)
{
  PartState state;
  state.pairs = static_cast<double>(cones_.size());
  const std::size_t n = cones_.size() - 1;
  for (std::size_t e = 0; e < cones_.size(); ++e)
  {
    Cone& cone = cones_[e];
    cone.s.tail<3>() = span(p, e, first_, last_);  // anew each time: no drift
    cone.s[0] = std::max(cone.s[0], cone.s.tail<3>().norm() * (1.0 + 1e-14));
    cone.scale();
    state.complementarity += cone.s.dot(cone.z);
    if (e > 0) matrix.diagonal[e - 1] += cone.stiffness;
    if (e < n) matrix.diagonal[e] += cone.stiffness;
    if (e > 0 && e < n) matrix.first[e - 1] -= cone.stiffness;
    addPull(gradient, e, cone.z.tail<3>());
  }
  return state;
}

void PathCones::addRightHandSide(double centre, bool corrected, Matrix3Xd& rhs)
{
  for (std::size_t e = 0; e < cones_.size(); ++e)
  {
    Cone& cone = cones_[e];
    if (corrected)
    {
      Vector4d target = -jordanProduct(cone.lambda, cone.lambda);
      target -= jordanProduct(cone.divided(cone.ds), cone.times(cone.dz));
      target[0] += centre;
      cone.q = cone.times(jordanDivide(cone.lambda, target));
    }
    else
      cone.q = -cone.s;
    addPull(rhs, e, -(cone.stiffness * cone.q.tail<3>()));
  }
}

Reach PathCones::expand(const Matrix3Xd& dp)
{
  Reach reach;
  double most = 1.0;
  for (std::size_t e = 0; e < cones_.size(); ++e)
  {
    Cone& cone = cones_[e];
    cone.ds.tail<3>() = span(dp, e, Vector3d::Zero(), Vector3d::Zero());
    const Vector3d rest = cone.q.tail<3>() - cone.ds.tail<3>();
    cone.dz[0] = 0.0;
    cone.dz.tail<3>() = cone.stiffness * rest;
    // w1.dz in closed form: dz along w1 is what is left of a cancellation, and large factors wait.
    cone.ds[0] = cone.q[0] - 2.0 * cone.w[0] * cone.w.tail<3>().dot(rest) / cone.softness;
    most = std::max({most, decrease(cone.s, determinant(cone.s), cone.ds),
                     decrease(cone.z, determinant(cone.z), cone.dz)});
    reach.linear += cone.s.dot(cone.dz) + cone.z.dot(cone.ds);
    reach.quadratic += cone.ds.dot(cone.dz);
  }
  reach.step = 1.0 / most;
  return reach;
}

void PathCones::move(double step)
{
  for (Cone& cone : cones_)
  {
    cone.s += step * cone.ds;
    cone.z += step * cone.dz;
  }
}

}  // namespace slalom::optim::detail
