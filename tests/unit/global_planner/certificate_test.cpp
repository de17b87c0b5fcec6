// SPDX-License-Identifier: BSD-3-Clause
// The certificate against dense sampling with exact distances to voxel cubes.
// SLALOM_FUZZ_CASES=100000 runs the long fuzz (default 5000 curves per treatment of unknown space).
#include "slalom/global_planner/Certificate.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <limits>

#include "AnalyticField.h"
#include "slalom/core/Rng.h"
#include "slalom/mapping/EdtSnapshot.h"

namespace slalom::global_planner
{
namespace
{
using core::Occupancy;
using core::Rng;
using core::UnknownAs;
using spline::UniformBSpline;
using Vec3 = Eigen::Vector3d;

constexpr UnknownAs kBoth[] = {UnknownAs::Free, UnknownAs::Occupied};
constexpr double kEnd = 1.1e-4;  // [m] a proof may end so far before the clearance does
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Voxels as the test knows them, and the field made of them.
struct World
{
  Vec3 origin;
  Eigen::Vector3i size;
  double resolution;
  std::vector<Occupancy> cells;
  std::shared_ptr<const mapping::EdtSnapshot> field;

  [[nodiscard]] Occupancy& at(int x, int y, int z)
  {
    return cells[static_cast<std::size_t>((z * size.y() + y) * size.x() + x)];
  }
  void freeze(double max_distance)
  {
    field = mapping::EdtSnapshot::fromOccupancy(origin, size, resolution, cells, max_distance);
  }
};

World randomWorld(Rng& rng)
{
  constexpr double kResolutions[] = {0.05, 0.1, 0.2, 0.4};
  World world;
  world.resolution = kResolutions[rng.integer(0, 3)];
  world.origin = rng.uniform3(-20.0, 20.0);
  world.size = Eigen::Vector3i(rng.integer(8, 30), rng.integer(8, 30), rng.integer(6, 16));
  world.cells.assign(static_cast<std::size_t>(world.size.prod()), Occupancy::Free);
  const auto paint = [&](Occupancy value, int boxes, int edge)
  {
    for (int i = 0; i < boxes; ++i)
    {
      Eigen::Vector3i low, high;
      for (int axis = 0; axis < 3; ++axis)
      {
        low[axis] = rng.integer(0, world.size[axis] - 1);
        high[axis] = std::min(world.size[axis] - 1, low[axis] + rng.integer(0, edge));
      }
      for (int z = low.z(); z <= high.z(); ++z)
        for (int y = low.y(); y <= high.y(); ++y)
          for (int x = low.x(); x <= high.x(); ++x) world.at(x, y, z) = value;
    }
  };
  paint(Occupancy::Unknown, rng.integer(0, 3), 6);
  paint(Occupancy::Occupied, rng.integer(0, 4), 4);
  const double speckle = rng.uniform() < 0.5 ? 0.0 : rng.uniform(0.0, 0.02);
  for (Occupancy& cell : world.cells)
    if (rng.uniform() < speckle)
      cell = rng.uniform() < 0.3 ? Occupancy::Unknown : Occupancy::Occupied;
  world.freeze(world.resolution * rng.uniform(3.0, 25.0));
  return world;
}

UniformBSpline randomCurve(Rng& rng, const World& world)
{
  const Eigen::AlignedBox3d box = world.field->bounds();
  const double step = world.resolution * rng.uniform(0.1, 3.0);
  Eigen::Matrix3Xd points(3, rng.integer(4, 12));
  Vec3 p, heading = rng.direction();
  for (int axis = 0; axis < 3; ++axis)
    p[axis] = box.min()[axis] + rng.uniform() * box.sizes()[axis];
  for (auto column : points.colwise())
  {
    column = p;
    heading = (heading + rng.normal3(0.4)).normalized();
    p += step * heading;
    // Most curves stay inside the window.
    if (!box.contains(p) && rng.uniform() < 0.9) heading = (box.center() - p).normalized();
  }
  return {points, rng.uniform(0.05, 0.5), rng.uniform(-10.0, 10.0)};
}

/// Exact distances to the obstacle cubes near a curve, by looking at all of them.
class ExactDistance
{
 public:
  ExactDistance(const World& world, UnknownAs unknown, Eigen::AlignedBox3d near, double reach)
      : bounds_(world.field->bounds()), closed_(unknown == UnknownAs::Occupied)
  {
    near = {near.min() - Vec3::Constant(reach), near.max() + Vec3::Constant(reach)};
    std::size_t i = 0;
    for (int z = 0; z < world.size.z(); ++z)
      for (int y = 0; y < world.size.y(); ++y)
        for (int x = 0; x < world.size.x(); ++x)
        {
          const Occupancy value = world.cells[i++];
          if (!(closed_ ? value != Occupancy::Free : value == Occupancy::Occupied)) continue;
          const Vec3 low = world.origin + world.resolution * Vec3(x, y, z);
          const Eigen::AlignedBox3d cube(low, low + Vec3::Constant(world.resolution));
          if (cube.intersects(near)) cubes_.push_back(cube);
        }
  }
  [[nodiscard]] double operator()(const Vec3& p) const
  {
    double nearest2 = kInfinity;
    for (const Eigen::AlignedBox3d& cube : cubes_)
      nearest2 = std::min(nearest2, cube.squaredExteriorDistance(p));
    const double nearest = std::sqrt(nearest2);
    if (!closed_) return nearest;
    const double face = std::min((p - bounds_.min()).minCoeff(), (bounds_.max() - p).minCoeff());
    return std::max(0.0, std::min(nearest, face));
  }

