// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/math/TPoint3D.h>
#include <mrpt/topography/conversions.h>

#include "slalom/core/Rng.h"
#include "slalom/mrpt_io/Geodesy.h"

using slalom::core::Rng;
using slalom::mrpt_io::EnuFrame;

namespace
{
Eigen::Vector3d anywhere(Rng& rng)
{
  return {rng.uniform(-89.9, 89.9), rng.uniform(-180.0, 180.0), rng.uniform(-400.0, 9000.0)};
}

TEST(EnuFrame, ThereAndBackIsTheIdentity)
{
  for (std::uint64_t seed = 1; seed <= 500; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const EnuFrame frame(anywhere(rng));
    const Eigen::Vector3d p = rng.uniform3(-1e5, 1e5);
    EXPECT_LT((frame.toEnu(frame.toGeodetic(p)) - p).norm(), 1e-6);
  }
}

TEST(EnuFrame, TheDatumIsTheOriginAndAxesPointEastNorthUp)
{
  for (std::uint64_t seed = 1; seed <= 100; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    Eigen::Vector3d datum = anywhere(rng);
    datum.x() *= 0.9;
    const EnuFrame frame(datum);
    EXPECT_LT(frame.toEnu(datum).norm(), 1e-6);
    const double step = 1e-5;
    const Eigen::Vector3d east = frame.toEnu(datum + Eigen::Vector3d(0, step, 0));
    const Eigen::Vector3d north = frame.toEnu(datum + Eigen::Vector3d(step, 0, 0));
    EXPECT_GT(east.x() / east.norm(), 1.0 - 1e-9);
    EXPECT_GT(north.y() / north.norm(), 1.0 - 1e-9);
    EXPECT_LT((frame.toEnu(datum + Eigen::Vector3d(0, 0, 7)) - Eigen::Vector3d(0, 0, 7)).norm(),
              1e-6);
  }
}

TEST(EnuFrame, AgreesWithMrptForward)
{
  for (std::uint64_t seed = 1; seed <= 200; ++seed)
  {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const Eigen::Vector3d datum = anywhere(rng);
    const EnuFrame frame(datum);
    const Eigen::Vector3d p = frame.toGeodetic(rng.uniform3(-2e3, 2e3));
    mrpt::math::TPoint3D theirs;
    mrpt::topography::geodeticToENU_WGS84(
        mrpt::topography::TGeodeticCoords(p.x(), p.y(), p.z()), theirs,
        mrpt::topography::TGeodeticCoords(datum.x(), datum.y(), datum.z()));
    EXPECT_LT((frame.toEnu(p) - Eigen::Vector3d(theirs.x, theirs.y, theirs.z)).norm(), 1e-3);
  }
}
}  // namespace
