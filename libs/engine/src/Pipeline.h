// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "slalom/core/PointCloud.h"
#include "slalom/core/Published.h"
#include "slalom/engine/Engine.h"
#include "slalom/engine/StepHooks.h"
#include "slalom/global_planner/GlobalPlanner.h"
#include "slalom/mapping/Mapper.h"
#include "slalom/tracking/MoverTracker.h"

namespace slalom::engine
{
/// One scan ready for fusion.
struct MapJob
{
  double t = 0.0;  ///< [s] end of the scan
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
  std::vector<core::Ray> rays;
  std::size_t silent = 0;   ///< so many of the rays, the last ones, had no echo and show free space
  std::uint64_t frame = 0;  ///< of the local frame: what was mapped in another one is void
};

/// Newest map and how long it took.
struct MapResult
{
  std::shared_ptr<const mapping::EdtSnapshot> field;
  std::vector<core::MovingObstacle> movers;  ///< not in the field
  double wall_s = 0.0, transform_s = 0.0;
  std::uint64_t count = 0;  ///< map steps so far
  std::uint64_t frame = 0;  ///< of the scan's MapJob
};

/// One request to the global planner.
struct GlobalJob
{
  std::uint64_t mission = 0;  ///< results of an earlier mission are ignored
  double t = 0.0;             ///< [s] when it was asked
  global_planner::GlobalPlannerInput input;
};

/// Newest refinement and how long it took.
struct GlobalResult
{
  std::uint64_t mission = 0;
  double t = 0.0;           ///< [s] of the request
  std::uint64_t count = 0;  ///< global steps so far
  double wall_s = 0.0;
  global_planner::GlobalPlannerOutput output;
};

/** A thread that works off jobs in order. When more than `capacity` wait, the oldest are dropped:
 * late data is worth less than new data. */
template <class Job>
class Worker
{
 public:
  Worker(std::size_t capacity, std::function<void(Job)> work)
      : capacity_(capacity),
        work_(std::move(work)),
        thread_([this](std::stop_token stop) { run(stop); })
  {
  }

  /// Number of jobs dropped to make room.
  std::size_t submit(Job job)
  {
    std::size_t dropped = 0;
    {
      const std::scoped_lock lock(mutex_);
      jobs_.push_back(std::move(job));
      for (; jobs_.size() > capacity_; ++dropped) jobs_.pop_front();
    }
    wake_.notify_one();
    return dropped;
  }

  /// Blocks until nothing is waiting and nothing is being worked on.
  void drain()
  {
    std::unique_lock lock(mutex_);
    idle_.wait(lock, [this] { return jobs_.empty() && !busy_; });
  }

 private:
  void run(const std::stop_token& stop)
  {
    std::unique_lock lock(mutex_);
    while (wake_.wait(lock, stop, [this] { return !jobs_.empty(); }))
    {
      Job job = std::move(jobs_.front());
      jobs_.pop_front();
      busy_ = true;
      lock.unlock();
      work_(std::move(job));
      lock.lock();
      busy_ = false;
      idle_.notify_all();
    }
  }

  std::size_t capacity_;
  std::function<void(Job)> work_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::condition_variable idle_;
  std::deque<Job> jobs_;
  bool busy_ = false;
  std::jthread thread_;  // last: starts when all else exists, stops and joins before anything dies
};

/// Mapper and global planner behind their snapshots, in the caller's thread or in their own.
class Pipeline
{
 public:
  /// @param hooks must outlive the pipeline
  Pipeline(const EngineConfig& config, const StepHooks& hooks);

  std::size_t map(MapJob job);        ///< number of scans dropped because the mapper is late
  std::size_t refine(GlobalJob job);  ///< number of requests dropped because the planner is late
  void drain();                       ///< waits for running steps

  [[nodiscard]] std::shared_ptr<const MapResult> latestMap() const { return maps_.latest(); }
  [[nodiscard]] std::shared_ptr<const GlobalResult> latestRefinement() const
  {
    return refinements_.latest();
  }
  /// Steps in which anything was thrown (no memory, no thread): they published nothing.
  [[nodiscard]] std::uint64_t failures() const { return failures_; }
  [[nodiscard]] mapping::Mapper& mapper() { return mapper_; }  ///< only after drain()

 private:
  void runMap(const MapJob& job);
  void runRefine(GlobalJob job);

  const StepHooks& hooks_;
  std::optional<double> global_budget_s_;  // empty: no deadline
  mapping::Mapper mapper_;
  std::optional<tracking::MoverTracker> movers_;
  global_planner::GlobalPlanner planner_;
  core::Published<MapResult> maps_;
  core::Published<GlobalResult> refinements_;
  std::atomic<std::uint64_t> failures_{0};
  std::uint64_t map_count_ = 0, refine_count_ = 0;
  std::uint64_t frame_ = 0;  // of what is mapped
  std::unique_ptr<Worker<MapJob>> map_worker_;
  std::unique_ptr<Worker<GlobalJob>> refine_worker_;
};

}  // namespace slalom::engine
