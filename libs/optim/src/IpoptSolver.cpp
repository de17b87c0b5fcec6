// SPDX-License-Identifier: BSD-3-Clause
#include <IpIpoptApplication.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <memory>
#include <mutex>

#include "IpoptAdapter.h"
#include "IpoptLinearSolver.h"
#include "slalom/optim/Ipopt.h"

namespace slalom::optim
{
namespace
{
using core::SolveReport;
using core::Termination;
using Ipopt::SmartPtr;

/// Sequential MUMPS and Ipopt's object tags are global state: one solve, construction or
/// destruction at a time in the whole process.
std::mutex& processLock()
{
  static std::mutex mutex;
  return mutex;
}

/// What must stay equal for Ipopt to keep its memory and the symbolic factorisation.
struct Shape
{
  int variables = -1, constraints = -1;
  std::vector<int> positions;  // of Jacobian and Hessian entries
  std::vector<char> kinds;     // which bounds are finite or equal
  bool operator==(const Shape&) const = default;
};

struct Bounds
{
  Eigen::VectorXd x_lower, x_upper, g_lower, g_upper;
};

Bounds boundsOf(const NonlinearProgram& program)
{
  const int n = program.variables(), m = program.constraints();
  Bounds b{Eigen::VectorXd(n), Eigen::VectorXd(n), Eigen::VectorXd(m), Eigen::VectorXd(m)};
  program.bounds(b.x_lower, b.x_upper, b.g_lower, b.g_upper);
  return b;
}

void appendKinds(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                 std::vector<char>& kinds)
{
  constexpr double kInfinite = 1e19;  // Ipopt's own threshold
  for (Eigen::Index i = 0; i < lower.size(); ++i)
    kinds.push_back(static_cast<char>((lower[i] > -kInfinite) + 2 * (upper[i] < kInfinite) +
                                      4 * (lower[i] == upper[i])));
}

Shape shapeOf(const NonlinearProgram& program, const Bounds& bounds)
{
  Shape shape{program.variables(), program.constraints(), {}, {}};
  for (const auto& entries : {program.jacobianStructure(), program.hessianStructure()})
  {
    shape.positions.push_back(-1);
    for (const Entry& entry : entries)
      shape.positions.insert(shape.positions.end(), {entry.row, entry.col});
  }
  appendKinds(bounds.x_lower, bounds.x_upper, shape.kinds);
  appendKinds(bounds.g_lower, bounds.g_upper, shape.kinds);
  return shape;
}

/// One Ipopt application with the memory of its last problem. A cold and a warm start need
/// different ones, because Ipopt picks its initialiser when it builds the algorithm.
struct Backend
{
  SmartPtr<Ipopt::IpoptApplication> application;
  SmartPtr<detail::IpoptAdapter> adapter;
  detail::KktFactorization factorization;
  Shape shape;

