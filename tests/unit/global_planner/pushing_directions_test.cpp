// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "AnalyticField.h"
#include "PushingProgram.h"
#include "slalom/core/Rng.h"
#include "slalom/global_planner/Guides.h"
#include "slalom/global_planner/PushingDirections.h"
#include "slalom/global_planner/Retreat.h"

namespace slalom::global_planner
{
namespace
{
using core::HalfSpaces;
using core::Rng;
using core::UnknownAs;
using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using test::AnalyticField;
using test::VerticalCylinder;

constexpr double kHard = 0.45;

AnalyticField forest(Rng& rng, int trees)
{
  std::vector<test::Obstacle> obstacles;
  for (int i = 0; i < trees; ++i)
    obstacles.push_back(VerticalCylinder{
        Eigen::Vector2d(rng.uniform(1.5, 8.5), rng.uniform(-4.0, 4.0)), rng.uniform(0.2, 0.5)});
  return AnalyticField(obstacles, {Vector3d(-6, -8, 0), Vector3d(16, 8, 4)});
}

double clearanceOfEdge(const AnalyticField& field, const Vector3d& a, const Vector3d& b)
{
  double least = 1e9;
  for (int i = 0; i <= 20; ++i)
    least = std::min(least, field.signedDistance(a + (b - a) * i / 20.0));
  return least;
}

struct Found : PushingPath
{
  bool found = false;
};

/// Along the best guide between two places.
Found findPushingPath(const AnalyticField& field, const Vector3d& start, const Vector3d& goal,
                      Index points, double hard_clearance, const GlobalPlannerConfig& config)
{
  const GuideSearch search = searchGuides(field, start, goal, hard_clearance, 1, config);
  Found result;
  result.reason = search.reason;
  if (search.guides.empty()) return result;
  static_cast<PushingPath&>(result) =
      pushAlong(field, search.guides.front(), points, hard_clearance, config);
  result.found = true;
  return result;
}

double lengthOf(const Matrix3Xd& path)
{
  return arcLength(path).tail(1)[0];
}

TEST(PushingDirections, BothFormsLeadFromEndToEndInHardClearance)
{
  GlobalPlannerConfig squares, norms;
  norms.pushing = PushingForm::Socp;
  int bent = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const AnalyticField field = forest(rng, 12);
    const Vector3d start(0, 0, 1.5), goal(10, 0, 1.5);
    Matrix3Xd path_of[2];
    for (const auto* config : {&squares, &norms})
    {
      const Found found = findPushingPath(field, start, goal, 25, kHard, *config);
      ASSERT_TRUE(found.found) << found.reason;
      ASSERT_EQ(found.method, PushingMethod::Program) << found.reason;
      EXPECT_TRUE(found.solve.converged());
      ASSERT_EQ(found.path.cols(), 25);
      EXPECT_EQ(found.retreat_m, 0.0);
      EXPECT_LE((found.path.col(0) - start).norm(), 0.05);
      EXPECT_LE((found.path.col(24) - goal).norm(), 0.05);
      // Trunks are known by voxel centres inside them, so up to a voxel of clearance is lost.
      for (Index k = 0; k < 24; ++k)
        EXPECT_GE(clearanceOfEdge(field, found.path.col(k), found.path.col(k + 1)), kHard - 0.2);
      path_of[config == &norms] = found.path;
      if (config == &norms)
      {
        const double edge = lengthOf(found.path) / 24.0;
        for (Index k = 0; k < 24; ++k)
        {
          // Even along the path: a chord across a bend is shorter, never longer.
          const double chord = (found.path.col(k + 1) - found.path.col(k)).norm();
          EXPECT_LE(chord, 1.05 * edge);
          EXPECT_GE(chord, 0.75 * edge);
        }
        EXPECT_LE(lengthOf(found.path), lengthOf(found.guide) + 1e-6);
      }
    }
    // The string is taut, the squares keep away where they can.
    EXPECT_LE(lengthOf(path_of[1]), lengthOf(path_of[0]) + 0.02);
    bent += lengthOf(path_of[1]) > 10.05;
  }
  EXPECT_GT(bent, 10);
}

TEST(PushingDirections, AnEndInsideHardClearanceIsLeftAndReachedByALeg)
{
  int retreats = 0, approaches = 0, pockets = 0;
  for (std::uint64_t seed = 1; seed <= 70; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const AnalyticField field = forest(rng, 10);
    // Two places on trunks' flanks, or in the trunks.
    const auto nearTrunk = [&](double from, double to)
    {
      Vector3d p;
      do p = Vector3d(rng.uniform(from, to), rng.uniform(-4.0, 4.0), 1.5);
      while (field.signedDistance(p) > 0.8 * kHard);
      return p;
    };
    const Vector3d start = rng.integer(0, 2) == 0 ? Vector3d(0, 0, 1.5) : nearTrunk(1, 9);
    const Vector3d goal = rng.integer(0, 2) == 0 ? Vector3d(10, 0, 1.5) : nearTrunk(1, 9);
    if ((goal - start).norm() < 3.0) continue;
    GlobalPlannerConfig config;
    config.pushing = seed % 2 == 0 ? PushingForm::Qp : PushingForm::Socp;
    const Found found = findPushingPath(field, start, goal, 30, kHard, config);
    if (!found.found)
    {
      EXPECT_EQ(found.reason, "guide: no way around");  // a pocket between trunks
      ++pockets;
      continue;
    }
    ASSERT_GE(found.path.cols(), 30);
    EXPECT_LE((found.path.col(0) - start).norm(), 0.05);
    EXPECT_LE((found.path.rightCols(1) - goal).norm(), 0.05);
    EXPECT_EQ(found.retreat_m > 0.0, field.signedDistance(start) < kHard);
    EXPECT_EQ(found.approach_m > 0.0, field.signedDistance(goal) < kHard);
    EXPECT_LE(std::max(found.retreat_m, found.approach_m), 1.0);
    retreats += found.retreat_m > 0.0;
    approaches += found.approach_m > 0.0;
    // Between the legs hard clearance holds, on them nothing comes nearer than it was.
    const Eigen::VectorXd s = arcLength(found.path);
    for (Index k = 0; k + 1 < found.path.cols(); ++k)
    {
      const double least = clearanceOfEdge(field, found.path.col(k), found.path.col(k + 1));
      if (s[k] < found.retreat_m - 1e-6)
        EXPECT_GE(least, field.signedDistance(start) - 0.06);
      else if (s[k + 1] > s[s.size() - 1] - found.approach_m + 1e-6)
        EXPECT_GE(least, field.signedDistance(goal) - 0.06);
      else
        EXPECT_GE(least, kHard - 0.2);
    }
  }
  EXPECT_GT(retreats, 20);
  EXPECT_GT(approaches, 20);
  EXPECT_LT(pockets, 5);
}

TEST(PushingDirections, SaysWhyThereIsNoWay)
{
  const Eigen::AlignedBox3d bounds(Vector3d(-6, -6, 0), Vector3d(16, 6, 4));
  const AnalyticField deep({VerticalCylinder{{0, 0}, 2.0}, VerticalCylinder{{10, 0}, 0.3}}, bounds);
  const Vector3d inside(0, 0, 1.5), free(5, 0, 1.5), outside(40, 0, 1.5);
  const auto reason = [&](const AnalyticField& field, const Vector3d& a, const Vector3d& b)
  {
    const Found path = findPushingPath(field, a, b, 10, kHard, {});
    EXPECT_FALSE(path.found);
    return path.reason;
  };
  EXPECT_EQ(reason(deep, inside, free), "guide: start blocked");
  EXPECT_EQ(reason(deep, free, inside), "guide: goal blocked");
  EXPECT_EQ(reason(deep, free, outside), "guide: goal blocked");
  const AnalyticField wall(
      {test::Obstacle(Eigen::AlignedBox3d(Vector3d(7, -9, -9), Vector3d(8, 9, 9)))}, bounds);
  EXPECT_EQ(reason(wall, free, Vector3d(12, 0, 1.5)), "guide: no way around");
}

TEST(Retreat, FindsANearClearPlaceAndOnlyLeadsAway)
{
  int moved = 0, none = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const AnalyticField field = forest(rng, 25);
    const Vector3d place(rng.uniform(1.0, 9.0), rng.uniform(-4.0, 4.0), 1.5);
    const double clearance = rng.uniform(0.2, 0.8), reach = rng.uniform(0.3, 1.2);
    const auto found = findRetreat(field, place, clearance, reach);
    if (field.signedDistance(place) >= clearance)
    {
      ASSERT_TRUE(found);
      EXPECT_EQ(*found, place);
      continue;
    }
    // The nearest of the directions in the plane, by brute force; `sure` if a grid must see it,
    // too.
    double nearest = 1e9, sure = 1e9;
    for (int direction = 0; direction < 180; ++direction)
    {
      const Vector3d ray(std::cos(direction * M_PI / 90.0), std::sin(direction * M_PI / 90.0), 0.0);
      for (double d = 0.01; d <= 2.0; d += 0.01)
      {
        const double there = field.signedDistance(place + d * ray);
        if (there < field.signedDistance(place)) break;
        if (there >= clearance) nearest = std::min(nearest, d);
        if (there >= clearance + 0.2) sure = std::min(sure, d);
      }
    }
    none += !found;
    if (!found)
    {
      EXPECT_GT(sure, reach - 0.2);
      continue;
    }
    ++moved;
    EXPECT_GE(field.signedDistance(*found), clearance - 1e-9);
    EXPECT_LE((*found - place).norm(), std::min(reach + 0.1, nearest + 0.45));
    EXPECT_GE(clearanceOfEdge(field, place, *found), field.signedDistance(place) - 0.051);
  }
  EXPECT_GT(moved, 40);
  EXPECT_GT(none, 10);
  const AnalyticField empty({}, {Vector3d(0, 0, 0), Vector3d(1, 1, 1)});
  EXPECT_FALSE(findRetreat(empty, Vector3d(2, 0, 0), 0.5, 1.0));
}

