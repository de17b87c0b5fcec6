// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "slalom/optim/Ipopt.h"
#include "slalom/optim/TrackingQp.h"

namespace slalom::optim::detail
{
/** A TrackingQp as Ipopt wants it. Variables, stage by stage: u, p, v of D numbers each, then one
 *  slack per row the problem could have. Constraints likewise: D errors of the position, D of the
 *  velocity, D changes, then t + slack per row. Rows that are not in use are empty, so that all
 *  problems of one size have one structure. */
template <int D>
class TrackingProgram : public NonlinearProgram
{
 public:
  using Vector = Eigen::Matrix<double, D, 1>;

  TrackingProgram(int stages, int rows) : n_(stages), rows_(rows) {}
  /// @param problem must outlive all calls; its limits are replaced by `low` and `high` (DxN)
  void set(const TrackingQp<D>& problem, const Eigen::Matrix<double, D, Eigen::Dynamic>& low,
           const Eigen::Matrix<double, D, Eigen::Dynamic>& high)
  {
    problem_ = &problem;
    low_ = &low;
    high_ = &high;
  }

  [[nodiscard]] int input(int k) const { return k * (3 * D + rows_); }
  [[nodiscard]] int position(int k) const { return input(k) + D; }
  [[nodiscard]] int velocity(int k) const { return input(k) + 2 * D; }
  [[nodiscard]] int slack(int k) const { return input(k) + 3 * D; }

  [[nodiscard]] int variables() const override { return n_ * (3 * D + rows_); }
  [[nodiscard]] int constraints() const override { return n_ * (3 * D + rows_); }
  void bounds(Eigen::Ref<Eigen::VectorXd> x_lower, Eigen::Ref<Eigen::VectorXd> x_upper,
              Eigen::Ref<Eigen::VectorXd> g_lower,
              Eigen::Ref<Eigen::VectorXd> g_upper) const override;
  [[nodiscard]] std::vector<Entry> jacobianStructure() const override;
  [[nodiscard]] std::vector<Entry> hessianStructure() const override;
  [[nodiscard]] double cost(const Eigen::Ref<const Eigen::VectorXd>& x) const override;
  void gradient(const Eigen::Ref<const Eigen::VectorXd>& x,
                Eigen::Ref<Eigen::VectorXd> grad) const override;
  void constraint(const Eigen::Ref<const Eigen::VectorXd>& x,
                  Eigen::Ref<Eigen::VectorXd> g) const override;
  void jacobian(const Eigen::Ref<const Eigen::VectorXd>& x,
                Eigen::Ref<Eigen::VectorXd> values) const override;
  void hessian(const Eigen::Ref<const Eigen::VectorXd>& x, double sigma,
               const Eigen::Ref<const Eigen::VectorXd>& lambda,
               Eigen::Ref<Eigen::VectorXd> values) const override;

 private:
  [[nodiscard]] const TrackingStage<D>& stage(int k) const
  {
    return problem_->stages[static_cast<std::size_t>(k)];
  }
  [[nodiscard]] const SoftRow<D>* row(int k, int i) const
  {
    if (i >= problem_->row_counts[static_cast<std::size_t>(k)]) return nullptr;
    return &problem_->rows[static_cast<std::size_t>(k * problem_->max_rows + i)];
  }
  /// Calls visit(constraint, variable, value) for every entry of the Jacobian in its order.
  template <class Visit>
  void eachJacobian(const Visit& visit) const;
  template <class Visit>
  void eachHessian(const Visit& visit) const;

  int n_, rows_;
  const TrackingQp<D>* problem_ = nullptr;
  const Eigen::Matrix<double, D, Eigen::Dynamic>*low_ = nullptr, *high_ = nullptr;
};

extern template class TrackingProgram<1>;
extern template class TrackingProgram<3>;

}  // namespace slalom::optim::detail
