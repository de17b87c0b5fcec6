// SPDX-License-Identifier: BSD-3-Clause
#include "IpoptLinearSolver.h"

#include <HSLLoader.h>

#include <Eigen/Core>
#include <algorithm>

namespace slalom::optim::detail
{
namespace
{
KktFactorization* active = nullptr;

// Ipopt's side of the contract, as far as it reads our answers: INFO(1) status (0 good, -5
// singular, other errors fatal), INFO(5) and INFO(6) wanted sizes of the real and integer work
// space, INFO(15) number of negative eigenvalues. NSTEPS and MAXFRT only size its scratch arrays.
constexpr int kBase = 1;  // Fortran indices
constexpr int kSingular = -5, kFatal = -100;

void clear(int* info)
{
  std::fill(info, info + 20, 0);
}

void initialize(int*, double*) {}

void analyze(int* n, int* entries, const int* rows, const int* cols, int*, int*, int*, int*,
             int* steps, int*, int*, double*, int* info, double*)
{
  clear(info);
  *steps = 1;
  info[4] = *entries;
  info[5] = 1;
  if (!active || !active->analyze(*n, *entries, rows, cols, kBase)) info[0] = kFatal;
}

void factorize(int* n, int* entries, const int* rows, const int* cols, double* values, int*, int*,
               int*, int*, int*, int* max_front, int*, int*, double*, int* info)
{
  clear(info);
  *max_front = 1;
  const bool ready =
      active && (active->matches(*n, *entries) || active->analyze(*n, *entries, rows, cols, kBase));
  if (!ready)
    info[0] = kFatal;
  else if (!active->factorize(values))
    info[0] = kSingular;
  else
    info[14] = active->negativeEigenvalues();
}

void solve(int* n, double*, int*, int*, int*, double*, int*, double* rhs, int*, int*, int*, double*)
{
  if (active) active->solveInPlace(Eigen::Map<Eigen::VectorXd>(rhs, *n));
}
}  // namespace

IpoptLinearSolver::IpoptLinearSolver(KktFactorization& factorization)
{
  active = &factorization;
  LSL_setMA27(analyze, factorize, solve, initialize);
}

IpoptLinearSolver::~IpoptLinearSolver()
{
  active = nullptr;
}

}  // namespace slalom::optim::detail
