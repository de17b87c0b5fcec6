// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/core/Rng.h"

#include <bit>
#include <cmath>
#include <numbers>

namespace slalom::core
{
Rng::Rng(std::uint64_t seed)
{
  for (std::uint64_t& word : state_)
  {
    seed += 0x9e3779b97f4a7c15ULL;
    std::uint64_t z = seed;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    word = z ^ (z >> 31);
  }
}

std::uint64_t Rng::bits()
{
  const std::uint64_t result = std::rotl(state_[0] + state_[3], 23) + state_[0];
  const std::uint64_t t = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= t;
  state_[3] = std::rotl(state_[3], 45);
  return result;
}

double Rng::uniform()
{
  return static_cast<double>(bits() >> 11) * 0x1.0p-53;
}

double Rng::uniform(double lo, double hi)
{
  return lo + (hi - lo) * uniform();
}

int Rng::integer(int lo, int hi)
{
  return lo + static_cast<int>(uniform() * (static_cast<double>(hi) - lo + 1.0));
}

double Rng::normal()
{
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
  return radius * std::cos(2.0 * std::numbers::pi * uniform());
}

Eigen::Vector3d Rng::normal3(double sigma)
{
  const double x = normal(), y = normal(), z = normal();
  return sigma * Eigen::Vector3d(x, y, z);
}

Eigen::Vector3d Rng::uniform3(double lo, double hi)
{
  const double x = uniform(lo, hi), y = uniform(lo, hi), z = uniform(lo, hi);
  return {x, y, z};
}

Eigen::Vector3d Rng::direction()
{
  const double z = uniform(-1.0, 1.0);
  const double angle = uniform(0.0, 2.0 * std::numbers::pi);
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

}  // namespace slalom::core
