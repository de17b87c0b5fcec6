// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <limits>
#include <string>
#include <string_view>

namespace slalom::core
{
enum class Termination
{
  NotRun,           ///< solve() was not called
  Converged,        ///< tolerances met
  IterationLimit,   ///< best point so far returned with its residual
  TimeLimit,        ///< the deadline passed; best point so far returned
  Infeasible,       ///< the constraints admit no point, as far as the solver can tell
  NumericalFailure  ///< NaN, singular system, or an error of the back end
};

[[nodiscard]] std::string_view toString(Termination termination);

/// What every solver returns beside its point. Its defaults say the truth before the fact.
struct SolveReport
{
  Termination termination = Termination::NotRun;
  int iterations = 0;
  double cost = std::numeric_limits<double>::quiet_NaN();
  double primal_residual =
      std::numeric_limits<double>::infinity();  ///< largest constraint violation [SI]
  double dual_residual =
      std::numeric_limits<double>::infinity();  ///< largest entry of the KKT gradient
  std::chrono::nanoseconds wall_time{0};
  std::string message = "solve() was not called";

  [[nodiscard]] bool converged() const { return termination == Termination::Converged; }
};

}  // namespace slalom::core