HalfSpaces slab(const Vector3d& normal, double lower, double upper)
{
  HalfSpaces set;
  set.A.resize(2, 3);
  set.A << normal.transpose(), -normal.transpose();
  set.b = Eigen::Vector2d(upper, -lower);
  return set;
}

TEST(Recovery, PointsWithoutACommonPlaceGoToTheirOwnPolyhedraAndAreSmoothed)
{
  for (const PushingForm form : {PushingForm::Qp, PushingForm::Socp})
    for (std::uint64_t seed = 1; seed <= 100; ++seed)
    {
      SCOPED_TRACE(seed);
      Rng rng(seed);
      // Two slabs that do not meet, and a hand-over point that should be in both.
      const Vector3d normal = Vector3d(0.0, 1.0, rng.uniform(-0.3, 0.3)).normalized();
      const double gap = rng.uniform(0.05, 1.0), above = rng.uniform(0.0, 1.0);
      const HalfSpaces one = slab(normal, above, above + 1.0);
      const HalfSpaces two = slab(normal, above + 1.0 + gap, above + 3.0);
      PushingProgram program;
      program.form = form;
      program.margin = rng.integer(0, 1) * 0.3;
      program.points.resize(3, 15);
      program.sets.resize(15);
      for (Index k = 0; k < 15; ++k)
      {
        program.points.col(k) = Vector3d(0.2 * double(k), 0.0, 1.0);
        auto& sets = program.sets[std::size_t(k)];
        sets = {k <= 7 ? &one : &two};
        if (k == 7) sets.push_back(&two);
      }
      const PushingProgramSolution found = solvePushing(program);
      EXPECT_EQ(found.solve.termination, core::Termination::Infeasible);
      EXPECT_EQ(found.method, PushingMethod::ProjectedAndSmoothed);
      ASSERT_EQ(found.path.cols(), 15);
      for (Index k = 0; k < 15; ++k)
        EXPECT_LE(program.sets[std::size_t(k)].front()->violation(found.path.col(k)), 1e-6);
    }
}

