// SPDX-License-Identifier: BSD-3-Clause
// Arithmetic on the four lanes of a Quad for one instruction set: TrackingSteps.cpp includes this
// file once per set, inside a namespace of its own. SLALOM_SIMD_BYTES is the width of a register.

typedef double Lanes __attribute__((vector_size(SLALOM_SIMD_BYTES)));
constexpr int kParts = 32 / SLALOM_SIMD_BYTES;

struct Pack
{
  Lanes part[kParts];
};

#define SLALOM_PARTS _Pragma("GCC unroll 2") for (int i = 0; i < kParts; ++i)

inline Pack load(const Quad& quad)
{
  Pack pack;
  std::memcpy(&pack, quad.lane, sizeof(pack));
  return pack;
}
inline void store(Quad& quad, const Pack& pack)
{
  std::memcpy(quad.lane, &pack, sizeof(pack));
}
inline Pack all(double value)
{
  Pack pack;
  SLALOM_PARTS pack.part[i] = value - Lanes{};
  return pack;
}
inline Pack operator+(Pack a, const Pack& b)
{
  SLALOM_PARTS a.part[i] += b.part[i];
  return a;
}
inline Pack operator-(Pack a, const Pack& b)
{
  SLALOM_PARTS a.part[i] -= b.part[i];
  return a;
}
inline Pack operator*(Pack a, const Pack& b)
{
  SLALOM_PARTS a.part[i] *= b.part[i];
  return a;
}
inline Pack operator/(Pack a, const Pack& b)
{
  SLALOM_PARTS a.part[i] /= b.part[i];
  return a;
}
inline Pack higher(Pack a, const Pack& b)
{
  SLALOM_PARTS a.part[i] = a.part[i] > b.part[i] ? a.part[i] : b.part[i];
  return a;
}
inline Pack absolute(Pack a)
{
  SLALOM_PARTS a.part[i] = a.part[i] > 0.0 ? a.part[i] : -a.part[i];
  return a;
}
// Lane by lane: yes where t > 0, else no.
inline Pack where(const Pack& t, const Pack& yes, const Pack& no)
{
  Pack pack;
  SLALOM_PARTS pack.part[i] = t.part[i] > 0.0 ? yes.part[i] : no.part[i];
  return pack;
}
inline Pack root(const Pack& a)
{
  Quad quad;
  store(quad, a);
  for (double& lane : quad.lane) lane = std::sqrt(lane);
  return load(quad);
}
// Sum of the lanes; the order of the additions is the same for every width.
inline double total(const Pack& a)
{
  Quad quad;
  store(quad, a);
  return (quad.lane[0] + quad.lane[2]) + (quad.lane[1] + quad.lane[3]);
}
inline double top(const Pack& a)
{
  Quad quad;
  store(quad, a);
  return std::max(std::max(quad.lane[0], quad.lane[1]), std::max(quad.lane[2], quad.lane[3]));
}

#undef SLALOM_PARTS
