// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include "EngineImpl.h"

namespace slalom::engine
{
/// The newest map of the present local frame.
std::shared_ptr<const MapResult> Engine::Impl::currentMap() const
{
  auto map = pipeline.latestMap();
  return map && map->frame == map_frame ? map : nullptr;
}

/// The local frame began anew: whatever was expressed in the old one is void.
void Engine::Impl::beginNewFrame()
{
  ++map_frame;
  if (flight) flight->number = ++missions;  // refinements under way belong to the old frame
  if (refinements.refined()) clock.restart(refinements.refined()->referenceTime(clock.progress()));
  refinements.forgetFrame();
  local.reset();
  due.clear();
  relied_stop = {};
  relied_evasion = {};
  if (const auto state = source.state(source.newest()); state && flight)
    flight->moveTo(state->p_L - state->p_W);
}

void Engine::Impl::mapPending(double t)
{
  if (std::exchange(seen_epoch, source.frameEpoch()) != source.frameEpoch()) beginNewFrame();
  for (MapJob& job : scans.take(source, t, statistics.dropped))
  {
    job.frame = map_frame;
    ++statistics.scans;
    if (source.newest() - t > config.safety.state_timeout_s)
    {
      ++statistics.dropped["scan: state ahead of the clock"];
      continue;
    }
    sensors.heardScan(scan_label, job.t);
    // Not fused, the map grows old, and the vehicle waits until sensor and map agree again.
    const auto map = currentMap();
    scan_refused = map && contradicts(job, *map->field, map->movers);
    if (scan_refused)
    {
      ++statistics.dropped["scan: contradicts the map"];
      continue;
    }
    if (const std::size_t lost = pipeline.map(std::move(job)))
    {
      statistics.dropped["scan: mapper late"] += lost;
      statistics.late_map += lost;
    }
  }
}

}  // namespace slalom::engine
