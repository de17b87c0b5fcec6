// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

#include "NlpCheck.h"
#include "TrackingInputs.h"
#include "TrackingProblems.h"
#include "TrackingProgram.h"
#include "TrackingRiccati.h"

namespace
{
using namespace slalom::optim;
using slalom::core::Deadline;
using slalom::core::Rng;
using slalom::core::Termination;
using slalom::test::TrackingFlight;
using slalom::test::WildTracking;

constexpr double kTolerance = 1e-6;
constexpr double kRounding = 1e-12;

template <int D>
std::unique_ptr<TrackingSolver<D>> solverOf(const TrackingQp<D>& qp,
                                            TrackingSolverConfig config = {})
{
  return makeTrackingSolver<D>(config, static_cast<int>(qp.stages.size()), qp.max_rows);
}

/// Of a size of its own.
template <int D>
WildTracking<D> wildOf(std::uint64_t seed)
{
  Rng rng(seed);
  const int stages = rng.integer(1, 30), rows = rng.integer(0, 10);
  return WildTracking<D>(rng, stages, rows);
}

/// What holds for every answer, good or early.
template <int D>
void expectUsable(const TrackingQp<D>& qp, const TrackingSolution<D>& solution)
{
  ASSERT_TRUE(solution.inputs.allFinite());
  const TrackingResiduals residuals = trackingResiduals<D>(qp, solution);
  EXPECT_LE(residuals.limits, kRounding);
  EXPECT_LE(residuals.dynamics, 1e-9);
  EXPECT_NEAR(solution.report.cost, trackingCost<D>(qp, solution.inputs),
              1e-12 * (1.0 + std::abs(solution.report.cost)));
}

template <class T>
class Tracking : public testing::Test
{
};
template <int D>
struct Axes
{
  static constexpr int value = D;
};
using BothSizes = testing::Types<Axes<1>, Axes<3>>;
TYPED_TEST_SUITE(Tracking, BothSizes);

TYPED_TEST(Tracking, WildProgramsConvergeToTheirKktPoint)
{
  constexpr int D = TypeParam::value;
  constexpr int kPrograms = 2000;
  int converged = 0, most = 0;
  for (int seed = 0; seed < kPrograms; ++seed)
  {
    SCOPED_TRACE(seed);
    const WildTracking<D> wild = wildOf<D>(static_cast<std::uint64_t>(seed));
    const auto solver = solverOf<D>(wild.qp);
    const auto& solution = solver->solve(wild.qp, wild.guess, Deadline::none());
    expectUsable<D>(wild.qp, solution);
    if (!solution.report.converged()) continue;
    ++converged;
    most = std::max(most, solution.report.iterations);
    EXPECT_LE(trackingResiduals<D>(wild.qp, solution).dual(), 1.001 * kTolerance);
    EXPECT_LE(solution.report.dual_residual, kTolerance);
  }
  EXPECT_GE(converged, kPrograms * 999 / 1000);
  testing::Test::RecordProperty("converged", converged);
  testing::Test::RecordProperty("most_iterations", most);
}

TYPED_TEST(Tracking, AgreesWithIpopt)
{
  constexpr int D = TypeParam::value;
  constexpr int kPrograms = 150;
  int both = 0;
  for (int seed = 0; seed < kPrograms; ++seed)
  {
    SCOPED_TRACE(seed);
    const WildTracking<D> wild = wildOf<D>(static_cast<std::uint64_t>(10000 + seed));
    const auto riccati = solverOf<D>(wild.qp);
    const auto ipopt = solverOf<D>(
        wild.qp, {.back_end = TrackingBackEnd::Ipopt, .tolerance = 1e-7, .max_iterations = 300});
    const auto& a = riccati->solve(wild.qp, wild.guess, Deadline::none());
    const auto& b = ipopt->solve(wild.qp, wild.guess, Deadline::none());
    expectUsable<D>(wild.qp, b);
    if (!a.report.converged() || !b.report.converged()) continue;
    ++both;
    EXPECT_NEAR(a.report.cost, b.report.cost, 1e-5 * (1.0 + std::abs(b.report.cost)));
    EXPECT_LE(b.report.dual_residual, 1e-4);
  }
  EXPECT_GE(both, kPrograms * 95 / 100);
  testing::Test::RecordProperty("both_converged", both);
}

// The residuals would be of no use if they were small anywhere else.
TYPED_TEST(Tracking, NoOtherInputsAreAsGood)
{
  constexpr int D = TypeParam::value;
  for (int seed = 0; seed < 200; ++seed)
  {
    SCOPED_TRACE(seed);
    const WildTracking<D> wild = wildOf<D>(static_cast<std::uint64_t>(20000 + seed));
    const int stages = static_cast<int>(wild.qp.stages.size());
    const auto solver = solverOf<D>(wild.qp);
    const TrackingSolution<D> best = solver->solve(wild.qp, wild.guess, Deadline::none());
    ASSERT_TRUE(best.report.converged());
    Rng rng(static_cast<std::uint64_t>(seed));
    detail::TrackingInputs<D> limits(stages);
    for (const double size : {1e-3, 1e-1, 1.0})
    {
      typename WildTracking<D>::Matrix other = best.inputs;
      for (Eigen::Index i = 0; i < other.size(); ++i) other.data()[i] += size * rng.normal();
      limits.prepare(wild.qp, other);
      EXPECT_GE(trackingCost<D>(wild.qp, limits.clipped),
                best.report.cost - 1e-4 * (1.0 + std::abs(best.report.cost)));
    }
    TrackingSolution<D> wrong = best;
    wrong.inputs.col(0).setConstant(0.5 * best.inputs(0, 0) + 1.0);
    EXPECT_GT(trackingResiduals<D>(wild.qp, wrong).dynamics, 1e-4);
    wrong = best;
    wrong.input_forces.col(stages - 1).array() += 1.0;
    const TrackingResiduals judged = trackingResiduals<D>(wild.qp, wrong);
    EXPECT_GT(judged.stationarity, 0.9);
  }
}

TYPED_TEST(Tracking, EveryProcessorGivesTheSameBits)
{
  constexpr int D = TypeParam::value;
  using detail::InstructionSet;
  for (int seed = 0; seed < 100; ++seed)
  {
    SCOPED_TRACE(seed);
    const WildTracking<D> wild = wildOf<D>(static_cast<std::uint64_t>(30000 + seed));
    const int stages = static_cast<int>(wild.qp.stages.size());
    detail::TrackingRiccati<D> portable({}, stages, wild.qp.max_rows, InstructionSet::Portable);
    detail::TrackingRiccati<D> best({}, stages, wild.qp.max_rows);
    const TrackingSolution<D> first = portable.solve(wild.qp, wild.guess, Deadline::none());
    // A program in between must leave nothing behind.
    Rng rng(static_cast<std::uint64_t>(seed));
    const WildTracking<D> between(rng, stages, wild.qp.max_rows);
    (void)best.solve(between.qp, between.guess, Deadline::none());
    const TrackingSolution<D>& second = best.solve(wild.qp, wild.guess, Deadline::none());
    EXPECT_EQ(first.inputs, second.inputs);
    EXPECT_EQ(first.row_forces, second.row_forces);
    EXPECT_EQ(first.report.iterations, second.report.iterations);
  }
}

TYPED_TEST(Tracking, StoppedEarlyItStillKeepsTheLimits)
{
  constexpr int D = TypeParam::value;
  for (int seed = 0; seed < 100; ++seed)
    for (const int cap : {0, 1, 2, 5})
    {
      SCOPED_TRACE(testing::Message() << seed << " cap " << cap);
      const WildTracking<D> wild = wildOf<D>(static_cast<std::uint64_t>(40000 + seed));
      const auto solver = solverOf<D>(wild.qp, {.max_iterations = cap});
      const auto& solution = solver->solve(wild.qp, wild.guess, Deadline::none());
      EXPECT_LE(solution.report.iterations, cap);
      expectUsable<D>(wild.qp, solution);
      detail::TrackingInputs<D> limits(static_cast<int>(wild.qp.stages.size()));
      limits.prepare(wild.qp, wild.guess);
      if (solution.report.converged()) continue;
      EXPECT_LE(solution.report.cost, trackingCost<D>(wild.qp, limits.clipped));
    }
}

TYPED_TEST(Tracking, ADeadlineThatHasPassedGivesAUsableAnswer)
{
  constexpr int D = TypeParam::value;
  for (const auto back_end : {TrackingBackEnd::Riccati, TrackingBackEnd::Ipopt})
    for (int seed = 0; seed < 30; ++seed)
    {
      SCOPED_TRACE(seed);
      const WildTracking<D> wild = wildOf<D>(static_cast<std::uint64_t>(50000 + seed));
      const auto solver = solverOf<D>(wild.qp, {.back_end = back_end});
      const auto& solution =
          solver->solve(wild.qp, wild.guess, Deadline::in(std::chrono::nanoseconds(0)));
      EXPECT_EQ(solution.report.termination, Termination::TimeLimit) << solution.report.message;
      expectUsable<D>(wild.qp, solution);
    }
}

TYPED_TEST(Tracking, DataThatAreNotFiniteAreRefusedWithFiniteInputsInsideTheLimits)
{
  constexpr int D = TypeParam::value;
  using Change = std::function<void(WildTracking<D>&, double)>;
  const auto middle = [](WildTracking<D>& wild) -> TrackingStage<D>&
  { return wild.qp.stages[wild.qp.stages.size() / 2]; };
  const std::vector<Change> changes{[](auto& w, double bad) { w.qp.p[0] = bad; },
                                    [](auto& w, double bad) { w.qp.v[0] = bad; },
                                    [](auto& w, double bad) { w.qp.u_before[0] = bad; },
                                    [](auto& w, double bad) { w.guess(0, 1) = bad; },
                                    [&](auto& w, double bad) { middle(w).position[0] = bad; },
                                    [&](auto& w, double bad) { middle(w).velocity[0] = bad; },
                                    [&](auto& w, double bad) { middle(w).input[0] = bad; },
                                    [&](auto& w, double bad) { middle(w).change[0] = bad; },
                                    [&](auto& w, double bad) { middle(w).drift_p[0] = bad; },
                                    [&](auto& w, double bad) { middle(w).drift_v[0] = bad; },
                                    [&](auto& w, double bad)
                                    { middle(w).position_weight(0, 0) = bad; },
                                    [&](auto& w, double bad) { middle(w).velocity_weight = bad; },
                                    [&](auto& w, double bad) { middle(w).change_weight = bad; },
                                    [&](auto& w, double bad) { middle(w).response.p_u = bad; },
                                    [&](auto& w, double bad) { middle(w).change_limit[0] = bad; },
                                    [](auto& w, double bad) { w.qp.rows[0].offset = bad; },
                                    [](auto& w, double bad) { w.qp.rows[0].normal[0] = bad; },
                                    [](auto& w, double bad) { w.qp.rows[0].penalty = bad; }};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const auto back_end : {TrackingBackEnd::Riccati, TrackingBackEnd::Ipopt})
    for (std::size_t i = 0; i < changes.size(); ++i)
      for (const double bad : {nan, infinity, -infinity})
      {
        SCOPED_TRACE(testing::Message() << i << " " << bad);
        Rng rng(60000 + i);
        WildTracking<D> wild(rng, 8, 3);
        wild.qp.row_counts.assign(8, 1);
        const auto solver = solverOf<D>(wild.qp, {.back_end = back_end});
        changes[i](wild, bad);
        const auto& solution = solver->solve(wild.qp, wild.guess, Deadline::none());
        EXPECT_EQ(solution.report.termination, Termination::NumericalFailure);
        ASSERT_TRUE(solution.inputs.allFinite() && solution.positions.allFinite() &&
                    solution.velocities.allFinite());
        for (int k = 0; k < 8; ++k)
          EXPECT_TRUE((solution.inputs.col(k).array().abs() <=
                       wild.qp.stages[static_cast<std::size_t>(k)].input_limit.array())
                          .all());
      }
}

