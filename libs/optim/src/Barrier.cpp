// SPDX-License-Identifier: BSD-3-Clause
#include "Barrier.h"

#include <algorithm>
#include <limits>

namespace slalom::optim::detail
{
using Eigen::ArrayXd;
using Eigen::Index;

Barrier::Barrier(ArrayXd lower, ArrayXd upper) : lower_(std::move(lower)), upper_(std::move(upper))
{
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kNoRoom = 1e-10;  // relative; slacks would drown in rounding
  held_ = (upper_ - lower_ <= kNoRoom * (1.0 + lower_.abs().min(upper_.abs()))).cast<double>();
  has_lower_ = (lower_ > -kInfinity).cast<double>() * (1.0 - held_);
  has_upper_ = (upper_ < kInfinity).cast<double>() * (1.0 - held_);
  sides_ = has_lower_.sum() + has_upper_.sum();
  for (ArrayXd* array : {&dv_, &lower_dz_, &upper_dz_}) *array = ArrayXd::Zero(lower_.size());
}

void Barrier::start(const Eigen::Ref<const ArrayXd>& v, double share, double mu)
{
  constexpr double kWide = 1.0;  // rooms wider than this times the size of v count as this wide
  v_ = v;
  for (Index i = 0; i < v_.size(); ++i)
  {
    if (held_[i] != 0.0) continue;
    const double margin = share * std::min(upper_[i] - lower_[i], kWide * (1.0 + std::abs(v_[i])));
    v_[i] = std::min(std::max(v_[i], lower_[i] + margin), upper_[i] - margin);
  }
  lower_s_ = (has_lower_ > 0.0).select(v_ - lower_, 1.0);
  upper_s_ = (has_upper_ > 0.0).select(upper_ - v_, 1.0);
  lower_z_ = has_lower_ * mu / lower_s_;
  upper_z_ = has_upper_ * mu / upper_s_;
}

double Barrier::complementarity() const
{
  return (lower_s_ * lower_z_ + upper_s_ * upper_z_).sum();
}

double Barrier::complementarityAfter(double primal_step, double dual_step) const
{
  return ((lower_s_ + primal_step * dv_) * (lower_z_ + dual_step * lower_dz_) +
          (upper_s_ - primal_step * dv_) * (upper_z_ + dual_step * upper_dz_))
      .sum();
}

void Barrier::linearize()
{
  lower_i_ = 1.0 / lower_s_;
  upper_i_ = 1.0 / upper_s_;
  stiffness_ = lower_z_ * lower_i_ + upper_z_ * upper_i_;
  lower_c_.setZero(v_.size());
  upper_c_.setZero(v_.size());
  push_.setZero(v_.size());
}

void Barrier::correct(double mu)
{
  lower_c_ = mu * has_lower_ - dv_ * lower_dz_;
  upper_c_ = mu * has_upper_ + dv_ * upper_dz_;
  push_ = lower_c_ * lower_i_ - upper_c_ * upper_i_;
}

void Barrier::expand(const Eigen::Ref<const ArrayXd>& dv)
{
  dv_ = dv;
  lower_dz_ = (lower_c_ - lower_z_ * dv_) * lower_i_ - lower_z_;
  upper_dz_ = (upper_c_ + upper_z_ * dv_) * upper_i_ - upper_z_;
}

void Barrier::limitSteps(double& primal_step, double& dual_step) const
{
  // The largest relative shrinkage decides.
  const double primal = (has_lower_ * -dv_ * lower_i_).max(has_upper_ * dv_ * upper_i_).maxCoeff();
  if (primal * primal_step > 1.0) primal_step = 1.0 / primal;
  double dual = 0.0;
  for (Index i = 0; i < dv_.size(); ++i)
  {
    if (-lower_dz_[i] > dual * lower_z_[i]) dual = -lower_dz_[i] / lower_z_[i];
    if (-upper_dz_[i] > dual * upper_z_[i]) dual = -upper_dz_[i] / upper_z_[i];
  }
  if (dual * dual_step > 1.0) dual_step = 1.0 / dual;
}

void Barrier::move(double primal_step, double dual_step)
{
  v_ += primal_step * dv_;
  lower_s_ += primal_step * has_lower_ * dv_;
  upper_s_ -= primal_step * has_upper_ * dv_;
  lower_z_ += dual_step * lower_dz_;
  upper_z_ += dual_step * upper_dz_;
}

}  // namespace slalom::optim::detail