  bool create(const IpoptConfig& config, bool warm);
  Ipopt::ApplicationReturnStatus run(const Shape& next);
};

bool Backend::create(const IpoptConfig& config, bool warm)
{
  application = new Ipopt::IpoptApplication(false);
  adapter = new detail::IpoptAdapter;
  Ipopt::OptionsList& options = *application->Options();
  options.SetIntegerValue("print_level", 0);
  options.SetStringValue("sb", "yes");
  // "ma27" is the name under which Ipopt takes the functions of IpoptLinearSolver.
  const bool mumps = config.kkt_solver == KktSolver::Mumps;
  options.SetStringValue("linear_solver", mumps ? "mumps" : "ma27");
  options.SetStringValue("linear_system_scaling", "none");
  // Problems here are small and scaled by hand: searching for a better order or scaling costs more
  // than it saves.
  options.SetIntegerValue("mumps_pivot_order", 0);
  options.SetIntegerValue("mumps_permuting_scaling", 0);
  options.SetIntegerValue("min_refinement_steps", 0);
  options.SetStringValue("nlp_scaling_method", "none");
  options.SetNumericValue("tol", config.tolerance);
  options.SetIntegerValue("max_iter", config.max_iterations);
  options.SetIntegerValue("acceptable_iter", 0);
  options.SetNumericValue("mu_init", config.initial_barrier);
  options.SetStringValue("bound_mult_init_method", "mu-based");
  options.SetNumericValue("constr_mult_init_max", 0.0);  // saves a factorisation
  options.SetNumericValue("bound_relax_factor", 0.0);    // bounds are meant exactly
  if (warm)
  {
    options.SetStringValue("warm_start_init_point", "yes");
    for (const char* push :
         {"warm_start_bound_push", "warm_start_bound_frac", "warm_start_slack_bound_push",
          "warm_start_slack_bound_frac", "warm_start_mult_bound_push"})
      options.SetNumericValue(push, std::min(1e-3, config.initial_barrier));
  }
  // The empty name keeps Ipopt from reading an ipopt.opt that happens to lie around.
  return application->Initialize(std::string()) == Ipopt::Solve_Succeeded;
}

Ipopt::ApplicationReturnStatus Backend::run(const Shape& next)
{
  const detail::IpoptLinearSolver linear_solver(factorization);
  const bool same = next == shape;
  shape = {};  // until this solve ended without an exception nothing can be trusted
  application->Options()->SetStringValue("warm_start_same_structure", same ? "yes" : "no");
  const SmartPtr<Ipopt::TNLP> program = Ipopt::GetRawPtr(adapter);
  const auto status =
      same ? application->ReOptimizeTNLP(program) : application->OptimizeTNLP(program);
  // MUMPS keeps its ordering only after a first factorisation.
  if (status > Ipopt::Not_Enough_Degrees_Of_Freedom && adapter->iterations() > 0) shape = next;
  return status;
}

void name(Ipopt::ApplicationReturnStatus status, const detail::IpoptAdapter& adapter,
          SolveReport& report)
{
  const auto is = [&](Termination termination, const char* message)
  {
    report.termination = termination;
    report.message = message;
  };
  switch (status)
  {
    case Ipopt::Solve_Succeeded:
      return is(Termination::Converged, "optimal");
    case Ipopt::Maximum_Iterations_Exceeded:
      return is(Termination::IterationLimit, "iteration limit");
    case Ipopt::Infeasible_Problem_Detected:
      return is(Termination::Infeasible, "locally infeasible");
    case Ipopt::Search_Direction_Becomes_Too_Small:
      return is(Termination::NumericalFailure, "search direction vanished");
    case Ipopt::Restoration_Failed:
      return is(Termination::NumericalFailure, "restoration of feasibility failed");
    case Ipopt::Invalid_Number_Detected:
      return is(Termination::NumericalFailure, "the program gave a number that is not finite");
    default:
      break;
  }
  if (status == Ipopt::User_Requested_Stop && adapter.late())
    return is(Termination::TimeLimit, "deadline passed");
  report.termination = Termination::NumericalFailure;
  report.message = adapter.failure().empty()
                       ? "Ipopt status " + std::to_string(static_cast<int>(status))
                       : adapter.failure();
}

double excess(const Eigen::VectorXd& value, const Eigen::VectorXd& lower,
              const Eigen::VectorXd& upper)
{
  if (value.size() == 0) return 0.0;
  return std::max((lower - value).maxCoeff(), (value - upper).maxCoeff());
}

/// Residuals by the program's own functions, not by what Ipopt believes.
void fillResiduals(const NonlinearProgram& program, const Bounds& bounds, const NlpPoint& point,
                   SolveReport& report)
{
  Eigen::VectorXd g(program.constraints()), gradient(program.variables());
  program.constraint(point.x, g);
  report.cost = program.cost(point.x);
  report.primal_residual = std::max({0.0, excess(point.x, bounds.x_lower, bounds.x_upper),
                                     excess(g, bounds.g_lower, bounds.g_upper)});
  if (point.g_multipliers.size() != g.size() || point.lower_multipliers.size() != gradient.size() ||
      point.upper_multipliers.size() != gradient.size())
    return;
  program.gradient(point.x, gradient);
  const std::vector<Entry> entries = program.jacobianStructure();
  Eigen::VectorXd jacobian(entries.size());
  program.jacobian(point.x, jacobian);
  for (std::size_t i = 0; i < entries.size(); ++i)
    gradient[entries[i].col] += jacobian[i] * point.g_multipliers[entries[i].row];
  gradient += point.upper_multipliers - point.lower_multipliers;
  report.dual_residual = gradient.lpNorm<Eigen::Infinity>();
}

}  // namespace

struct IpoptSolver::Impl
{
  explicit Impl(const IpoptConfig& given) : config(given) {}
  ~Impl()
  {
    const std::scoped_lock lock(processLock());
    cold.reset();
    warm.reset();
  }

