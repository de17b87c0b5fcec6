// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <IpTNLP.hpp>
#include <string>

#include "slalom/optim/Ipopt.h"

namespace slalom::optim::detail
{
/** Shows a NonlinearProgram to Ipopt. Lives as long as its application, because Ipopt recognises a
 * repeated problem by this object; the program behind it is swapped per solve. Exceptions of the
 * program end the solve and are kept as text. */
class IpoptAdapter : public Ipopt::TNLP
{
 public:
  void arm(const NonlinearProgram& program, const NlpPoint& start, const core::Deadline& deadline);

  [[nodiscard]] NlpPoint takePoint() { return std::move(point_); }
  [[nodiscard]] bool late() const { return late_; }
  [[nodiscard]] int iterations() const { return iterations_; }
  [[nodiscard]] const std::string& failure() const { return failure_; }

  bool get_nlp_info(Ipopt::Index& n, Ipopt::Index& m, Ipopt::Index& jacobian_size,
                    Ipopt::Index& hessian_size, IndexStyleEnum& style) override;
  bool get_bounds_info(Ipopt::Index n, double* x_lower, double* x_upper, Ipopt::Index m,
                       double* g_lower, double* g_upper) override;
  bool get_starting_point(Ipopt::Index n, bool init_x, double* x, bool init_z, double* z_lower,
                          double* z_upper, Ipopt::Index m, bool init_lambda,
                          double* lambda) override;
  bool eval_f(Ipopt::Index n, const double* x, bool, double& cost) override;
  bool eval_grad_f(Ipopt::Index n, const double* x, bool, double* gradient) override;
  bool eval_g(Ipopt::Index n, const double* x, bool, Ipopt::Index m, double* g) override;
  bool eval_jac_g(Ipopt::Index n, const double* x, bool, Ipopt::Index m, Ipopt::Index size,
                  Ipopt::Index* rows, Ipopt::Index* cols, double* values) override;
  bool eval_h(Ipopt::Index n, const double* x, bool, double sigma, Ipopt::Index m,
              const double* lambda, bool, Ipopt::Index size, Ipopt::Index* rows, Ipopt::Index* cols,
              double* values) override;
  bool intermediate_callback(Ipopt::AlgorithmMode mode, Ipopt::Index iteration, double, double,
                             double, double, double, double, double, double, Ipopt::Index,
                             const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override;
  void finalize_solution(Ipopt::SolverReturn, Ipopt::Index n, const double* x,
                         const double* z_lower, const double* z_upper, Ipopt::Index m,
                         const double*, const double* lambda, double, const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override;

 private:
  template <class Call>
  bool guarded(Call&& call);

  const NonlinearProgram* program_ = nullptr;
  const NlpPoint* start_ = nullptr;
  const core::Deadline* deadline_ = nullptr;
  NlpPoint point_;
  bool late_ = false;
  int iterations_ = 0;
  std::string failure_;
};

}  // namespace slalom::optim::detail
