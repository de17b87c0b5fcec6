// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <deque>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "slalom/core/HalfSpaces.h"
#include "slalom/core/Rng.h"

namespace slalom::test
{
/// A chain of points, each in one of a few polyhedra: an instance of the pushing problem [Paper Eq.
/// (2)] or of the dead-zone problem [Eq. (5)].
struct ChainProblem
{
  long id = 0;
  double l1 = 0.8, l2 = 0.8, l3 = 0.6;
  Eigen::Matrix3Xd points;            ///< c_0..c_n
  std::vector<std::size_t> owner;     ///< per point its polyhedron
  std::deque<core::HalfSpaces> sets;  ///< unit normals

  /// The convention of optim::PathSets.
  [[nodiscard]] std::vector<std::vector<const core::HalfSpaces*>> perPoint() const
  {
    std::vector<std::vector<const core::HalfSpaces*>> sets_of_point;
    for (const std::size_t k : owner) sets_of_point.push_back({&sets[k]});
    return sets_of_point;
  }
};

/** Reads the instances of a file `socp_*.txt`. First the number of instances; per instance
 * `id points polyhedra l1 l2 l3`, points `x y z polyhedron`, and per polyhedron its number of
 * half-spaces and lines `ax ay az b`.
 *  @throws std::runtime_error when the file ends early */
[[nodiscard]] inline std::vector<ChainProblem> readChainProblems(const std::filesystem::path& path)
{
  std::ifstream file(path);
  std::size_t count = 0;
  file >> count;
  std::vector<ChainProblem> problems(count);
  for (ChainProblem& problem : problems)
  {
    Eigen::Index points = 0;
    std::size_t polyhedra = 0;
    file >> problem.id >> points >> polyhedra >> problem.l1 >> problem.l2 >> problem.l3;
    if (!file) throw std::runtime_error("broken problem file " + path.string());
    problem.points.resize(3, points);
    problem.owner.resize(static_cast<std::size_t>(points));
    for (Eigen::Index j = 0; j < points; ++j)
      file >> problem.points(0, j) >> problem.points(1, j) >> problem.points(2, j) >>
          problem.owner[static_cast<std::size_t>(j)];
    for (std::size_t k = 0; k < polyhedra; ++k)
    {
      Eigen::Index rows = 0;
      file >> rows;
      core::HalfSpaces& set = problem.sets.emplace_back();
      set.A.resize(rows, 3);
      set.b.resize(rows);
      for (Eigen::Index i = 0; i < rows; ++i)
      {
        file >> set.A(i, 0) >> set.A(i, 1) >> set.A(i, 2) >> set.b[i];
        // The files' normals have unit length to nine digits, ours to sixteen.
        const double length = set.A.row(i).norm();
        set.A.row(i) /= length;
        set.b[i] /= length;
      }
    }
  }
  if (!file) throw std::runtime_error("broken problem file " + path.string());
  return problems;
}

/** A made-up instance of the same kind: a bent line of n + 1 points through `pieces` polyhedra of
 * `rows` half-spaces (the first six a box), which hold an inner line but not all of the points. */
[[nodiscard]] inline ChainProblem makeChainProblem(std::uint64_t seed, Eigen::Index points,
                                                   std::size_t pieces, Eigen::Index rows)
{
  core::Rng rng(seed);
  ChainProblem problem;
  problem.id = static_cast<long>(seed);
  problem.points.resize(3, points);
  Eigen::Vector3d at = rng.uniform3(-3.0, 3.0), heading = rng.direction();
  const double step = 3.0 / static_cast<double>(points);
  for (Eigen::Index j = 0; j < points; ++j)
  {
    problem.points.col(j) = at;
    problem.owner.push_back(static_cast<std::size_t>(j) * pieces /
                            static_cast<std::size_t>(points));
    heading = (heading + 4.0 * step * rng.direction()).normalized();
    at += step * heading;
  }
  for (std::size_t k = 0; k < pieces; ++k)
  {
    const auto share = [&](std::size_t i)
    { return static_cast<Eigen::Index>(i * static_cast<std::size_t>(points - 1) / pieces); };
    const Eigen::Vector3d a = problem.points.col(share(k)), b = problem.points.col(share(k + 1));
    core::HalfSpaces& set = problem.sets.emplace_back();
    set.A.resize(rows, 3);
    set.b.resize(rows);
    for (Eigen::Index i = 0; i < rows; ++i)
    {
      const Eigen::Vector3d normal =
          i < 6 ? (i % 2 == 0 ? 1.0 : -1.0) * Eigen::Vector3d::Unit(i / 2) : rng.direction();
      set.A.row(i) = normal.transpose();
      set.b[i] = std::max(normal.dot(a), normal.dot(b)) + (i < 6 ? 2.0 : rng.uniform(0.01, 1.0));
    }
  }
  return problem;
}

}  // namespace slalom::test
