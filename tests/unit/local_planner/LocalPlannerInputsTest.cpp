// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "ClosedLoop.h"
#include "slalom/core/Rng.h"
#include "slalom/local_planner/LocalPlanner.h"

namespace
{
using Eigen::Vector3d;
using slalom::core::Deadline;
using slalom::core::Rng;
using slalom::core::Vehicle;
using slalom::core::VelocityCommand;
using namespace slalom::local_planner;
using slalom::test::ClosedLoop;
using slalom::test::fieldOf;
using slalom::test::Sphere;
using slalom::test::straightReference;
using slalom::test::VerticalCylinder;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const Deadline kPast = Deadline::in(std::chrono::nanoseconds(-1));

/// The change is counted from the last command as far as that was a lawful one.
void expectLawful(const LocalPlannerOutput& output, const LocalPlannerInput& input,
                  const Vehicle& vehicle, double dt)
{
  ASSERT_TRUE(output.command.v_W.allFinite());
  ASSERT_TRUE(std::isfinite(output.command.yaw_rate));
  EXPECT_LE(output.command.v_W.cwiseAbs().maxCoeff(), vehicle.max_speed_mps);
  EXPECT_LE(std::abs(output.command.yaw_rate), vehicle.max_yaw_rate_radps);
  for (int i = 0; i < 3; ++i)
  {
    if (!std::isfinite(input.last_command.v_W[i])) continue;
    const double last =
        std::clamp(input.last_command.v_W[i], -vehicle.max_speed_mps, vehicle.max_speed_mps);
    EXPECT_LE(std::abs(output.command.v_W[i] - last),
              vehicle.max_acceleration_mps2 * dt * (1.0 + 1e-9));
  }
  EXPECT_FALSE(output.reason.empty());
  EXPECT_EQ(output.reason.find('\n'), std::string::npos);
}

/// Mostly sensible numbers, now and then something that no sensor should say.
class Garbage
{
 public:
  explicit Garbage(Rng& rng, int one_in) : rng_(rng), one_in_(one_in) {}
  double operator()(double size)
  {
    const double bad[] = {kNan, HUGE_VAL, -HUGE_VAL, 1e300, -1e12, 1e5, 0.0, 1e-320};
    if (one_in_ > 0 && rng_.integer(0, one_in_) == 0) return bad[rng_.integer(0, 7)];
    return rng_.uniform(-size, size);
  }
  Vector3d vector(double size) { return {(*this)(size), (*this)(size), (*this)(size)}; }

 private:
  Rng& rng_;
  int one_in_;
};

TEST(LocalPlannerInputs, CommandsAreLawfulWhateverComesIn)
{
  LocalPlannerConfig config;
  config.horizon = 6;
  config.max_iterations = 25;
  const Vehicle vehicle;
  const auto reference = straightReference(Vector3d(-5, 0, 1), Vector3d(0.8, 0.2, 0.0), 15.0);
  const auto field = fieldOf({VerticalCylinder{{0.0, 1.0}, 0.5}, Sphere{Vector3d(2, 2, 1), 0.8},
                              Eigen::AlignedBox3d(Vector3d(3, -3, -1), Vector3d(4, 0, 2))});
  int fresh = 0, braked = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    Garbage number(rng, seed % 2 ? 30 : 0);
    LocalPlanner planner(config, vehicle);
    double t = 0.0;
    for (int step = 0; step < 8; ++step)
    {
      LocalPlannerInput input;
      t += rng.uniform(0.01, 0.15);
      input.state.t = t;
      input.state.p_L = number.vector(6.0);
      input.state.v_W = number.vector(2.0);
      input.state.q_WB = slalom::core::fromYaw(number(3.0));
      input.last_command = {number.vector(2.0), number(2.0)};
      input.progress = number(12.0);
      if (rng.integer(0, 20) > 0) input.reference = reference;
      if (rng.integer(0, 20) > 0)
        input.law = slalom::test::lawTo(*reference, rng.uniform(0.0, 15.0), rng.uniform(0.1, 2.0));
      if (rng.integer(0, 4) > 0) input.field = field;
      if (rng.integer(0, 20) == 0) input.field = std::make_shared<slalom::test::BrokenField>();
      if (rng.integer(0, 20) == 0) input.deadline = kPast;
      if (rng.integer(0, 3) == 0)
        input.movers.push_back({.t = number(9.0),
                                .p_L = number.vector(6.0),
                                .v_L = number.vector(2.0),
                                .radius_m = std::abs(number(1.0)),
                                .sigma_p_m = std::abs(number(0.2)),
                                .sigma_v_mps = std::abs(number(0.2))});
      if (rng.integer(0, 3) == 0) input.disturbance_W = number.vector(1.0);
      const LocalPlannerOutput output = planner.step(input);
      expectLawful(output, input, vehicle, config.step_s);
      if (HasFatalFailure()) return;
      fresh += output.fallback == Fallback::None;
      braked += output.fallback == Fallback::Brake;
      const bool sane = input.state.p_L.allFinite() && input.state.v_W.allFinite() &&
                        input.last_command.v_W.allFinite() && std::isfinite(input.progress) &&
                        std::isfinite(input.last_command.yaw_rate);
      if (!sane || !input.reference || !input.law)
      {
        EXPECT_EQ(output.fallback, Fallback::Brake) << output.reason;
      }
    }
  }
  EXPECT_GT(fresh, 1000);  // the law is about planning, not only about braking
  EXPECT_GT(braked, 200);
}

