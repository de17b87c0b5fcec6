// SPDX-License-Identifier: BSD-3-Clause
#include "Pipeline.h"

#include "Stopwatch.h"

namespace slalom::engine
{
Pipeline::Pipeline(const EngineConfig& config, const StepHooks& hooks)
    : hooks_(hooks), mapper_(config.mapping), planner_(config.global_planner, config.planned())
{
  if (config.tracking.enabled) movers_.emplace(config.tracking);
  if (!config.rates.threaded) return;
  global_budget_s_ = config.rates.global_period_s;
  map_worker_ = std::make_unique<Worker<MapJob>>(2, [this](const MapJob& job) { runMap(job); });
  refine_worker_ =
      std::make_unique<Worker<GlobalJob>>(1, [this](GlobalJob job) { runRefine(std::move(job)); });
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
  runRefine(std::move(job));
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
    if (hooks_.map) hooks_.map();
    // The scan that began the frame may have been lost: any of the frame's will do.
    if (job.frame != frame_)
    {
      mapper_.reset();
      if (movers_) movers_->reset();
      frame_ = job.frame;
    }
    tracking::TrackerOutput moving;
    const std::span<const core::Ray> echoes(job.rays.data(), job.rays.size() - job.silent);
    if (movers_) moving = movers_->update(job.t, job.p_L, echoes, mapper_.snapshot().get());
    moving.on_mover.resize(echoes.size(), 0);
    moving.on_mover.resize(job.rays.size(), 1);
    const mapping::MapUpdate update =
        mapper_.integrate(job.t, job.p_L, job.rays, {moving.on_mover, moving.ghosts});
    maps_.publish(std::make_shared<const MapResult>(
        MapResult{mapper_.snapshot(), std::move(moving.movers), watch.seconds(), update.transform_s,
                  ++map_count_, frame_}));
  }
  catch (...)
  {
    // No new map: the old one grows stale, and the engine brakes when it is too old.
    ++failures_;
  }
}

void Pipeline::runRefine(GlobalJob job)
{
  const Stopwatch watch;
  try
  {
    if (global_budget_s_)
      job.input.deadline = core::Deadline::in(std::chrono::duration_cast<std::chrono::nanoseconds>(
          std::chrono::duration<double>(*global_budget_s_)));
    if (hooks_.global) hooks_.global();
    auto output = planner_.step(job.input);
    refinements_.publish(std::make_shared<const GlobalResult>(
        GlobalResult{job.mission, job.t, ++refine_count_, watch.seconds(), std::move(output)}));
  }
  catch (...)
  {
    // The plan in force stays, and ends where it was last verified.
    ++failures_;
  }
}

}  // namespace slalom::engine