TYPED_TEST(Tracking, AnInputOutsideItsLimitComesBackAsFastAsItMay)
{
  constexpr int D = TypeParam::value;
  for (const auto back_end : {TrackingBackEnd::Riccati, TrackingBackEnd::Ipopt})
  {
    TrackingQp<D> qp(10, 0);
    for (auto& stage : qp.stages)
    {
      stage.response = slalom::core::VelocityResponse::over(0.1, 0.2);
      stage.input_weight = 1.0;
      stage.input.setConstant(2.0);
      stage.input_limit.setConstant(0.6);
      stage.change_limit.setConstant(0.1);
    }
    qp.u_before.setConstant(1.0);
    const auto solver = solverOf<D>(qp, {.back_end = back_end, .max_iterations = 100});
    const typename WildTracking<D>::Matrix guess = WildTracking<D>::Matrix::Zero(D, 10);
    const auto& solution = solver->solve(qp, guess, Deadline::none());
    EXPECT_EQ(solution.report.termination, Termination::Infeasible);
    EXPECT_NEAR(solution.report.primal_residual, 0.3, 0.002);
    const double expected[] = {0.9, 0.8, 0.7, 0.6, 0.6};
    for (int k = 0; k < 5; ++k) EXPECT_NEAR(solution.inputs(0, k), expected[k], 0.006) << k;
    // Once the limits can be kept they are.
    EXPECT_LE(solution.inputs.rightCols(6).cwiseAbs().maxCoeff(), 0.6 + kRounding);
  }
}

