// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/core/DistanceField.h"

namespace slalom::core
{
std::optional<double> DistanceField::distance(const Eigen::Vector3d& p_L, UnknownAs unknown) const
{
  const std::optional<DistanceSample> here = sample(p_L, unknown);
  return here ? std::optional<double>(here->distance) : std::nullopt;
}

}  // namespace slalom::core
