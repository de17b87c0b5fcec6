// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "slalom/core/Rng.h"
#include "slalom/optim/TrackingQp.h"

namespace slalom::test
{
/** A vehicle of three axes that flies a weaving reference of 1.2 m/s past trunks and balls, planned
 *  in closed loop: every call of next() gives the program of the next cycle and the commands to
 *  start from, which are the plan before, shifted by one stage. */
class TrackingFlight
{
 public:
  struct Setting
  {
    int stages = 15, rows = 8;
    double dt = 0.05, lag = 0.0;
    double wind = 0.0;    ///< [m/s] sigma of a disturbance that the program does not know
    double pushed = 0.0;  ///< [m] sideways throw every 20 cycles, into the margin
    double penalty = 100.0;
    double clearance = 0.6;  ///< [m] wanted from the obstacle points
  };
  using Matrix = Eigen::Matrix3Xd;

  TrackingFlight(const Setting& setting, std::uint64_t seed)
      : setting_(setting),
        rng_(seed),
        phase_(rng_.uniform(0.0, 6.28)),
        qp_(setting.stages, setting.rows),
        plan_(Matrix::Zero(3, setting.stages))
  {
    for (int i = 0; i < 60; ++i)
    {
      Eigen::Vector3d obstacle = reference(rng_.uniform(1.5, 40.0)) + 0.8 * rng_.normal3(1.0);
      obstacles_.push_back(obstacle);
    }
    qp_.p = reference(0.0);
    qp_.v = qp_.u_before = referenceVelocity(0.0);
  }

  [[nodiscard]] const optim::TrackingQp<3>& next()
  {
    const auto response = core::VelocityResponse::over(setting_.dt, setting_.lag);
    Eigen::Vector3d p = qp_.p, v = qp_.v;
    for (int k = 0; k < setting_.stages; ++k)
    {
      optim::TrackingStage<3>& stage = qp_.stages[static_cast<std::size_t>(k)];
      const double t = time_ + (k + 1) * setting_.dt;
      stage.response = response;
      stage.position = reference(t);
      stage.velocity = referenceVelocity(t);
      stage.input = stage.velocity;
      stage.position_weight =
          (k + 1 == setting_.stages ? 30.0 : 10.0) * Eigen::Matrix3d::Identity();
      stage.velocity_weight = setting_.lag > 0.0 ? 1.0 : 0.0;
      stage.input_weight = 1.0;
      stage.change_weight = 2.0;
      stage.input_limit.setConstant(1.5);
      stage.change_limit.setConstant(4.0 * setting_.dt);
      const Eigen::Vector3d u = plan_.col(k);
      p += response.p_v * v + response.p_u * u;
      v = response.v_v * v + response.v_u * u;
      addRows(k, p);
    }
    return qp_;
  }
  [[nodiscard]] const Matrix& guess() const { return plan_; }

  /// Flies the first command of a plan and shifts it.
  void fly(const Eigen::Ref<const Matrix>& inputs)
  {
    const auto response = core::VelocityResponse::over(setting_.dt, setting_.lag);
    const Eigen::Vector3d u = inputs.col(0);
    qp_.p += response.p_v * qp_.v + response.p_u * u + setting_.dt * rng_.normal3(setting_.wind);
    qp_.v = response.v_v * qp_.v + response.v_u * u;
    qp_.u_before = u;
    time_ += setting_.dt;
    if (setting_.pushed > 0.0 && ++cycle_ % 20 == 0) qp_.p += setting_.pushed * rng_.direction();
    plan_.leftCols(setting_.stages - 1) = inputs.rightCols(setting_.stages - 1);
    plan_.rightCols(1) = inputs.rightCols(1);
  }

 private:
  [[nodiscard]] Eigen::Vector3d reference(double t) const
  {
    return {t, 0.8 * std::sin(0.7 * t + phase_), 1.5 + 0.3 * std::sin(0.5 * t)};
  }
  [[nodiscard]] Eigen::Vector3d referenceVelocity(double t) const
  {
    return {1.0, 0.56 * std::cos(0.7 * t + phase_), 0.15 * std::cos(0.5 * t)};
  }
  /// Tangent planes of the balls around the nearest obstacles.
  void addRows(int k, const Eigen::Vector3d& p)
  {
    const auto count = static_cast<std::size_t>(setting_.rows);
    std::partial_sort(obstacles_.begin(), obstacles_.begin() + setting_.rows, obstacles_.end(),
                      [&](const auto& a, const auto& b)
                      { return (a - p).squaredNorm() < (b - p).squaredNorm(); });
    qp_.row_counts[static_cast<std::size_t>(k)] = setting_.rows;
    for (std::size_t i = 0; i < count; ++i)
    {
      optim::SoftRow<3>& row = qp_.rows[static_cast<std::size_t>(k) * count + i];
      row.normal = (p - obstacles_[i]).normalized();
      row.offset = row.normal.dot(obstacles_[i]) + setting_.clearance;
      row.penalty = setting_.penalty;
    }
  }

