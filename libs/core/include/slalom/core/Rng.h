// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace slalom::core
{
/** Seeded random numbers, equal on every platform and standard library (std:: distributions are
 * not). Generator: xoshiro256++ seeded by splitmix64 (Blackman and Vigna). */
class Rng
{
 public:
  explicit Rng(std::uint64_t seed);

  [[nodiscard]] std::uint64_t bits();
  [[nodiscard]] double uniform();                       ///< in [0, 1)
  [[nodiscard]] double uniform(double lo, double hi);   ///< in [lo, hi)
  [[nodiscard]] int integer(int lo, int hi);            ///< in [lo, hi], both included
  [[nodiscard]] double normal();                        ///< standard normal
  [[nodiscard]] Eigen::Vector3d normal3(double sigma);  ///< three independent normals
  [[nodiscard]] Eigen::Vector3d uniform3(double lo, double hi);
  [[nodiscard]] Eigen::Vector3d direction();  ///< uniform on the unit sphere

 private:
  std::uint64_t state_[4];
};

}  // namespace slalom::core