TEST(TrackingQp, ThreeAxesThatDoNotMeetAreThreeHeadings)
{
  for (int seed = 0; seed < 50; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(static_cast<std::uint64_t>(70000 + seed));
    const int stages = rng.integer(1, 25);
    const WildTracking<1> axes[] = {{rng, stages, 2}, {rng, stages, 2}, {rng, stages, 2}};
    TrackingQp<3> qp(stages, 6);
    Eigen::Matrix3Xd guess(3, stages);
    double cost = 0.0;
    bool converged = true;
    for (int i = 0; i < 3; ++i)
    {
      TrackingQp<1> one = axes[i].qp;
      // What the axes share in three dimensions.
      for (std::size_t k = 0; k < one.stages.size(); ++k)
      {
        const TrackingStage<1>& common = axes[0].qp.stages[k];
        one.stages[k].response = common.response;
        one.stages[k].velocity_weight = common.velocity_weight;
        one.stages[k].input_weight = common.input_weight;
        one.stages[k].change_weight = common.change_weight;
        const TrackingStage<1>& own = one.stages[k];
        TrackingStage<3>& joint = qp.stages[k];
        joint.response = own.response;
        joint.velocity_weight = own.velocity_weight;
        joint.input_weight = own.input_weight;
        joint.change_weight = own.change_weight;
        joint.drift_p[i] = own.drift_p[0];
        joint.drift_v[i] = own.drift_v[0];
        joint.position[i] = own.position[0];
        joint.velocity[i] = own.velocity[0];
        joint.input[i] = own.input[0];
        joint.change[i] = own.change[0];
        joint.position_weight(i, i) = own.position_weight(0, 0);
        joint.input_limit[i] = own.input_limit[0];
        joint.change_limit[i] = own.change_limit[0];
        for (int j = 0; j < one.row_counts[k]; ++j)
        {
          const SoftRow<1>& row = one.rows[k * 2 + static_cast<std::size_t>(j)];
          qp.rows[k * 6 + static_cast<std::size_t>(qp.row_counts[k]++)] = {
              row.normal[0] * Eigen::Vector3d::Unit(i), row.lead, row.offset, row.penalty};
        }
      }
      qp.p[i] = one.p[0];
      qp.v[i] = one.v[0];
      qp.u_before[i] = one.u_before[0];
      guess.row(i) = axes[i].guess;
      const auto solver = solverOf<1>(one);
      const auto& solution = solver->solve(one, axes[i].guess, Deadline::none());
      cost += solution.report.cost;
      converged = converged && solution.report.converged();
    }
    const auto solver = solverOf<3>(qp);
    const auto& solution = solver->solve(qp, guess, Deadline::none());
    ASSERT_TRUE(converged && solution.report.converged());
    EXPECT_NEAR(solution.report.cost, cost, 1e-5 * (1.0 + std::abs(cost)));
  }
}