TEST(LocalPlannerInputs, NanBrakesFromTheLastLawfulCommand)
{
  LocalPlanner planner({}, Vehicle{});
  LocalPlannerInput input;
  input.reference = straightReference(Vector3d::Zero(), Vector3d(1, 0, 0), 10.0);
  input.law = slalom::test::lawTo(*input.reference, 10.0);
  input.state.p_L.y() = kNan;
  input.last_command.v_W = Vector3d(1.0, -0.05, 0.4);
  const LocalPlannerOutput output = planner.step(input);
  EXPECT_EQ(output.fallback, Fallback::Brake);
  EXPECT_LE((output.command.v_W - Vector3d(0.9, 0.0, 0.3)).norm(), 1e-12);
  EXPECT_EQ(output.command.yaw_rate, 0.0);
  EXPECT_NE(output.reason.find("state"), std::string::npos);
}

TEST(LocalPlannerInputs, LadderIsShiftedThenCommittedThenBrakeThenProbation)
{
  ClosedLoop loop(straightReference(Vector3d::Zero(), Vector3d(1, 0, 0), 20.0), fieldOf({}));
  loop.fly(7.0);
  ASSERT_NEAR(loop.command.v_W.x(), 1.0, 0.02);
  loop.input.deadline = kPast;
  for (int i = 0; i < 5; ++i)
  {
    const auto output = loop.tick();
    EXPECT_EQ(output.fallback, Fallback::Shifted) << i;
    EXPECT_EQ(output.report.termination, slalom::core::Termination::TimeLimit);
    EXPECT_NEAR(output.command.v_W.x(), 1.0, 0.05);
    EXPECT_EQ(output.horizon_L.cols(), LocalPlannerConfig{}.horizon + 1);
  }
  for (int i = 0; i < 60; ++i)
  {
    EXPECT_EQ(loop.tick().fallback, Fallback::Committed) << i;
    EXPECT_LE(loop.trackingError(), 0.02);
  }
  // A wall on the way that the committed reference knows nothing of: brake, and rest before it.
  const double wall = loop.state.p_L.x() + 2.2;
  loop.input.field =
      fieldOf({Eigen::AlignedBox3d(Vector3d(wall, -9, -9), Vector3d(wall + 1, 9, 9))});
  double before = loop.command.v_W.x();
  while (loop.command.v_W.norm() > 0.0)
  {
    const auto output = loop.tick();
    EXPECT_NE(output.fallback, Fallback::None);
    EXPECT_GE(loop.command.v_W.x(), std::max(0.0, before - 0.05) - 1e-9);
    before = loop.command.v_W.x();
  }
  EXPECT_GE(loop.clearance(), Vehicle{}.radius_m);
  EXPECT_EQ(loop.tick().fallback, Fallback::Brake);
  // The way is free again: only the third good solution in a row is flown.
  loop.input.field = fieldOf({});
  loop.input.deadline = Deadline::none();
  EXPECT_EQ(loop.tick().fallback, Fallback::Brake);
  EXPECT_EQ(loop.tick().fallback, Fallback::Brake);
  EXPECT_EQ(loop.tick().fallback, Fallback::None);
}

TEST(LocalPlannerInputs, NoOldPlanIsFlownIntoSomethingNew)
{
  ClosedLoop loop(straightReference(Vector3d::Zero(), Vector3d(1, 0, 0), 20.0), fieldOf({}));
  loop.fly(3.0);
  loop.input.deadline = kPast;
  loop.input.field = fieldOf({Sphere{loop.state.p_L + Vector3d(1.2, 0, 0), 0.4}});
  EXPECT_EQ(loop.tick().fallback, Fallback::Brake);
}

TEST(LocalPlannerInputs, RunsAreBitEqualAndResetForgets)
{
  const auto reference = straightReference(Vector3d(0, 0, 1), Vector3d(0.9, 0.3, 0), 20.0);
  const auto field =
      fieldOf({VerticalCylinder{{3.0, 1.2}, 0.4}, VerticalCylinder{{6.0, 1.8}, 0.3}});
  ClosedLoop first(reference, field), second(reference, field);
  std::vector<VelocityCommand> commands;
  first.fly(8.0, [&](const auto& output) { commands.push_back(output.command); });
  std::size_t i = 0;
  second.fly(8.0,
             [&](const auto& output)
             {
               EXPECT_EQ(output.command.v_W, commands[i].v_W) << i;
               EXPECT_EQ(output.command.yaw_rate, commands[i].yaw_rate) << i;
               ++i;
             });

  // The first planner has flown; after reset() it decides like one that never has.
  first.planner().reset();
  LocalPlanner fresh({}, slalom::test::atOnce());
  LocalPlannerInput input = second.input;
  for (int step = 0; step < 5; ++step)
  {
    input.state.t = 0.05 * step;
    const LocalPlannerOutput a = first.planner().step(input), b = fresh.step(input);
    EXPECT_EQ(a.command.v_W, b.command.v_W) << step;
    EXPECT_EQ(a.command.yaw_rate, b.command.yaw_rate) << step;
    EXPECT_EQ(a.report.iterations, b.report.iterations) << step;
    input.last_command = a.command;
  }
}

TEST(LocalPlannerInputs, ConstructionRefusesValuesOutOfRange)
{
  LocalPlannerConfig config;
  config.step_s = 0.0;
  EXPECT_THROW(LocalPlanner(config, Vehicle{}), std::invalid_argument);
  Vehicle vehicle;
  vehicle.max_acceleration_mps2 = kNan;
  EXPECT_THROW(LocalPlanner({}, vehicle), std::invalid_argument);
}

}  // namespace