  Setting setting_;
  core::Rng rng_;
  double phase_, time_ = 0.0;
  int cycle_ = 0;
  std::vector<Eigen::Vector3d> obstacles_;
  optim::TrackingQp<3> qp_;
  Matrix plan_;
};

/// A program to torment a solver with: any weights, limits, rows and steps, none of them tame.
template <int D>
struct WildTracking
{
  using Matrix = Eigen::Matrix<double, D, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<double, D, 1>;

  WildTracking(core::Rng& rng, int stages, int rows) : qp(stages, rows), guess(D, stages)
  {
    const auto any = [&](double size)
    { return Vector(Vector::NullaryExpr([&] { return size * rng.normal(); })); };
    const auto positive = [&](double lo, double hi)
    {
      return Vector(
          Vector::NullaryExpr([&] { return std::exp(rng.uniform(std::log(lo), std::log(hi))); }));
    };
    const auto weight = [&](double none)
    { return rng.uniform() < none ? 0.0 : std::exp(rng.uniform(std::log(1e-2), std::log(1e2))); };
    const bool lagging = rng.uniform() < 0.5, uneven = rng.uniform() < 0.3;
    const bool drifting = rng.uniform() < 0.5, leading = rng.uniform() < 0.3;
    const bool turned = rng.uniform() < 0.5;
    const double lag = lagging ? rng.uniform(0.05, 0.6) : 0.0, dt = rng.uniform(0.02, 0.2);
    const double far = rng.uniform() < 0.1 ? 100.0 : 1.0;
    const Vector limit = positive(0.2, 3.0), change = positive(0.02, 2.0);
    const double wp = weight(0.1), wv = weight(0.4), wu = weight(0.2), wc = weight(0.2);
    const double crowded = rng.uniform(0.0, 1.0), depth = rng.uniform(-0.5, 1.0);
    qp.p = any(1.0);
    qp.v = any(0.5);
    qp.u_before = Vector::NullaryExpr([&] { return rng.uniform(-1.0, 1.0); }).cwiseProduct(limit);
    if (rng.uniform() < 0.2) qp.u_before = limit;
    for (int k = 0; k < stages; ++k)
    {
      optim::TrackingStage<D>& stage = qp.stages[static_cast<std::size_t>(k)];
      const double step = uneven ? dt * rng.uniform(0.5, 3.0) : dt;
      stage.response = core::VelocityResponse::over(step, lag);
      if (drifting) stage.drift_p = any(0.02), stage.drift_v = any(0.05);
      stage.position = far * (any(0.3) + Vector::Constant(k * step));
      stage.velocity = any(1.0);
      stage.input = any(1.0);
      stage.change = any(0.05);
      stage.position_weight = wp * Eigen::Matrix<double, D, D>::Identity();
      if (turned)
      {
        const Vector way = any(1.0).normalized();
        stage.position_weight = wp * (0.05 * stage.position_weight + way * way.transpose());
      }
      stage.velocity_weight = wv;
      stage.input_weight = wu;
      stage.change_weight = wc;
      stage.input_limit = (uneven ? rng.uniform(1.0, 2.0) : 1.0) * limit;
      stage.change_limit = (uneven ? rng.uniform(0.5, 2.0) : 1.0) * change;
      qp.row_counts[static_cast<std::size_t>(k)] =
          rng.uniform() < crowded ? rng.integer(0, rows) : 0;
      for (int i = 0; i < qp.row_counts[static_cast<std::size_t>(k)]; ++i)
      {
        optim::SoftRow<D>& row = qp.rows[static_cast<std::size_t>(k * rows + i)];
        row.normal = any(1.0).normalized();
        row.lead = leading ? rng.uniform(0.0, 0.5) : 0.0;
        row.offset = row.normal.dot(qp.p) + depth + rng.uniform(-0.5, 0.5);
        row.penalty = std::exp(rng.uniform(std::log(1.0), std::log(1e3)));
      }
      guess.col(k) = any(1.0);
    }
  }

  optim::TrackingQp<D> qp;
  Matrix guess;
};

}  // namespace slalom::test
