// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "Axes.h"
#include "Canvas.h"
#include "slalom/core/DistanceField.h"

namespace slalom::report::detail
{
inline constexpr Colour kOutsideColour{192, 192, 192};  ///< beyond the map window

/// What a horizontal cut of the field says of a cell.
enum class CellState : std::uint8_t
{
  Outside = 0,  ///< of the map window
  Unknown = 1,
  Free = 2,
  Occupied = 3
};

/// A horizontal cut of a distance field, one value per voxel column; row 0 is the lowest y.
struct FieldSlice
{
  Eigen::Vector2d origin_L = Eigen::Vector2d::Zero();  ///< corner of cell (0, 0) [m]
  double cell = 0.2;                                   ///< [m]
  cv::Mat distance;  ///< CV_32F [m], optimistic (unknown counts as free)
  cv::Mat state;     ///< CV_8U, CellState
};

/// The cut at altitude z over the box [lo, hi]. Cells coincide with voxels; where the box would
/// need more than 240 of them per side, several voxels share a cell.
[[nodiscard]] FieldSlice sliceField(const core::DistanceField& field, double z,
                                    const Eigen::Vector2d& lo, const Eigen::Vector2d& hi);

/// Paints the cut into the axes: colours for distance, hatch for unknown, black for occupied,
/// blank grey outside the window.
/// @param full_scale distance of the ramp's upper end [m]
/// @param contours distances whose lines are drawn [m]
void paintSlice(Canvas& canvas, const Axes& axes, const FieldSlice& slice, double full_scale,
                const std::vector<std::pair<double, Stroke>>& contours);

/// Maps a grid of cells onto the pixels of the axes; row 0 of `cells` is the lowest y.
[[nodiscard]] cv::Mat stretch(const cv::Mat& cells, const Eigen::Vector2d& origin, double cell,
                              const Axes& axes, int interpolation, double outside);

}  // namespace slalom::report::detail
