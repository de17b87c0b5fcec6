// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/core/SolveReport.h"

namespace slalom::core
{
std::string_view toString(Termination termination)
{
  switch (termination)
  {
    case Termination::NotRun:
      return "NotRun";
    case Termination::Converged:
      return "Converged";
    case Termination::IterationLimit:
      return "IterationLimit";
    case Termination::TimeLimit:
      return "TimeLimit";
    case Termination::Infeasible:
      return "Infeasible";
    case Termination::NumericalFailure:
      return "NumericalFailure";
  }
  return "?";
}

}  // namespace slalom::core
