// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "KktFactorization.h"

namespace slalom::optim::detail
{
/** Lets Ipopt factorise with `factorization` while this object lives.
 *
 *  Ipopt's loader of linear solvers takes three functions for "ma27" (HSLLoader.h); ours forward
 * to the object in use. One at a time in the process: create it under the lock of the solver. */
class IpoptLinearSolver
{
 public:
  explicit IpoptLinearSolver(KktFactorization& factorization);
  ~IpoptLinearSolver();
  IpoptLinearSolver(const IpoptLinearSolver&) = delete;
  IpoptLinearSolver& operator=(const IpoptLinearSolver&) = delete;
};

}  // namespace slalom::optim::detail
