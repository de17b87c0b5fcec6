// SPDX-License-Identifier: BSD-3-Clause
#include "IpoptAdapter.h"

#include <algorithm>
#include <exception>

namespace slalom::optim::detail
{
namespace
{
using Ipopt::Index;
using ConstMap = Eigen::Map<const Eigen::VectorXd>;
using Map = Eigen::Map<Eigen::VectorXd>;

void writeStructure(const std::vector<Entry>& entries, Index* rows, Index* cols)
{
  for (std::size_t i = 0; i < entries.size(); ++i)
  {
    rows[i] = entries[i].row;
    cols[i] = entries[i].col;
  }
}

/// A multiplier of the wrong size (or none) counts as zero.
void writeOrZero(const Eigen::VectorXd& values, Index n, double* out)
{
  if (values.size() == n)
    Map(out, n) = values;
  else
    Map(out, n).setZero();
}
}  // namespace

void IpoptAdapter::arm(const NonlinearProgram& program, const NlpPoint& start,
                       const core::Deadline& deadline)
{
  program_ = &program;
  start_ = &start;
  deadline_ = &deadline;
  point_ = start;
  late_ = false;
  iterations_ = 0;
  failure_.clear();
}

template <class Call>
bool IpoptAdapter::guarded(Call&& call)
{
  try
  {
    call();
    return true;
  }
  catch (const std::exception& error)
  {
    failure_ = std::string("the program threw: ") + error.what();
  }
  catch (...)
  {
    failure_ = "the program threw";
  }
  return false;
}

bool IpoptAdapter::get_nlp_info(Index& n, Index& m, Index& jacobian_size, Index& hessian_size,
                                IndexStyleEnum& style)
{
  style = C_STYLE;
  return guarded(
      [&]
      {
        n = program_->variables();
        m = program_->constraints();
        jacobian_size = static_cast<Index>(program_->jacobianStructure().size());
        hessian_size = static_cast<Index>(program_->hessianStructure().size());
      });
}

bool IpoptAdapter::get_bounds_info(Index n, double* x_lower, double* x_upper, Index m,
                                   double* g_lower, double* g_upper)
{
  return guarded(
      [&]
      { program_->bounds(Map(x_lower, n), Map(x_upper, n), Map(g_lower, m), Map(g_upper, m)); });
}

bool IpoptAdapter::get_starting_point(Index n, bool init_x, double* x, bool init_z, double* z_lower,
                                      double* z_upper, Index m, bool init_lambda, double* lambda)
{
  if (init_x) Map(x, n) = start_->x;
  if (init_z)
  {
    writeOrZero(start_->lower_multipliers, n, z_lower);
    writeOrZero(start_->upper_multipliers, n, z_upper);
  }
  if (init_lambda) writeOrZero(start_->g_multipliers, m, lambda);
  return true;
}

bool IpoptAdapter::eval_f(Index n, const double* x, bool, double& cost)
{
  return guarded([&] { cost = program_->cost(ConstMap(x, n)); });
}

bool IpoptAdapter::eval_grad_f(Index n, const double* x, bool, double* gradient)
{
  return guarded([&] { program_->gradient(ConstMap(x, n), Map(gradient, n)); });
}

bool IpoptAdapter::eval_g(Index n, const double* x, bool, Index m, double* g)
{
  return guarded([&] { program_->constraint(ConstMap(x, n), Map(g, m)); });
}

bool IpoptAdapter::eval_jac_g(Index n, const double* x, bool, Index, Index size, Index* rows,
                              Index* cols, double* values)
{
  return guarded(
      [&]
      {
        if (values)
          program_->jacobian(ConstMap(x, n), Map(values, size));
        else
          writeStructure(program_->jacobianStructure(), rows, cols);
      });
}

bool IpoptAdapter::eval_h(Index n, const double* x, bool, double sigma, Index m,
                          const double* lambda, bool, Index size, Index* rows, Index* cols,
                          double* values)
{
  return guarded(
      [&]
      {
        if (values)
          program_->hessian(ConstMap(x, n), sigma, ConstMap(lambda, m), Map(values, size));
        else
          writeStructure(program_->hessianStructure(), rows, cols);
      });
}

bool IpoptAdapter::intermediate_callback(Ipopt::AlgorithmMode, Index iteration, double, double,
                                         double, double, double, double, double, double, Index,
                                         const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*)
{
  iterations_ = std::max(iterations_, static_cast<int>(iteration));
  late_ = deadline_->passed();
  return !late_;
}

void IpoptAdapter::finalize_solution(Ipopt::SolverReturn, Index n, const double* x,
                                     const double* z_lower, const double* z_upper, Index m,
                                     const double*, const double* lambda, double,
                                     const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*)
{
  point_.x = ConstMap(x, n);
  point_.lower_multipliers = ConstMap(z_lower, n);
  point_.upper_multipliers = ConstMap(z_upper, n);
  point_.g_multipliers = ConstMap(lambda, m);
}

}  // namespace slalom::optim::detail