 private:
  Eigen::AlignedBox3d bounds_;
  bool closed_;
  std::vector<Eigen::AlignedBox3d> cubes_;
};

/// One question to a certificate and what dense sampling knows about it.
struct Case
{
  UniformBSpline curve;
  UnknownAs unknown;
  double clearance, from, to;
  ExactDistance exact;
  std::vector<double> times;      // dense, from `from` to `to`
  std::vector<double> distances;  // at these times; exact below 1.5 x clearance

  [[nodiscard]] double least(double until) const
  {
    double least = kInfinity;
    for (std::size_t i = 0; i < times.size() && times[i] <= until; ++i)
      least = std::min(least, distances[i]);
    return least;
  }
};

Case makeCase(Rng& rng, const World& world, const UniformBSpline& curve, UnknownAs unknown,
              bool all_cubes = false)
{
  const double clearance = world.resolution * rng.uniform(0.2, 5.0);
  Eigen::AlignedBox3d hull;
  for (const auto point : curve.controlPoints().colwise()) hull.extend(Vec3(point));
  Case c{curve,       unknown,
         clearance,   curve.start(),
         curve.end(), ExactDistance(world, unknown, hull, all_cubes ? 1e3 : 1.5 * clearance),
         {},          {}};
  if (rng.uniform() < 0.5)
  {
    c.from += rng.uniform() * curve.duration();
    c.to = rng.uniform(c.from, curve.end());
  }
  const int count = 2 + static_cast<int>(curve.length(c.from, c.to) / (0.02 * world.resolution));
  for (int i = 0; i < count; ++i)
  {
    c.times.push_back(c.from + (c.to - c.from) * i / (count - 1));
    c.distances.push_back(c.exact(curve.position(c.times.back())));
  }
  // Half of the questions are about what the curve just has or just lacks.
  const double least = c.least(c.to);
  if (rng.uniform() < 0.5 && least > 0.1 * world.resolution && least < 1.3 * clearance)
    c.clearance = least * rng.uniform(0.9, 1.1);
  return c;
}

/// What a fuzz saw. A case is clear if its densely sampled distance is enough.
struct Tally
{
  int cases = 0, clear = 0, accepted = 0, false_accepts = 0, false_refusals = 0, partial = 0;
  double deepest_accept = 0.0;     // [m] of the required clearance that an accepted stretch lacks
  double widest_refusal = 0.0;     // [m] distance beyond the required one of a refused clear case
  double latest_end = -kInfinity;  // [m] distance beyond the required one at a refusal's `until`

