// SPDX-License-Identifier: BSD-3-Clause
// The convex programs of the global planner [Paper Eq. (2), (5)] on the measured instances (or,
// where those are absent, on seeded ones of the same size), beside general solvers on the same
// instances in the same run. Times are CPU times per instance. `slower` is the median over that of
// our solver; `gap` the worst excess over the cost that our solver proves, relative to it.
#include <benchmark/benchmark.h>
#include <time.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <nlopt.hpp>
#include <string>

#include "ChainProblems.h"
#include "PathPrograms.h"
#include "SharedData.h"
#include "slalom/geometry/ConvexDecomposition.h"
#include "slalom/optim/PathSocp.h"

namespace slalom
{
namespace
{
using optim::test::DeadZoneProgram;
using optim::test::NormProgram;
using optim::test::QuadraticProgram;
using test::ChainProblem;

struct Family
{
  std::string name;
  std::vector<ChainProblem> problems;
  bool measured;
};

const Family& family(const std::string& name, Eigen::Index points, std::size_t pieces,
                     Eigen::Index rows)
{
  static std::map<std::string, Family> all;
  const auto [at, fresh] = all.try_emplace(name);
  Family& f = at->second;
  if (!fresh) return f;
  f.name = name;
  const auto file = test::sharedData("problems/socp_" + name + ".txt");
  f.measured = exists(file);
  if (f.measured)
    f.problems = test::readChainProblems(file);
  else
    for (std::uint64_t seed = 1; seed <= 60; ++seed)
      f.problems.push_back(test::makeChainProblem(seed, points, pieces, rows));
  return f;
}

optim::PathSocp socpOf(const ChainProblem& c)
{
  optim::PathSocp q;
  q.points = c.points.cols();
  q.first = c.points.col(0);
  q.last = c.points.col(q.points - 1);
  q.sets = c.perPoint();
  q.w_start = c.l1, q.w_end = c.l2, q.w_length = c.l3;
  return q;
}

optim::PathQp qpOf(const ChainProblem& c, double margin)
{
  optim::PathQp q;
  q.points = c.points.cols();
  q.first = c.points.col(0);
  q.last = c.points.col(q.points - 1);
  q.sets = c.perPoint();
  q.margin = margin;
  return q;
}

double cpuMicroseconds()
{
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

struct Answer
{
  bool solved = false;
  double cost = 0.0;
};
using Solver = std::function<std::function<Answer()>(const ChainProblem&)>;

/// One pass over the family per iteration of the benchmark; the last counts.
void measure(benchmark::State& state, const Family& f, const std::string& task,
             const Solver& solver)
{
  struct Reference
  {
    double median = 0.0;
    std::vector<double> cost;
  };
  static std::map<std::string, Reference> ours;  // first solver of each task
  Reference& reference = ours[task + f.name];
  const bool first = reference.cost.empty();
  std::vector<double> times;
  double gap = 0.0;
  int solved = 0;
  for (auto _ : state)
  {
    times.clear();
    gap = 0.0;
    solved = 0;
    std::vector<double> costs;
    for (const ChainProblem& problem : f.problems)
    {
      const auto prepared = solver(problem);
      const double begin = cpuMicroseconds();
      const Answer answer = prepared();
      times.push_back(cpuMicroseconds() - begin);
      solved += answer.solved;
      costs.push_back(answer.cost);
      if (!first && answer.solved)
        gap = std::max(gap, answer.cost / std::max(0.01, reference.cost[costs.size() - 1]) - 1.0);
    }
    if (first) reference.cost = costs;
  }
  std::sort(times.begin(), times.end());
  const double median = times[times.size() / 2];
  if (first) reference.median = median;
  state.counters["median_us"] = median;
  state.counters["worst_us"] = times.back();
  state.counters["slower"] = median / reference.median;
  state.counters["solved"] = static_cast<double>(solved) / static_cast<double>(f.problems.size());
  if (!first) state.counters["gap"] = gap;
  state.SetLabel(f.measured ? "measured instances" : "own instances");
}

Answer answerOf(const core::SolveReport& report, double cost)
{
  return {report.converged(), cost};
}

std::function<Answer()> norms(const ChainProblem& c)
{
  return [q = socpOf(c)]
  {
    const auto solution = optim::solve(q);
    return answerOf(solution.report, solution.report.cost);
  };
}

/// The same instance with a copy of its polyhedron per point: no shortcut applies.
std::function<Answer()> normsTheLongWay(const ChainProblem& c)
{
  auto copies = std::make_shared<std::deque<core::HalfSpaces>>();
  optim::PathSocp q = socpOf(c);
  for (auto& sets : q.sets) sets = {&copies->emplace_back(*sets.front())};
  return [q, copies]
  {
    const auto solution = optim::solve(q);
    return answerOf(solution.report, solution.report.cost);
  };
}

std::function<Answer()> normsByIpopt(const ChainProblem& c, optim::KktSolver kkt)
{
  auto q = std::make_shared<optim::PathSocp>(socpOf(c));
  auto program = std::make_shared<NormProgram>(*q, 1e-3);
  auto ipopt = std::make_shared<optim::IpoptSolver>(optim::IpoptConfig{
      .tolerance = 1e-6, .max_iterations = 300, .initial_barrier = 0.1, .kkt_solver = kkt});
  return [q, program, ipopt, start = Eigen::VectorXd(c.points.reshaped())]
  {
    const auto solution = ipopt->solve(*program, {start, {}, {}, {}}, core::Deadline::none());
    return answerOf(solution.report, NormProgram(*q, 0.0).cost(solution.point.x));
  };
}

/// Augmented Lagrangian around L-BFGS, rounded norms, eps 1e-3; feasible to 1e-4 m counts as
/// solved.
std::function<Answer()> normsByNlopt(const ChainProblem& c)
{
  struct Task
  {
    explicit Task(const ChainProblem& instance) : q(socpOf(instance)) {}
    Task(const Task&) = delete;
    optim::PathSocp q;
    NormProgram program{q, 1e-3};
  };
  auto task = std::make_shared<Task>(c);
  return [task, start = c.points]
  {
    const auto n = static_cast<unsigned>(task->program.variables());
    const auto m = static_cast<unsigned>(task->program.constraints());
    nlopt::opt inner(nlopt::LD_LBFGS, n), outer(nlopt::AUGLAG, n);
    inner.set_vector_storage(10);
    inner.set_ftol_rel(1e-5);
    outer.set_local_optimizer(inner);
    outer.set_min_objective(
        [](unsigned size, const double* x, double* gradient, void* data)
        {
          const auto& program = static_cast<Task*>(data)->program;
          const Eigen::Map<const Eigen::VectorXd> at(x, size);
          if (gradient != nullptr)
            program.gradient(at, Eigen::Map<Eigen::VectorXd>(gradient, size));
          return program.cost(at);
        },
        task.get());
    outer.add_inequality_mconstraint(
        [](unsigned rows, double* result, unsigned size, const double* x, double* gradient,
           void* data)
        {
          const auto& program = static_cast<Task*>(data)->program;
          const Eigen::Map<const Eigen::VectorXd> at(x, size);
          Eigen::Map<Eigen::VectorXd> g(result, rows);
          program.constraint(at, g);
          Eigen::VectorXd lower(size), upper(size), g_lower(rows), g_upper(rows);
          program.bounds(lower, upper, g_lower, g_upper);
          g -= g_upper;
          if (gradient == nullptr) return;
          std::fill(gradient, gradient + std::size_t{rows} * size, 0.0);
          const auto entries = program.jacobianStructure();
          Eigen::VectorXd values(static_cast<Eigen::Index>(entries.size()));
          program.jacobian(at, values);
          for (std::size_t i = 0; i < entries.size(); ++i)
            gradient[std::size_t(entries[i].row) * size + std::size_t(entries[i].col)] =
                values[static_cast<Eigen::Index>(i)];
        },
        task.get(), std::vector<double>(m, 1e-4));
    outer.set_ftol_rel(1e-4);
    outer.set_maxeval(20000);
    std::vector<double> x(start.data(), start.data() + start.size());
    double cost = 0.0;
    try
    {
      (void)outer.optimize(x, cost);
    }
    catch (const std::exception&)
    {
      return Answer{};
    }
    const Eigen::Map<const Eigen::Matrix3Xd> p(x.data(), 3, start.cols());
    return Answer{optim::test::violation(task->q.sets, p) < 1e-3,
                  NormProgram(task->q, 0.0).cost(p.reshaped())};
  };
}

std::function<Answer()> squares(const ChainProblem& c, double margin)
{
  return [q = qpOf(c, margin)]
  {
    const auto solution = optim::solve(q);
    return answerOf(solution.report, solution.report.cost);
  };
}

std::function<Answer()> squaresByIpopt(const ChainProblem& c, double margin)
{
  auto q = std::make_shared<optim::PathQp>(qpOf(c, margin));
  auto program = std::make_shared<QuadraticProgram>(*q);
  auto ipopt = std::make_shared<optim::IpoptSolver>(
      optim::IpoptConfig{.tolerance = 1e-6, .max_iterations = 300, .initial_barrier = 0.1});
  Eigen::VectorXd start = Eigen::VectorXd::Zero(program->variables());
  start.head(c.points.size()) = c.points.reshaped();
  return [q, program, ipopt, start]
  {
    const auto solution = ipopt->solve(*program, {start, {}, {}, {}}, core::Deadline::none());
    return answerOf(solution.report, solution.report.cost);
  };
}

/// Eq. (5) is separable: one projection per point.
std::function<Answer()> projections(const ChainProblem& c)
{
  return [&c]
  {
    Answer answer{true, 0.0};
    for (Eigen::Index j = 0; j < c.points.cols(); ++j)
    {
      const auto p =
          geometry::project(c.points.col(j), c.sets[c.owner[static_cast<std::size_t>(j)]]);
      answer.solved = answer.solved && p.has_value();
      if (p) answer.cost += (*p - c.points.col(j)).norm();
    }
    return answer;
  };
}

std::function<Answer()> projectionsByIpopt(const ChainProblem& c)
{
  auto program = std::make_shared<DeadZoneProgram>(c.points, c.perPoint());
  auto ipopt = std::make_shared<optim::IpoptSolver>(
      optim::IpoptConfig{.tolerance = 1e-6, .max_iterations = 300, .initial_barrier = 0.1});
  return [program, ipopt, c_points = c.points]
  {
    const auto solution =
        ipopt->solve(*program, {c_points.reshaped(), {}, {}, {}}, core::Deadline::none());
    const Eigen::Matrix3Xd p = solution.point.x.reshaped(3, c_points.cols());
    return answerOf(solution.report, (p - c_points).colwise().norm().sum());
  };
}

void add(const char* name, const Family& f, const char* task, Solver solver, int passes)
{
  benchmark::RegisterBenchmark((std::string(name) + "/" + f.name).c_str(),
                               [&f, task = std::string(task), solver](benchmark::State& state)
                               { measure(state, f, task, solver); })
      ->Iterations(passes)
      ->Unit(benchmark::kMillisecond);
}

const bool registered = []
{
  using optim::KktSolver;
  constexpr double kMargin = 0.35;
  for (const Family* f :
       {&family("push_k0_n15_m20", 16, 1, 20), &family("push_k1_n15_m20", 16, 3, 20),
        &family("push_k0_n30_m40", 31, 1, 40)})
  {
    add("PathSocp", *f, "norms", norms, 50);
    if (f->name.find("k0") != std::string::npos)
      add("PathSocp_longWay", *f, "norms", normsTheLongWay, 50);
    add("NloptAuglag_norms", *f, "norms", normsByNlopt, 1);
    add(
        "Ipopt_norms", *f, "norms",
        [](const ChainProblem& c) { return normsByIpopt(c, KktSolver::Ldlt); }, 1);
    add(
        "IpoptMumps_norms", *f, "norms",
        [](const ChainProblem& c) { return normsByIpopt(c, KktSolver::Mumps); }, 1);
    add(
        "PathQp_hard", *f, "hard squares", [](const ChainProblem& c) { return squares(c, 0.0); },
        50);
    add(
        "PathQp_margin", *f, "squares", [](const ChainProblem& c) { return squares(c, kMargin); },
        50);
    add(
        "Ipopt_squares", *f, "squares",
        [](const ChainProblem& c) { return squaresByIpopt(c, kMargin); }, 1);
  }
  const Family& dead = family("dead_k0_n40_m20", 40, 1, 20);
  add("Project", dead, "dead zone", projections, 200);
  add("Ipopt_deadZone", dead, "dead zone", projectionsByIpopt, 1);
  return true;
}();

}  // namespace
}  // namespace slalom
