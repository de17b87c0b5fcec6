// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "slalom/core/Deadline.h"
#include "slalom/core/SolveReport.h"

namespace slalom::optim
{
/// Position of a structural non-zero.
struct Entry
{
  int row = 0, col = 0;
};

/** min f(x) s.t. x_lower <= x <= x_upper, g_lower <= g(x) <= g_upper, twice differentiable, fixed
 * sparsity. The functions are called from one thread at a time. Bounds may change between solves,
 * sizes may not. */
class NonlinearProgram
{
 public:
  virtual ~NonlinearProgram() = default;
  [[nodiscard]] virtual int variables() const = 0;
  [[nodiscard]] virtual int constraints() const = 0;
  virtual void bounds(Eigen::Ref<Eigen::VectorXd> x_lower, Eigen::Ref<Eigen::VectorXd> x_upper,
                      Eigen::Ref<Eigen::VectorXd> g_lower,
                      Eigen::Ref<Eigen::VectorXd> g_upper) const = 0;
  [[nodiscard]] virtual std::vector<Entry> jacobianStructure() const = 0;
  /// Lower triangle only.
  [[nodiscard]] virtual std::vector<Entry> hessianStructure() const = 0;

  [[nodiscard]] virtual double cost(const Eigen::Ref<const Eigen::VectorXd>& x) const = 0;
  virtual void gradient(const Eigen::Ref<const Eigen::VectorXd>& x,
                        Eigen::Ref<Eigen::VectorXd> grad) const = 0;
  virtual void constraint(const Eigen::Ref<const Eigen::VectorXd>& x,
                          Eigen::Ref<Eigen::VectorXd> g) const = 0;
  /// Values in the order of jacobianStructure().
  virtual void jacobian(const Eigen::Ref<const Eigen::VectorXd>& x,
                        Eigen::Ref<Eigen::VectorXd> values) const = 0;
  /// Values of sigma * Hess f + sum lambda_i Hess g_i in the order of hessianStructure().
  virtual void hessian(const Eigen::Ref<const Eigen::VectorXd>& x, double sigma,
                       const Eigen::Ref<const Eigen::VectorXd>& lambda,
                       Eigen::Ref<Eigen::VectorXd> values) const = 0;
};

/// Primal and dual point; the dual parts may be empty (cold start).
struct NlpPoint
{
  Eigen::VectorXd x, g_multipliers, lower_multipliers, upper_multipliers;
};

/// Who factorises Ipopt's linear systems.
enum class KktSolver
{
  Ldlt,  ///< our own static L D L^T: several times faster on the banded systems of a horizon
  Mumps  ///< the pivoting solver of Ipopt's package
};

struct IpoptConfig
{
  double tolerance = 1e-4;
  int max_iterations = 60;
  double initial_barrier = 1e-3;
  bool warm_start = false;  ///< use the multipliers of the start point
  KktSolver kkt_solver = KktSolver::Ldlt;
};

struct NlpSolution
{
  NlpPoint point;
  core::SolveReport report;
};

/** Ipopt. One process-wide lock inside: Debian's sequential MUMPS crashes when two solves run at
 * once, and Ipopt itself keeps global counters. The deadline is a steady clock checked in every
 * iteration (3.11 has no usable wall-clock option). Keeps one application per object, so options
 * and memory are reused between solves. */
class IpoptSolver
{
 public:
  explicit IpoptSolver(const IpoptConfig& config);
  ~IpoptSolver();
  IpoptSolver(IpoptSolver&&) noexcept;
  IpoptSolver& operator=(IpoptSolver&&) noexcept;

  /// Never throws; failures are in the report, and the returned point is the last iterate.
  [[nodiscard]] NlpSolution solve(const NonlinearProgram& program, const NlpPoint& start,
                                  const core::Deadline& deadline);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slalom::optim