TEST(TrackingQp, RowsThatCanHoldDoHoldUnderALargePenalty)
{
  for (int seed = 1; seed <= 5; ++seed)
  {
    SCOPED_TRACE(seed);
    // The tangent planes of one ball on the way, from outside of it: there is a way past.
    TrackingFlight::Setting setting;
    setting.rows = 0;
    TrackingFlight flight(setting, static_cast<std::uint64_t>(seed));
    const TrackingQp<3>& plain = flight.next();
    TrackingQp<3> qp(15, 1);
    qp.p = plain.p, qp.v = plain.v, qp.u_before = plain.u_before;
    qp.stages = plain.stages;
    for (std::size_t k = 0; k < 15; ++k)
    {
      qp.row_counts[k] = 1;
      qp.rows[k] = {-Eigen::Vector3d::UnitX(), 0.0, -(qp.p.x() + 0.3), 1e4};
    }
    const auto solver = solverOf<3>(qp);
    const auto& solution = solver->solve(qp, flight.guess(), Deadline::none());
    ASSERT_TRUE(solution.report.converged());
    EXPECT_LE(solution.worst_slack, 1e-6);
    EXPECT_GE(solution.row_forces.maxCoeff(), 1e-2) << "the row should matter";
    // A small one gives way instead, to where the forces are the whole penalty.
    for (auto& row : qp.rows) row.penalty = 1e-2;
    const auto& soft = solver->solve(qp, flight.guess(), Deadline::none());
    ASSERT_TRUE(soft.report.converged());
    EXPECT_GT(soft.worst_slack, 0.01);
    EXPECT_NEAR(soft.row_forces.maxCoeff(), 1e-2, 1e-4);
  }
}

