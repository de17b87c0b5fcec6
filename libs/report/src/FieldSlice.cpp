// SPDX-License-Identifier: BSD-3-Clause
#include "FieldSlice.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "ColourRamp.h"

namespace slalom::report::detail
{
namespace
{
constexpr int kMaxCells = 240;

CellState stateAt(const core::DistanceField& field, const Eigen::AlignedBox3d& bounds,
                  const Eigen::Vector3d& p)
{
  if (!bounds.contains(p)) return CellState::Outside;
  switch (field.occupancy(p))
  {
    case core::Occupancy::Free:
      return CellState::Free;
    case core::Occupancy::Occupied:
      return CellState::Occupied;
    default:
      return CellState::Unknown;
  }
}

void drawContour(Canvas& canvas, const Axes& axes, const cv::Mat& distance, const cv::Mat& state,
                 double level, const Stroke& stroke)
{
  cv::Mat near(state.size(), CV_8U);
  for (int y = 0; y < near.rows; ++y)
  {
    const float* d = distance.ptr<float>(y);
    const std::uint8_t* s = state.ptr<std::uint8_t>(y);
    std::uint8_t* out = near.ptr<std::uint8_t>(y);
    for (int x = 0; x < near.cols; ++x)
      out[x] = d[x] < static_cast<float>(level) && s[x] != static_cast<int>(CellState::Outside);
  }
  std::vector<std::vector<cv::Point>> lines;
  cv::findContours(near, lines, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
  Canvas inside = canvas.clipped(axes.area);
  for (const auto& line : lines)
  {
    PixelPath path;
    // Every third pixel: the eye wants a curve, not the staircase of the mask.
    for (std::size_t i = 0; i < line.size(); i += 3)
      path.emplace_back(axes.area.x + line[i].x, axes.area.y + line[i].y);
    if (!path.empty()) inside.outline(path, stroke);
  }
}
/// One pass over the pixels: with masks and colour maps, touching fresh memory took most of the
/// time.
void paintCells(cv::Mat& image, cv::Point origin, const cv::Mat& distance, const cv::Mat& state,
                double full_scale)
{
  const cv::Mat ramp = ColourRamp::distance().lookupTable();
  const cv::Vec3b outside = kOutsideColour.bgrBytes(), occupied = kBlack.bgrBytes();
  const float to_index = static_cast<float>(255.0 / full_scale);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
    {
      cv::Vec3b& pixel = image.at<cv::Vec3b>(y, x);
      switch (static_cast<CellState>(state.at<std::uint8_t>(y, x)))
      {
        case CellState::Outside:
          pixel = outside;
          break;
        case CellState::Occupied:
          pixel = occupied;
          break;
        case CellState::Unknown:
          pixel = hatchAt(origin.x + x, origin.y + y).bgrBytes();
          break;
        case CellState::Free:
          // 64 steps: the eye sees no fewer, the PNG is a fifth smaller and faster.
          pixel = ramp.at<cv::Vec3b>(
              static_cast<int>(std::clamp(to_index * distance.at<float>(y, x), 0.0f, 255.0f)) & ~3);
          break;
      }
    }
}
}  // namespace

FieldSlice sliceField(const core::DistanceField& field, double z, const Eigen::Vector2d& lo,
                      const Eigen::Vector2d& hi)
{
  const double voxel = field.resolution();
  const double voxels = (hi - lo).maxCoeff() / voxel;
  FieldSlice slice;
  slice.cell = voxel * std::max(1.0, std::ceil(voxels / kMaxCells));
  const Eigen::AlignedBox3d bounds = field.bounds();
  const Eigen::Vector2d grid = bounds.min().head<2>();
  slice.origin_L = grid + ((lo - grid) / slice.cell).array().floor().matrix() * slice.cell;
  const int columns = static_cast<int>(std::ceil((hi.x() - slice.origin_L.x()) / slice.cell));
  const int rows = static_cast<int>(std::ceil((hi.y() - slice.origin_L.y()) / slice.cell));
  slice.distance = cv::Mat(rows, columns, CV_32F, cv::Scalar(field.maxDistance()));
  slice.state = cv::Mat(rows, columns, CV_8U, cv::Scalar(0));
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
    {
      const Eigen::Vector2d p =
          slice.origin_L + slice.cell * Eigen::Vector2d(column + 0.5, row + 0.5);
      const Eigen::Vector3d p_L(p.x(), p.y(), z);
      slice.state.at<std::uint8_t>(row, column) =
          static_cast<std::uint8_t>(stateAt(field, bounds, p_L));
      if (const auto distance = field.distance(p_L, core::UnknownAs::Free))
        slice.distance.at<float>(row, column) = static_cast<float>(*distance);
    }
  return slice;
}

cv::Mat stretch(const cv::Mat& cells, const Eigen::Vector2d& origin, double cell, const Axes& axes,
                int interpolation, double outside)
{
  // Inverse map: pixel (u, v) -> cell. The centre of cell (0, 0) has coordinates (0, 0) for OpenCV.
  const double scale = 1.0 / (axes.pixelsPerUnit() * cell);
  const double x0 = (axes.x0 - origin.x()) / cell + 0.5 * scale - 0.5;
  const double y0 = (axes.y1 - origin.y()) / cell - 0.5 * scale - 0.5;
  const cv::Matx23d to_cell(scale, 0.0, x0, 0.0, -scale, y0);
  cv::Mat pixels;
  cv::warpAffine(cells, pixels, to_cell, axes.area.size(), interpolation | cv::WARP_INVERSE_MAP,
                 cv::BORDER_CONSTANT, cv::Scalar::all(outside));
  return pixels;
}

void paintSlice(Canvas& canvas, const Axes& axes, const FieldSlice& slice, double full_scale,
                const std::vector<std::pair<double, Stroke>>& contours)
{
  const cv::Mat distance =
      stretch(slice.distance, slice.origin_L, slice.cell, axes, cv::INTER_LINEAR, full_scale);
  const cv::Mat state =
      stretch(slice.state, slice.origin_L, slice.cell, axes, cv::INTER_NEAREST, 0.0);
  Canvas inside = canvas.clipped(axes.area);
  paintCells(inside.pixels(), axes.area.tl(), distance, state, full_scale);
  for (const auto& [level, stroke] : contours)
    drawContour(canvas, axes, distance, state, level, stroke);
}

}  // namespace slalom::report::detail
