// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "AnalyticField.h"
#include "Axes.h"
#include "Canvas.h"
#include "ColourRamp.h"
#include "FieldSlice.h"
#include "Geometry2d.h"
#include "MapAccumulator.h"
#include "Text.h"
#include "slalom/core/Rng.h"

namespace slalom::report::detail
{
namespace
{
TEST(NiceTicks, RoundInsideAndNotTooMany)
{
  for (std::uint64_t seed = 0; seed < 300; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    const double lo = rng.uniform(-1.0, 1.0) * std::pow(10.0, rng.integer(-3, 4));
    const double hi = lo + rng.uniform(0.1, 1.0) * std::pow(10.0, rng.integer(-3, 4));
    const int most = rng.integer(2, 12);
    const Ticks ticks = niceTicks(lo, hi, most);
    ASSERT_LE(ticks.values.size(), static_cast<std::size_t>(most) + 1);
    const double mantissa = ticks.step / std::pow(10.0, std::floor(std::log10(ticks.step) + 1e-9));
    EXPECT_TRUE(std::abs(mantissa - 1) < 1e-6 || std::abs(mantissa - 2) < 1e-6 ||
                std::abs(mantissa - 5) < 1e-6)
        << mantissa;
    for (const double value : ticks.values)
    {
      EXPECT_GE(value, lo - 1e-6 * (hi - lo));
      EXPECT_LE(value, hi + 1e-6 * (hi - lo));
      // What is printed is the value: a label must not round two ticks onto each other.
      EXPECT_NEAR(std::stod(ticks.label(value)), value, 1e-6 * ticks.step);
    }
  }
  EXPECT_TRUE(niceTicks(1.0, 1.0, 5).values.empty());
  EXPECT_TRUE(niceTicks(0.0, std::nan(""), 5).values.empty());
}

TEST(Axes, EqualScaleShowsTheWholeBoxUndistorted)
{
  for (std::uint64_t seed = 0; seed < 50; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    const Eigen::Vector2d lo = rng.uniform3(-50, 50).head<2>();
    const Eigen::Vector2d hi = lo + rng.uniform3(0.5, 80).head<2>();
    const Axes axes =
        Axes::equalScale({10, 20, rng.integer(50, 900), rng.integer(50, 900)}, lo, hi);
    const Pixel a = axes.toPixel(lo), b = axes.toPixel(hi);
    EXPECT_NEAR((b.x() - a.x()) / (hi.x() - lo.x()), (a.y() - b.y()) / (hi.y() - lo.y()), 1e-6);
    EXPECT_GE(a.x(), 10 - 0.5001);
    EXPECT_LE(b.x(), 10 + axes.area.width - 0.4999);
    EXPECT_GE(b.y(), 20 - 0.5001);
    EXPECT_LE(a.y(), 20 + axes.area.height - 0.4999);
  }
}

TEST(HorizontalSlice, HoldsExactlyThePointsOfTheBody)
{
  for (std::uint64_t seed = 0; seed < 60; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    core::HalfSpaces body;
    const int rows = rng.integer(4, 12);
    body.A.resize(rows, 3);
    body.b.resize(rows);
    for (int i = 0; i < rows; ++i)
    {
      body.A.row(i) = rng.direction().transpose();
      body.b[i] = rng.uniform(-0.3, 1.5);
    }
    const double z = rng.uniform(-1.0, 1.0);
    const Eigen::Vector2d box(2.0, 2.0);
    const Polygon slice = horizontalSlice(body, z, -box, box);
    for (int i = 0; i < 200; ++i)
    {
      const Eigen::Vector3d p(rng.uniform(-1.99, 1.99), rng.uniform(-1.99, 1.99), z);
      const double violation = body.violation(p);
      if (std::abs(violation) < 1e-9) continue;
      // Inside a convex counter-clockwise polygon: left of every edge.
      bool inside = slice.size() >= 3;
      for (std::size_t k = 0; k < slice.size(); ++k)
      {
        const Eigen::Vector2d edge = slice[(k + 1) % slice.size()] - slice[k];
        const Eigen::Vector2d to_p = p.head<2>() - slice[k];
        inside = inside && edge.x() * to_p.y() - edge.y() * to_p.x() >= -1e-12;
      }
      EXPECT_EQ(inside, violation < 0.0) << p.transpose();
    }
  }
}

TEST(HeadingAt, FollowsTheNearestPiece)
{
  core::Polyline line(3, 4);
  line << 0, 1, 1, 1, 0, 0, 0, 2, 0, 0, 0, 0;  // east, a repeated point, north
  EXPECT_NEAR(headingAt(line, {0.4, 0.1, 0.0}), 0.0, 1e-12);
  EXPECT_NEAR(headingAt(line, {1.1, 1.5, 0.0}), M_PI / 2, 1e-12);
  EXPECT_EQ(headingAt(core::Polyline(3, 1), {0, 0, 0}), 0.0);
}

TEST(ClampToBox, StaysOnTheSegmentAndInTheBox)
{
  for (std::uint64_t seed = 0; seed < 100; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    const Eigen::Vector2d lo(-1, -2), hi(3, 1), inside(rng.uniform(-1, 3), rng.uniform(-2, 1));
    const Eigen::Vector2d target = rng.uniform3(-9, 9).head<2>();
    const Eigen::Vector2d p = clampToBox(inside, target, lo, hi);
    EXPECT_TRUE((p.array() >= lo.array() - 1e-9).all() && (p.array() <= hi.array() + 1e-9).all());
    const Eigen::Vector2d whole = target - inside, part = p - inside;
    EXPECT_NEAR(whole.x() * part.y() - whole.y() * part.x(), 0.0, 1e-9);
    EXPECT_GE(whole.dot(part), -1e-12);
  }
}

TEST(ColourRamp, GetsLighterAllTheWay)
{
  for (const ColourRamp* ramp : {&ColourRamp::distance(), &ColourRamp::speed()})
  {
    double last = -1.0;
    for (int i = 0; i <= 16; ++i)
    {
      const Colour c = ramp->at(i / 16.0);
      const double lightness = 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
      EXPECT_GT(lightness, last) << i;
      last = lightness;
    }
    EXPECT_EQ(ramp->at(-1.0).g, ramp->at(0.0).g);
    EXPECT_EQ(ramp->at(7.0).g, ramp->at(1.0).g);
  }
}

TEST(Dashes, CoverTheirShareOfThePath)
{
  PixelPath path;
  for (int i = 0; i <= 100; ++i) path.emplace_back(3.0 * i, 0.0);  // vertices do not match dashes
  double drawn = 0.0;
  for (const PixelPath& piece : dashes(path, 7.0, 4.0))
  {
    EXPECT_LE((piece.back() - piece.front()).norm(), 7.0 + 1e-9);
    drawn += (piece.back() - piece.front()).norm();
  }
  EXPECT_NEAR(drawn, 300.0 * 7.0 / 11.0, 7.0);
  EXPECT_NO_FATAL_FAILURE(dashes({{0, 0}, {std::nan(""), 1}, {2, 2}}, 3.0, 3.0));
}

TEST(WrapText, LosesNoWordAndKeepsTheWidth)
{
  for (std::uint64_t seed = 0; seed < 40; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    std::string text;
    for (int n = rng.integer(1, 30); n > 0; --n)
      text += (text.empty() ? "" : " ") + std::string(static_cast<std::size_t>(rng.integer(1, 9)),
                                                      static_cast<char>(rng.integer('a', 'z')));
    const Font font{double(rng.integer(10, 20))};
    const double width = rng.uniform(160.0, 400.0);
    std::string joined;
    for (const std::string& line : wrapText(text, font, width, 1000))
    {
      EXPECT_LE(textWidth(line, font), width);
      joined += (joined.empty() ? "" : " ") + line;
    }
    EXPECT_EQ(joined, text);
    const auto two = wrapText(text, font, width, 2);
    ASSERT_LE(two.size(), 2u);
    for (const std::string& line : two) EXPECT_LE(textWidth(line, font), width);
    EXPECT_EQ(two.back().ends_with("..."), wrapText(text, font, width, 1000).size() > 2);
  }
  EXPECT_EQ(wrapText("", {}, 100.0, 3).size(), 0u);
  EXPECT_FALSE(wrapText(std::string(500, 'w'), {}, 100.0, 3).empty());
}

TEST(Canvas, SurvivesWhatIsNotFinite)
{
  Canvas canvas(60, 40, kWhite);
  const double nan = std::nan("");
  canvas.path({{nan, 3}, {1e300, 5}, {-1e300, 7}, {3, 3}}, {kBlack, 2, kWhite, 3.0, 2.0});
  canvas.arrow({nan, 1}, {3, 3}, {kBlack, 1}, 5.0);
  canvas.disc({nan, 1}, 3.0, kBlack, 0.5);
  canvas.fill({{-1e9, -1e9}, {1e9, -1e9}, {0.0, 1e9}}, kBlack, 0.5);
  canvas.text({1e4, 1e4}, "out \xc3\xa4", {}, kBlack);
  canvas.rectangle({-100, -100, 20, 20}, kBlack);
  EXPECT_EQ(canvas.width(), 60);
}

/// Round trip: the pixel of a place shows the cell of that place.
TEST(Stretch, PutsEveryCellWhereTheAxesSay)
{
  for (std::uint64_t seed = 0; seed < 20; ++seed)
  {
    SCOPED_TRACE(seed);
    core::Rng rng(seed);
    const double cell = rng.uniform(0.1, 0.5);
    const Eigen::Vector2d origin = rng.uniform3(-5, 5).head<2>();
    cv::Mat cells(30, 40, CV_8U);
    for (int i = 0; i < 30 * 40; ++i)
      cells.data[i] = static_cast<std::uint8_t>(rng.integer(1, 255));
    const Eigen::Vector2d far = origin + cell * Eigen::Vector2d(40, 30);
    const Axes axes = Axes::equalScale({7, 9, 500, 400}, origin, far);
    const cv::Mat pixels = stretch(cells, origin, cell, axes, cv::INTER_NEAREST, 0.0);
    for (int i = 0; i < 300; ++i)
    {
      const int column = rng.integer(0, 39), row = rng.integer(0, 29);
      const Eigen::Vector2d inside(rng.uniform(0.2, 0.8), rng.uniform(0.2, 0.8));
      const Pixel p =
          axes.toPixel(Eigen::Vector2d(origin + cell * (Eigen::Vector2d(column, row) + inside)));
      const int x = static_cast<int>(std::lround(p.x())) - 7;
      const int y = static_cast<int>(std::lround(p.y())) - 9;
      EXPECT_EQ(pixels.at<std::uint8_t>(y, x), cells.at<std::uint8_t>(row, column));
    }
  }
}

TEST(SliceField, AgreesWithTheField)
{
  const test::AnalyticField field(
      {test::VerticalCylinder{{1.0, 2.0}, 0.6}, test::Sphere{{-2.0, 0.5, 1.0}, 0.9}},
      {Eigen::Vector3d(-4, -4, 0), Eigen::Vector3d(4, 4, 3)});
  const FieldSlice slice = sliceField(field, 1.2, {-6, -6}, {6, 6});
  ASSERT_EQ(slice.state.size(), slice.distance.size());
  for (int row = 0; row < slice.state.rows; ++row)
    for (int column = 0; column < slice.state.cols; ++column)
    {
      const Eigen::Vector2d p =
          slice.origin_L + slice.cell * Eigen::Vector2d(column + 0.5, row + 0.5);
      const Eigen::Vector3d p_L(p.x(), p.y(), 1.2);
      const auto state = static_cast<CellState>(slice.state.at<std::uint8_t>(row, column));
      if (!field.bounds().contains(p_L))
      {
        EXPECT_EQ(state, CellState::Outside);
        continue;
      }
      const double distance = *field.distance(p_L, core::UnknownAs::Free);
      EXPECT_NEAR(slice.distance.at<float>(row, column), distance, 1e-5);
      EXPECT_EQ(state, distance <= 0.0 ? CellState::Occupied : CellState::Free);
    }
}

TEST(MapAccumulator, RemembersWhatEarlierWindowsSaw)
{
  const std::vector<test::Obstacle> pillars = {test::VerticalCylinder{{0.0, 1.0}, 0.5},
                                               test::VerticalCylinder{{-20.3, -1.0}, 0.5}};
  MapAccumulator map;
  EXPECT_TRUE(map.empty());
  for (double x = -22.0; x <= 2.0; x += 0.25)
  {
    const Eigen::Vector3d here(x, 0.0, 1.0), reach(4.0, 4.0, 2.0);
    map.add(std::make_shared<test::AnalyticField>(pillars,
                                                  Eigen::AlignedBox3d(here - reach, here + reach)),
            0.1 * x, here);
  }
  map.finish();
  const FieldSlice cells = map.cells({-30, -10}, {10, 10});
  const auto at = [&](double x, double y)
  {
    const Eigen::Vector2d k = (Eigen::Vector2d(x, y) - cells.origin_L) / cells.cell;
    return static_cast<CellState>(
        cells.state.at<std::uint8_t>(static_cast<int>(k.y()), static_cast<int>(k.x())));
  };
  EXPECT_EQ(at(0.0, 1.0), CellState::Occupied);
  EXPECT_EQ(at(-20.3, -1.0), CellState::Occupied);
  EXPECT_EQ(at(-10.0, 0.0), CellState::Free);
  EXPECT_EQ(at(-10.0, 7.0), CellState::Outside);
  EXPECT_EQ(at(8.0, 0.0), CellState::Outside);
}

TEST(MapAccumulator, StaysBounded)
{
  MapAccumulator map;
  const Eigen::Vector3d reach(1.0, 1.0, 1.0);
  for (int k = 0; k < 6000; ++k)
  {
    const Eigen::Vector3d here(25.0 * k, 0.0, 1.0);
    map.add(std::make_shared<test::AnalyticField>(std::vector<test::Obstacle>{},
                                                  Eigen::AlignedBox3d(here - reach, here + reach)),
            k, here);
  }
  EXPECT_LE(map.memoryBytes(),
            MapAccumulator::kMaxTiles * MapAccumulator::kTile * MapAccumulator::kTile);
}
}  // namespace
}  // namespace slalom::report::detail