  void judge(const Case& c, const Certificate& proof)
  {
    constexpr double kRounding = 1e-9;
    const double least = c.least(c.to);
    ++cases;
    clear += least >= c.clearance;
    accepted += proof.holds(c.to);
    if (proof.margin_m >= 0.0)
    {
      const double lacks = c.clearance - c.least(proof.until);
      false_accepts += lacks > kRounding;
      deepest_accept = std::max(deepest_accept, lacks);
    }
    if (proof.holds(c.to)) return;
    partial += proof.until > c.from;
    latest_end = std::max(latest_end, c.exact(c.curve.position(proof.until)) - c.clearance);
    if (least < c.clearance) return;
    ++false_refusals;
    widest_refusal = std::max(widest_refusal, least - c.clearance);
  }
  [[nodiscard]] double refusedShare() const { return double(false_refusals) / std::max(1, clear); }
  void print(const char* name) const
  {
    std::printf(
        "[          ] %s: %d cases, %d clear, %d accepted, %d false accepts (lacking up to %.1e "
        "m), "
        "%d false refusals = %.3f %% of the clear (with up to %.1e m to spare), %d proved in part "
        "(ending at most %.1e m above the clearance)\n",
        name, cases, clear, accepted, false_accepts, deepest_accept, false_refusals,
        100.0 * refusedShare(), widest_refusal, partial, latest_end);
  }
};

int fuzzCases()
{
  const char* text = std::getenv("SLALOM_FUZZ_CASES");
  return text ? std::max(1, std::atoi(text)) : 5000;
}

/// Calls visit(case, world) for `count` random cases; a world serves ten curves.
template <class Visit>
void forCases(UnknownAs unknown, int count, bool all_cubes, const Visit& visit)
{
  constexpr int kCurves = 10;
  for (int done = 0; done < count; done += kCurves)
  {
    const auto seed = static_cast<std::uint64_t>(done);
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const World world = randomWorld(rng);
    for (int i = 0; i < kCurves && done + i < count; ++i)
      visit(makeCase(rng, world, randomCurve(rng, world), unknown, all_cubes), world);
  }
}

Certificate prove(const Case& c, const World& world)
{
  return certify(c.curve, c.from, c.to, *world.field, c.unknown, c.clearance);
}

TEST(Certificate, NeverAcceptsWhatDenseSamplingRejects)
{
  for (const UnknownAs unknown : kBoth)
  {
    Tally tally;
    forCases(unknown, fuzzCases(), false,
             [&](const Case& c, const World& world) { tally.judge(c, prove(c, world)); });
    tally.print(unknown == UnknownAs::Free ? "unknown is free" : "unknown is occupied");
    EXPECT_EQ(tally.false_accepts, 0);
    EXPECT_LT(tally.refusedShare(), 0.02);
    EXPECT_LT(tally.latest_end, kEnd);  // so `until` is not early
    // The cases are worth something: both answers, and stretches proved in part, are common.
    EXPECT_GT(tally.clear, tally.cases / 20);
    EXPECT_LT(tally.clear, tally.cases * 19 / 20);
    EXPECT_GT(tally.partial, tally.cases / 20);
  }
}

/// The voxels of a world with a lower bound that has no slack, and no better bound for hulls: every
/// error of the balls shows.
class WithoutSlack final : public core::DistanceField
{
 public:
  explicit WithoutSlack(const World& world) : voxels_(*world.field) {}
  Occupancy occupancy(const Vec3& p) const override { return voxels_.occupancy(p); }
  std::optional<core::DistanceSample> sample(const Vec3& p, UnknownAs unknown) const override
  {
    return voxels_.sample(p, unknown);
  }
  std::optional<double> lowerBound(const Vec3& p, UnknownAs unknown) const override
  {
    if (!bounds().contains(p)) return std::nullopt;
    return voxels_.hullBound(p.replicate<1, 4>(), unknown, 1e3);
  }
  void collectObstacles(const Eigen::AlignedBox3d& box, UnknownAs unknown,
                        std::vector<Vec3>& centres) const override
  {
    voxels_.collectObstacles(box, unknown, centres);
  }
  Eigen::AlignedBox3d bounds() const override { return voxels_.bounds(); }
  double resolution() const override { return voxels_.resolution(); }
  double maxDistance() const override { return voxels_.maxDistance(); }

