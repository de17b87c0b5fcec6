// SPDX-License-Identifier: BSD-3-Clause
#include "RangeDecoder.h"

#include <mrpt/maps/CPointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "MrptConvert.h"
#include "MrptError.h"
#include "slalom/mrpt_io/Velodyne.h"

namespace slalom::mrpt_io::detail
{
namespace
{
using namespace mrpt::obs;

/// A recording may name files; only those inside its own folder are opened.
bool staysInside(const std::string& name)
{
  const std::filesystem::path path(name);
  if (path.is_absolute()) return false;
  return std::none_of(path.begin(), path.end(), [](const auto& part) { return part == ".."; });
}

bool loadExternal(const CObservation& observation, const std::vector<std::string>& names,
                  Dropped& dropped)
{
  if (!std::all_of(names.begin(), names.end(), staysInside))
  {
    ++dropped["external file outside the recording's folder"];
    return false;
  }
  try
  {
    observation.load();
    return true;
  }
  catch (const std::exception&)
  {
    ++dropped["external file cannot be read"];
    return false;
  }
}

void decodePointCloud(const CObservationPointCloud& o, core::RangeScan& out, Dropped& dropped)
{
  if (o.isExternallyStored() && !loadExternal(o, {o.getExternalStorageFile()}, dropped)) return;
  if (!o.pointcloud) return;
  const auto& xs = o.pointcloud->getPointsBufferRef_x();
  const auto& ys = o.pointcloud->getPointsBufferRef_y();
  const auto& zs = o.pointcloud->getPointsBufferRef_z();
  out.points.reserve(xs.size());
  for (std::size_t i = 0; i < xs.size(); ++i)
    out.points.push_back({Eigen::Vector3f(xs[i], ys[i], zs[i]), 0.0f});
}

/// Pixels of a depth camera; MRPT's sensor axes are x forward, y left, z up.
void decodeDepthImage(const CObservation3DRangeScan& o, core::RangeScan& out, Dropped& dropped)
{
  const double fx = o.cameraParams.fx(), fy = o.cameraParams.fy();
  if (!(fx > 0.0 && fy > 0.0))
  {
    ++dropped["depth image without camera parameters"];
    return;
  }
  const auto rows = o.rangeImage.rows(), columns = o.rangeImage.cols();
  out.points.reserve(static_cast<std::size_t>(rows * columns));
  std::uint64_t zero = 0;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
    {
      const double range = o.rangeImage(row, column) * static_cast<double>(o.rangeUnits);
      if (range <= 0.0)
      {
        ++zero;
        continue;
      }
      Eigen::Vector3d ray(1.0, (o.cameraParams.cx() - column) / fx,
                          (o.cameraParams.cy() - row) / fy);
      if (!o.range_is_depth) ray.normalize();
      out.points.push_back({(range * ray).cast<float>(), 0.0f});
    }
  if (zero > 0) dropped["zero range"] += zero;
}

void decode3D(const CObservation3DRangeScan& o, core::RangeScan& out, Dropped& dropped)
{
  std::vector<std::string> files;
  if (o.points3D_isExternallyStored()) files.push_back(o.points3D_getExternalStorageFile());
  if (o.rangeImage_isExternallyStored()) files.push_back(o.rangeImage_getExternalStorageFile(""));
  if (!files.empty() && !loadExternal(o, files, dropped)) return;
  if (o.hasRangeImage && o.rangeImage.size() > 0)
    decodeDepthImage(o, out, dropped);
  else if (o.hasPoints3D && o.points3D_x.size() == o.points3D_y.size() &&
           o.points3D_x.size() == o.points3D_z.size())
    for (std::size_t i = 0; i < o.points3D_x.size(); ++i)
      out.points.push_back(
          {Eigen::Vector3f(o.points3D_x[i], o.points3D_y[i], o.points3D_z[i]), 0.0f});
  else
    ++dropped["3-D range scan without range image or points"];
}

void decode2D(const CObservation2DRangeScan& o, core::RangeScan& out, Dropped& dropped)
{
  std::uint64_t invalid = 0;
  for (std::size_t i = 0; i < o.getScanSize(); ++i)
  {
    const float range = o.getScanRange(i), angle = o.getScanAngle(i);
    if (!o.getScanRangeValidity(i) || range >= o.maxRange)
      ++invalid;
    else
      out.points.push_back(
          {Eigen::Vector3f(range * std::cos(angle), range * std::sin(angle), 0.0f), 0.0f});
  }
  if (invalid > 0) dropped["invalid 2-D range"] += invalid;
}

/// Elevation of each row [rad]; the class does not store it. MRPT fills rows in firing order.
std::vector<double> rowElevations(const CObservationRotatingScan& o)
{
  std::vector<double> elevations;
  if (o.rowCount == 1)
    elevations.push_back(0.0);
  else if (o.rowCount == 16 && o.lidarModel.starts_with("VLP"))
    for (const int degrees : kVlp16Elevation)
      elevations.push_back(degrees * std::numbers::pi / 180.0);
  else if (o.rowCount == 32 && o.lidarModel.starts_with("HDL"))
    for (const auto& laser : VelodyneCalibration::LoadDefaultCalibration("HDL32").laser_corrections)
      elevations.push_back(std::atan2(laser.sinVertCorrection, laser.cosVertCorrection));
  return elevations;
}

/** Columns that azimuthSpan covers. MRPT 2.5.8 converts Velodyne packets into an image that is as
 * many times too wide as it has rows, and leaves the rest empty. */
int usedColumns(const CObservationRotatingScan& o)
{
  const int narrow = o.columnCount / o.rowCount;
  if (o.rowCount == 1 || narrow < 2) return o.columnCount;
  for (int row = 0; row < o.rowCount; ++row)
    for (int column = narrow; column < o.columnCount; ++column)
      if (o.rangeImage(row, column) != 0) return o.columnCount;
  return narrow;
}

void decodeRotating(const CObservationRotatingScan& o, core::RangeScan& out, Dropped& dropped)
{
  const std::vector<double> elevations = rowElevations(o);
  if (elevations.empty() || elevations.size() != o.rowCount || o.columnCount == 0 ||
      o.rangeImage.rows() != o.rowCount || o.rangeImage.cols() != o.columnCount)
  {
    ++dropped["rotating scan of an unknown sensor"];
    return;
  }
  // Velodyne azimuths grow clockwise; MRPT stores them with a positive span all the same.
  const double sign = o.rowCount > 1 ? -1.0 : 1.0;
  const int columns = usedColumns(o);
  out.duration = std::isfinite(o.sweepDuration) ? std::max(0.0, o.sweepDuration) : 0.0;
  std::uint64_t zero = 0;
  for (int column = 0; column < columns; ++column)
  {
    const double share = static_cast<double>(column) / std::max(1, columns - 1);
    const double azimuth = sign * (o.startAzimuth + share * o.azimuthSpan);
    for (int row = 0; row < o.rowCount; ++row)
    {
      const double range = o.rangeImage(row, column) * o.rangeResolution;
      if (!(range > 0.0))
      {
        ++zero;
        continue;
      }
      const double elevation = elevations[static_cast<std::size_t>(row)];
      const double flat = range * std::cos(elevation);
      out.points.push_back({Eigen::Vector3d(flat * std::cos(azimuth), flat * std::sin(azimuth),
                                            range * std::sin(elevation))
                                .cast<float>(),
                            static_cast<float>(share * out.duration)});
    }
  }
  if (zero > 0) dropped["zero range"] += zero;
}
}  // namespace

bool isRangeObservation(const CObservation& o)
{
  return dynamic_cast<const CObservationVelodyneScan*>(&o) ||
         dynamic_cast<const CObservationPointCloud*>(&o) ||
         dynamic_cast<const CObservation3DRangeScan*>(&o) ||
         dynamic_cast<const CObservation2DRangeScan*>(&o) ||
         dynamic_cast<const CObservationRotatingScan*>(&o);
}

void decodeRange(const CObservation& observation, core::RangeScan& out, Dropped& dropped)
{
  mrpt::poses::CPose3D mount;
  observation.getSensorPose(mount);
  out.T_BS = toEigen(mount);
  out.points.clear();
  if (const auto* velodyne = dynamic_cast<const CObservationVelodyneScan*>(&observation))
    decodeVelodyne(*velodyne, out, dropped);
  else if (const auto* cloud = dynamic_cast<const CObservationPointCloud*>(&observation))
    decodePointCloud(*cloud, out, dropped);
  else if (const auto* depth = dynamic_cast<const CObservation3DRangeScan*>(&observation))
    decode3D(*depth, out, dropped);
  else if (const auto* planar = dynamic_cast<const CObservation2DRangeScan*>(&observation))
    decode2D(*planar, out, dropped);
  else if (const auto* rotating = dynamic_cast<const CObservationRotatingScan*>(&observation))
    decodeRotating(*rotating, out, dropped);
}

void filterRange(core::RangeScan& scan, double min, double max, Dropped& dropped)
{
  const auto lo = static_cast<float>(min * min), hi = static_cast<float>(max * max);
  std::uint64_t bad = 0, zero = 0, outside = 0;
  const auto refuse = [&](const core::ScanPoint& p)
  {
    const float squared = p.p_S.squaredNorm();
    if (!std::isfinite(squared)) return ++bad, true;
    if (squared < 1e-12f) return ++zero, true;
    if (squared < lo || squared > hi) return ++outside, true;
    return false;
  };
  std::erase_if(scan.points, refuse);
  const std::pair<const char*, std::uint64_t> reasons[] = {
      {"not finite", bad}, {"zero range", zero}, {"out of range", outside}};
  for (const auto& [reason, count] : reasons)
    if (count > 0) dropped[reason] += count;
}

}  // namespace slalom::mrpt_io::detail
