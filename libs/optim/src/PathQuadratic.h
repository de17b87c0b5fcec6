// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "PathPart.h"

namespace slalom::optim::detail
{
/// The squares of PathQp without its slack: w_start |p_0 - first|^2 + w_end |p_n - last|^2
/// + w_length sum |p_{k+1} - p_k|^2 + w_bend sum |p_{k+1} - 2 p_k + p_{k-1}|^2.
class PathQuadratic final : public PathPart
{
 public:
  Eigen::Vector3d first = Eigen::Vector3d::Zero(), last = Eigen::Vector3d::Zero();
  Eigen::Index points = 0;
  double w_start = 0.0, w_end = 0.0, w_length = 0.0, w_bend = 0.0;

  [[nodiscard]] double cost(const Eigen::Matrix3Xd& p) const;

  void initialize(const Eigen::Matrix3Xd&, double, double) override {}
  PartState linearize(const Eigen::Matrix3Xd& p, BlockBand& matrix,
                      Eigen::Matrix3Xd& gradient) override;
  void addRightHandSide(double, bool, Eigen::Matrix3Xd&) override {}
  Reach expand(const Eigen::Matrix3Xd&) override { return {}; }
  void move(double) override {}
};

}  // namespace slalom::optim::detail