 private:
  const mapping::EdtSnapshot& voxels_;
};

TEST(Certificate, NeverAcceptsTooMuchOnBallsAlone)
{
  for (const UnknownAs unknown : kBoth)
  {
    Tally tally;
    forCases(unknown, 2000, false,
             [&](const Case& c, const World& world)
             {
               const WithoutSlack field(world);
               tally.judge(c, certify(c.curve, c.from, c.to, field, unknown, c.clearance));
             });
    EXPECT_EQ(tally.false_accepts, 0);
    EXPECT_GT(tally.accepted, 200);
  }
}

// Certificates that must not pass the fuzz: it has to be able to fail.
TEST(Certificate, TheFuzzCatchesOptimisticProofs)
{
  Tally knots, lax, ignorant;
  forCases(UnknownAs::Occupied, 3000, false,
           [&](const Case& c, const World& world)
           {
             // The smooth distance at the knots only.
             bool clear = true;
             for (double t = c.from; clear && t <= c.to; t += c.curve.knotSpan())
               clear = world.field->distance(c.curve.position(t), c.unknown).value_or(0.0) >=
                       c.clearance;
             knots.judge(c, clear ? Certificate{c.to, 0.0} : Certificate{c.from, -1.0});
             // A right proof for one percent of a voxel less.
             lax.judge(c, certify(c.curve, c.from, c.to, *world.field, c.unknown,
                                  std::max(1e-6, c.clearance - 0.01 * world.resolution)));
             // A right proof that takes unknown space for free.
             ignorant.judge(
                 c, certify(c.curve, c.from, c.to, *world.field, UnknownAs::Free, c.clearance));
           });
  EXPECT_GT(knots.false_accepts, 30);
  EXPECT_GT(lax.false_accepts, 30);
  EXPECT_GT(ignorant.false_accepts, 30);
}

TEST(Certificate, ClaimsNoMoreMarginThanThereIs)
{
  int with_margin = 0;
  for (const UnknownAs unknown : kBoth)
    forCases(unknown, 300, true,
             [&](const Case& c, const World& world)
             {
               const Certificate proof = prove(c, world);
               EXPECT_LE(proof.margin_m, c.least(proof.until) - c.clearance + 1e-9);
               with_margin += proof.holds(c.to) && proof.margin_m > 0.1 * world.resolution;
             });
  EXPECT_GT(with_margin, 20);
}

TEST(Certificate, ProvesNoLessForASmallerClearance)
{
  int shorter = 0;
  for (const UnknownAs unknown : kBoth)
    forCases(unknown, 1000, false,
             [&](const Case& c, const World& world)
             {
               Case less = c;
               less.clearance *= 0.8;
               const Certificate proof = prove(c, world), easier = prove(less, world);
               EXPECT_GE(easier.until, proof.until);
               EXPECT_GE(easier.margin_m, -less.clearance);
               if (proof.holds(c.to))
               {
                 EXPECT_TRUE(easier.holds(c.to));
               }
               shorter += proof.until < easier.until;
             });
  EXPECT_GT(shorter, 50);
}

TEST(Certificate, OfOnePointIsItsDistance)
{
  int held = 0;
  for (const UnknownAs unknown : kBoth)
    forCases(unknown, 1000, true,
             [&](const Case& c, const World& world)
             {
               const double distance = c.exact(c.curve.position(c.from));
               for (const double to : {c.from, c.from - 1.0})
               {
                 const Certificate proof =
                     certify(c.curve, c.from, to, *world.field, c.unknown, c.clearance);
                 EXPECT_EQ(proof.until, c.from);
                 EXPECT_EQ(proof.holds(c.from), proof.margin_m >= 0.0);
                 EXPECT_LE(proof.margin_m, distance - c.clearance + 1e-12);
                 EXPECT_EQ(proof.holds(c.from), distance - c.clearance >= 2e-9);
                 held += proof.holds(c.from);
               }
             });
  EXPECT_GT(held, 100);
}

/// A free window of 10 m x 10 m x 4 m at 0.1 m with its centre at the origin; `obstacle` tells by
/// the centre what is in a voxel.
World room(const std::function<Occupancy(const Vec3&)>& content)
{
  World world{Vec3(-5, -5, -2), Eigen::Vector3i(100, 100, 40), 0.1, {}, nullptr};
  for (int z = 0; z < 40; ++z)
    for (int y = 0; y < 100; ++y)
      for (int x = 0; x < 100; ++x)
        world.cells.push_back(content(world.origin + 0.1 * Vec3(x + 0.5, y + 0.5, z + 0.5)));
  world.freeze(2.0);
  return world;
}

/// From (x0, y) to (x1, y) at constant speed in one second.
UniformBSpline straight(double x0, double x1, double y = 0.0)
{
  Eigen::Matrix3Xd points(3, 23);
  for (Eigen::Index i = 0; i < 23; ++i) points.col(i) << x0 + (x1 - x0) * double(i - 1) / 20, y, 0;
  return {points, 0.05};
}

TEST(Certificate, EndsWhereTheClearanceDoes)
{
  // A wall's face at x = 2: with 0.5 m to keep, the straight line is proved up to x = 1.5.
  const World world =
      room([](const Vec3& p) { return p.x() > 2.0 ? Occupancy::Occupied : Occupancy::Free; });
  const UniformBSpline curve = straight(-2.0, 2.5);
  for (const UnknownAs unknown : kBoth)
  {
    const Certificate proof = certify(curve, 0.0, 1.0, *world.field, unknown, 0.5);
    EXPECT_NEAR(curve.position(proof.until).x(), 1.5, kEnd);
    EXPECT_LE(curve.position(proof.until).x(), 1.5);
    EXPECT_GE(proof.margin_m, 0.0);
    EXPECT_TRUE(proof.holds(0.7));
    EXPECT_FALSE(proof.holds(1.0));
    // Right up to the clearance there is a proof, although lowerBound() is up to 0.12 m low there.
    EXPECT_TRUE(certify(straight(-2.0, 1.4998), 0.0, 1.0, *world.field, unknown, 0.5).holds(1.0));
  }
  // Along the wall over 8 m, 2 mm from too near.
  Eigen::Matrix3Xd along(3, 43);
  for (Eigen::Index i = 0; i < 43; ++i) along.col(i) << 1.498, -4.0 + 0.2 * double(i - 1), 0;
  const UniformBSpline parallel(along, 0.1);
  EXPECT_TRUE(
      certify(parallel, parallel.start(), parallel.end(), *world.field, UnknownAs::Free, 0.5)
          .holds(parallel.end()));
}

TEST(Certificate, ReadsUnknownSpaceAsTold)
{
  const World world =
      room([](const Vec3& p) { return p.x() > 2.0 ? Occupancy::Unknown : Occupancy::Free; });
  const UniformBSpline curve = straight(-2.0, 2.5);
  EXPECT_TRUE(certify(curve, 0, 1, *world.field, UnknownAs::Free, 0.5).holds(1.0));
  const Certificate proof = certify(curve, 0, 1, *world.field, UnknownAs::Occupied, 0.5);
  EXPECT_NEAR(curve.position(proof.until).x(), 1.5, kEnd);
}

TEST(Certificate, OutsideTheWindowAllIsUnknown)
{
  const World empty = room([](const Vec3&) { return Occupancy::Free; });
  const UniformBSpline leaving = straight(0.0, 20.0);
  EXPECT_TRUE(certify(leaving, 0, 1, *empty.field, UnknownAs::Free, 0.5).holds(1.0));
  const Certificate proof = certify(leaving, 0, 1, *empty.field, UnknownAs::Occupied, 0.5);
  EXPECT_NEAR(leaving.position(proof.until).x(), empty.field->bounds().max().x() - 0.5, kEnd);

  // From outside, obstacles inside still count, to the millimetre: a post whose voxels end at the
  // window's face, passed by beyond it.
  const World post = room(
      [](const Vec3& p)
      { return p.x() > 4.9 && std::abs(p.y()) < 0.1 ? Occupancy::Occupied : Occupancy::Free; });
  const auto passing = [&](double x)
  {
    Eigen::Matrix3Xd points(3, 23);
    for (Eigen::Index i = 0; i < 23; ++i) points.col(i) << x, -2.0 + 0.2 * double(i - 1), 0;
    return certify({points, 0.05}, 0, 1, *post.field, UnknownAs::Free, 0.5).holds(1.0);
  };
  EXPECT_TRUE(passing(5.502));
  EXPECT_FALSE(passing(5.498));
  const Certificate outside =
      certify(straight(6.0, 0.0), 0, 1, *empty.field, UnknownAs::Occupied, 0.5);
  EXPECT_EQ(outside.until, 0.0);
  EXPECT_LT(outside.margin_m, 0.0);
}

TEST(Certificate, ProvesNothingFromInsideAnObstacle)
{
  const World world =
      room([](const Vec3& p) { return p.norm() < 0.5 ? Occupancy::Occupied : Occupancy::Free; });
  for (const UnknownAs unknown : kBoth)
    for (const double clearance : {1e-6, 0.1, 1.0})
    {
      const Certificate proof =
          certify(straight(0.0, 3.0), 0.0, 1.0, *world.field, unknown, clearance);
      EXPECT_EQ(proof.until, 0.0);
      EXPECT_DOUBLE_EQ(proof.margin_m, -clearance);
      EXPECT_FALSE(proof.holds(0.0));
    }
}

TEST(Certificate, OfACurveThatRestsIsThatOfItsPoint)
{
  const World world =
      room([](const Vec3& p) { return p.x() > 2.0 ? Occupancy::Occupied : Occupancy::Free; });
  for (const double x : {0.0, 1.4, 1.4999, 1.5001, 2.5})
  {
    const UniformBSpline rest(Vec3(x, 0, 0).replicate(1, 7), 0.1, 3.0);
    const Certificate proof = certify(rest, 3.0, 3.4, *world.field, UnknownAs::Occupied, 0.5);
    EXPECT_EQ(proof.holds(3.4), x < 1.5) << x;
    EXPECT_EQ(proof.until, x < 1.5 ? 3.4 : 3.0) << x;
  }
}

TEST(Certificate, BeyondItsEndsTheCurveRestsThere)
{
  const World world =
      room([](const Vec3& p) { return p.x() > 2.0 ? Occupancy::Occupied : Occupancy::Free; });
  const UniformBSpline curve = straight(-2.0, 1.0);
  EXPECT_EQ(certify(curve, -5.0, 9.0, *world.field, UnknownAs::Free, 0.5).until, 9.0);
  EXPECT_TRUE(certify(curve, 4.0, 9.0, *world.field, UnknownAs::Free, 0.5).holds(9.0));
  EXPECT_TRUE(certify(curve, -4.0, -2.0, *world.field, UnknownAs::Free, 0.5).holds(-2.0));
  const Certificate blocked = certify(curve, 4.0, 9.0, *world.field, UnknownAs::Free, 1.5);
  EXPECT_EQ(blocked.until, 4.0);
  EXPECT_FALSE(blocked.holds(4.0));
  const Certificate late = certify(straight(1.0, 3.0), -5.0, 9.0, *world.field, UnknownAs::Free, 2);
  EXPECT_EQ(late.until, -5.0);
}

// A field without voxels has exact bounds of its own.
TEST(Certificate, HoldsForAnalyticObstacles)
{
  int held = 0, refused = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    std::vector<test::Obstacle> trees;
    for (int k = 0; k < 5; ++k)
      trees.push_back(
          test::VerticalCylinder{{rng.uniform(0, 6), rng.uniform(-2, 2)}, rng.uniform(0.02, 0.4)});
    const test::AnalyticField field(trees);
    Eigen::Matrix3Xd points(3, 20);
    Vec3 p(0, 0, 1);
    for (auto column : points.colwise())
      column = p += Vec3(rng.uniform(0, 0.5), rng.uniform(-0.3, 0.3), rng.uniform(-0.1, 0.1));
    const UniformBSpline curve(points, 0.2);
    const double clearance = rng.uniform(0.05, 0.4);
    const Certificate proof =
        certify(curve, curve.start(), curve.end(), field, UnknownAs::Occupied, clearance);
    double least = kInfinity;
    for (double t = curve.start(); t <= proof.until; t += 1e-3)
      least = std::min(least, field.signedDistance(curve.position(t)));
    if (proof.margin_m >= 0.0)
    {
      EXPECT_GE(least, clearance);
    }
    held += proof.holds(curve.end());
    if (proof.holds(curve.end())) continue;
    ++refused;
    EXPECT_LT(field.signedDistance(curve.position(proof.until)), clearance + kEnd);
  }
  EXPECT_GT(held, 30);
  EXPECT_GT(refused, 30);
}

TEST(Certificate, WorkIsBounded)
{
  // Twenty kilometres in spans of 4 m, back and forth inside a hollow ball whose wall is 0.1 mm
  // farther away than needed at the best of times: no span can be proved in few pieces.
  class Counting final : public test::AnalyticField
  {
   public:
    Counting() : AnalyticField({}) {}
    std::optional<double> lowerBound(const Vec3&, UnknownAs) const override
    {
      ++queries;
      return 0.5 + 1e-4;
    }
    mutable long queries = 0;
  } field;
  Eigen::Matrix3Xd points(3, 5003);
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) << (i % 4 < 2 ? -2.0 : 2.0), (i % 2 ? -2.0 : 2.0), 0;
  const UniformBSpline curve(points, 0.1);
  const Certificate proof = certify(curve, curve.start(), curve.end(), field, UnknownAs::Free, 0.5);
  EXPECT_GT(proof.until, curve.start());
  EXPECT_LT(proof.until, curve.end());
  EXPECT_LT(field.queries, 4 * (20000 + 64 * 5000));
}

TEST(Certificate, RefusesMeaninglessQuestions)
{
  const World world = room([](const Vec3&) { return Occupancy::Free; });
  const UniformBSpline curve = straight(0, 1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double clearance : {0.0, -0.5, nan, kInfinity})
    EXPECT_THROW((void)certify(curve, 0, 1, *world.field, UnknownAs::Free, clearance),
                 std::invalid_argument);
  EXPECT_THROW((void)certify(curve, nan, 1, *world.field, UnknownAs::Free, 0.5),
               std::invalid_argument);
  EXPECT_THROW((void)certify(curve, 0, kInfinity, *world.field, UnknownAs::Free, 0.5),
               std::invalid_argument);
}

}  // namespace
}  // namespace slalom::global_planner