TEST(Recovery, AnEmptyPolyhedronFreesItsPointsAndNoOthers)
{
  const HalfSpaces fine = slab(Vector3d::UnitY(), 1.0, 2.0);
  const HalfSpaces empty = slab(Vector3d::UnitY(), 1.0, 0.5);
  for (const PushingForm form : {PushingForm::Qp, PushingForm::Socp})
  {
    PushingProgram program;
    program.form = form;
    program.points = Matrix3Xd::Zero(3, 9);
    program.points.row(0).setLinSpaced(0.0, 2.0);
    for (Index k = 0; k < 9; ++k) program.sets.push_back({k == 4 ? &empty : &fine});
    const PushingProgramSolution found = solvePushing(program);
    EXPECT_EQ(found.solve.termination, core::Termination::Infeasible);
    EXPECT_NE(found.method, PushingMethod::Program);
    EXPECT_TRUE(found.path.allFinite());
    for (const Index k : {0, 1, 2, 3, 5, 6, 7, 8})
      EXPECT_LE(fine.violation(found.path.col(k)), 1e-6);
  }
}

TEST(Recovery, IsNotAskedWhenTheProgramIsFeasible)
{
  const HalfSpaces set = slab(Vector3d::UnitY(), 0.5, 2.0);
  for (const PushingForm form : {PushingForm::Qp, PushingForm::Socp})
  {
    PushingProgram program;
    program.form = form;
    program.points = Matrix3Xd::Zero(3, 9);
    program.points.row(0).setLinSpaced(0.0, 2.0);
    program.sets.assign(9, {&set});
    const PushingProgramSolution found = solvePushing(program);
    EXPECT_EQ(found.method, PushingMethod::Program);
    EXPECT_TRUE(found.solve.converged());
    for (Index k = 0; k < 9; ++k) EXPECT_LE(set.violation(found.path.col(k)), 1e-6);
  }
}

}  // namespace
}  // namespace slalom::global_planner
