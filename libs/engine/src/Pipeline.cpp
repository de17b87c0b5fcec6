// SPDX-License-Identifier: BSD-3-Clause
#include "Pipeline.h"

#include "Stopwatch.h"

namespace slalom::engine
{
Pipeline::Pipeline(const EngineConfig& config)
    : mapper_(config.mapping), planner_(config.global_planner, config.planned())
{
  if (!config.rates.threaded) return;
  map_worker_ = std::make_unique<Worker<MapJob>>(2, [this](const MapJob& job) { runMap(job); });
  refine_worker_ =
      std::make_unique<Worker<GlobalJob>>(1, [this](const GlobalJob& job) { runRefine(job); });
}

std::size_t Pipeline::map(MapJob job)
{
  if (map_worker_) return map_worker_->submit(std::move(job));
  runMap(job);
  return 0;
}

std::size_t Pipeline::refine(GlobalJob job)
{
  if (refine_worker_) return refine_worker_->submit(std::move(job));
  runRefine(job);
  return 0;
}

void Pipeline::drain()
{
  if (map_worker_) map_worker_->drain();
  if (refine_worker_) refine_worker_->drain();
}

void Pipeline::runMap(const MapJob& job)
{
  const Stopwatch watch;
  try
  {
    if (job.forget) mapper_.reset();
    const mapping::MapUpdate update = mapper_.integrate(job.t, job.p_L, job.rays);
    maps_.publish(std::make_shared<const MapResult>(
        MapResult{mapper_.snapshot(), watch.seconds(), update.transform_s, ++map_count_}));
  }
  catch (const std::exception&)
  {
    // No new map: the old one grows stale, and the engine brakes when it is too old.
    ++failures_;
  }
}

void Pipeline::runRefine(const GlobalJob& job)
{
  const Stopwatch watch;
  try
  {
    auto output = planner_.step(job.input);
    refinements_.publish(std::make_shared<const GlobalResult>(
        GlobalResult{job.mission, ++refine_count_, watch.seconds(), std::move(output)}));
  }
  catch (const std::exception&)
  {
    // The plan in force stays, and ends where it was last verified.
    ++failures_;
  }
}

}  // namespace slalom::engine
