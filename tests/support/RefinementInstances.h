// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <fstream>
#include <vector>

namespace slalom::test
{
/// One instance of the evaluation data `problems/J_*_Nr40.txt`: Eq. (1) over 40 control points of
/// which the first and last three are fixed; its README has the weights and limits.
struct RefinementInstance
{
  struct Pull
  {
    Eigen::Index point = 0;
    Eigen::Vector3d base = Eigen::Vector3d::Zero(), direction = Eigen::Vector3d::Zero();
  };
  int id = 0;
  Eigen::Vector3d lower, upper;  ///< of every point
  Eigen::Matrix3Xd points;
  std::vector<Pull> pulls;
};

/// Empty if the file cannot be read to its end.
[[nodiscard]] inline std::vector<RefinementInstance> readRefinementInstances(
    const std::filesystem::path& file)
{
  std::ifstream in(file);
  const auto read = [&in](auto&& vector)
  {
    for (Eigen::Index i = 0; i < 3; ++i) in >> vector[i];
  };
  std::size_t count = 0;
  in >> count;
  std::vector<RefinementInstance> instances(in ? count : 0);
  for (RefinementInstance& instance : instances)
  {
    Eigen::Index points = 0;
    in >> instance.id >> points;
    read(instance.lower), read(instance.upper);
    instance.points.resize(3, points);
    for (Eigen::Index i = 0; i < points; ++i)
    {
      int pulls = 0;
      read(instance.points.col(i));
      in >> pulls;
      for (int k = 0; k < pulls && in; ++k)
      {
        RefinementInstance::Pull& pull = instance.pulls.emplace_back();
        pull.point = i;
        read(pull.base), read(pull.direction);
      }
    }
    if (!in) return {};
  }
  return instances;
}

}  // namespace slalom::test
