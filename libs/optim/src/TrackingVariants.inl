// SPDX-License-Identifier: BSD-3-Clause
// The steps for one instruction set: its arithmetic, and the kernel for every size and vehicle.
#include "TrackingPack.inl"

namespace heading
{
#define SLALOM_AXES 1
#define SLALOM_LAG false
#include "TrackingKernel.inl"
#undef SLALOM_LAG
}  // namespace heading
namespace heading_lag
{
#define SLALOM_LAG true
#include "TrackingKernel.inl"
#undef SLALOM_LAG
#undef SLALOM_AXES
}  // namespace heading_lag
namespace flight
{
#define SLALOM_AXES 3
#define SLALOM_LAG false
#include "TrackingKernel.inl"
#undef SLALOM_LAG
}  // namespace flight
namespace flight_lag
{
#define SLALOM_LAG true
#include "TrackingKernel.inl"
#undef SLALOM_LAG
#undef SLALOM_AXES
}  // namespace flight_lag