  void solve(const NonlinearProgram& program, const NlpPoint& start, const core::Deadline& deadline,
             NlpSolution& solution);

  IpoptConfig config;
  std::unique_ptr<Backend> cold, warm;
};

void IpoptSolver::Impl::solve(const NonlinearProgram& program, const NlpPoint& start,
                              const core::Deadline& deadline, NlpSolution& solution)
{
  SolveReport& report = solution.report;
  report.termination = Termination::NumericalFailure;
  if (start.x.size() != program.variables() || !start.x.allFinite())
  {
    report.message = "the start has a wrong size or is not finite";
    return;
  }
  const Bounds bounds = boundsOf(program);
  // Ipopt crashes on bounds that contradict each other.
  if ((bounds.x_lower.array() > bounds.x_upper.array()).any() ||
      (bounds.g_lower.array() > bounds.g_upper.array()).any())
  {
    report.termination = Termination::Infeasible;
    report.message = "a lower bound exceeds its upper bound";
    return;
  }
  const bool has_multipliers = start.g_multipliers.size() == program.constraints() &&
                               start.lower_multipliers.size() == program.variables() &&
                               start.upper_multipliers.size() == program.variables();
  const bool use_warm = config.warm_start && has_multipliers;
  std::unique_ptr<Backend>& slot = use_warm ? warm : cold;
  if (!slot)
  {
    slot = std::make_unique<Backend>();
    if (!slot->create(config, use_warm))
    {
      slot.reset();
      report.message = "Ipopt refused its options";
      return;
    }
  }
  Backend& backend = *slot;
  backend.adapter->arm(program, start, deadline);
  const auto status = backend.run(shapeOf(program, bounds));
  name(status, *backend.adapter, report);
  report.iterations = backend.adapter->iterations();
  solution.point = backend.adapter->takePoint();
  fillResiduals(program, bounds, solution.point, report);
}

IpoptSolver::IpoptSolver(const IpoptConfig& config) : impl_(std::make_unique<Impl>(config)) {}
IpoptSolver::~IpoptSolver() = default;
IpoptSolver::IpoptSolver(IpoptSolver&&) noexcept = default;
IpoptSolver& IpoptSolver::operator=(IpoptSolver&&) noexcept = default;

NlpSolution IpoptSolver::solve(const NonlinearProgram& program, const NlpPoint& start,
                               const core::Deadline& deadline)
{
  const auto begin = std::chrono::steady_clock::now();
  NlpSolution solution{start, {}};
  try
  {
    const std::scoped_lock lock(processLock());
    impl_->solve(program, start, deadline, solution);
  }
  catch (const std::exception& error)
  {
    solution.report.termination = Termination::NumericalFailure;
    solution.report.message = error.what();
  }
  catch (...)
  {
    solution.report.termination = Termination::NumericalFailure;
    solution.report.message = "unknown exception";
  }
  solution.report.wall_time = std::chrono::steady_clock::now() - begin;
  return solution;
}

}  // namespace slalom::optim