TEST(TrackingQp, ClosedLoopsConvergeQuicklyEvenFromInsideTheMargin)
{
  for (const double lag : {0.0, 0.2})
    for (const double pushed : {0.0, 0.5})
      for (std::uint64_t seed = 1; seed <= 3; ++seed)
      {
        SCOPED_TRACE(testing::Message() << lag << " " << pushed << " " << seed);
        TrackingFlight::Setting setting;
        setting.lag = lag;
        setting.dt = lag > 0.0 ? 0.1 : 0.05;
        setting.wind = 0.05;
        setting.pushed = pushed;
        TrackingFlight flight(setting, seed);
        const auto solver = makeTrackingSolver<3>({}, setting.stages, setting.rows);
        double iterations = 0.0;
        for (int i = 0; i < 100; ++i)
        {
          const TrackingQp<3>& qp = flight.next();
          const auto& solution = solver->solve(qp, flight.guess(), Deadline::none());
          ASSERT_TRUE(solution.report.converged()) << solution.report.message;
          EXPECT_LE(trackingResiduals<3>(qp, solution).dual(), 1.001 * kTolerance);
          EXPECT_LE(solution.report.iterations, 25);
          iterations += solution.report.iterations;
          flight.fly(solution.inputs);
        }
        EXPECT_LE(iterations / 100.0, 10.0);
      }
}

TEST(TrackingQp, TheProgramForIpoptHasExactDerivatives)
{
  for (int seed = 0; seed < 10; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(static_cast<std::uint64_t>(80000 + seed));
    const WildTracking<3> wild(rng, 3, 2);
    detail::TrackingInputs<3> limits(3);
    limits.prepare(wild.qp, wild.guess);
    detail::TrackingProgram<3> program(3, 2);
    program.set(wild.qp, limits.low, limits.high);
    const auto any = [&](int size)
    { return Eigen::VectorXd(Eigen::VectorXd::NullaryExpr(size, [&] { return rng.normal(); })); };
    slalom::test::expectExactDerivatives(program, any(program.variables()), rng.uniform(0.1, 2.0),
                                         any(program.constraints()));
  }
}

TEST(TrackingQp, MisuseIsRefused)
{
  EXPECT_THROW((void)makeTrackingSolver<3>({}, 0, 2), std::invalid_argument);
  EXPECT_THROW((void)makeTrackingSolver<3>({}, 5, -1), std::invalid_argument);
  EXPECT_THROW((void)makeTrackingSolver<1>({.tolerance = 0.0}, 5, 1), std::invalid_argument);
  EXPECT_THROW((void)makeTrackingSolver<1>({.max_iterations = -1}, 5, 1), std::invalid_argument);
  const auto solver = makeTrackingSolver<3>({}, 5, 2);
  TrackingQp<3> qp(5, 2), longer(6, 2), crowded(5, 3);
  const auto refused = [&](const TrackingQp<3>& given, int columns)
  {
    const Eigen::Matrix3Xd guess = Eigen::Matrix3Xd::Zero(3, columns);
    const auto& solution = solver->solve(given, guess, Deadline::none());
    EXPECT_TRUE(solution.inputs.allFinite());
    return solution.report.termination == Termination::NumericalFailure;
  };
  EXPECT_FALSE(refused(qp, 5));
  EXPECT_TRUE(refused(qp, 4));
  EXPECT_TRUE(refused(longer, 5));
  EXPECT_TRUE(refused(crowded, 5));
  qp.stages[2].input_limit[1] = 0.0;
  EXPECT_TRUE(refused(qp, 5));
}

}  // namespace
