// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <mutex>

namespace slalom::core
{
/** The one way in which threads share data: one writer publishes immutable snapshots, readers take
 * the newest. The lock is held for a pointer copy only. (libstdc++ 12's atomic<shared_ptr> is not
 * understood by ThreadSanitizer.) */
template <class T>
class Published
{
 public:
  using Snapshot = std::shared_ptr<const T>;

  void publish(Snapshot next)
  {
    {
      const std::scoped_lock lock(mutex_);
      current_.swap(next);
    }
    // `next` now holds the previous snapshot, which dies (if ours was the last owner) outside the
    // lock.
  }

  /// nullptr until the first publish().
  [[nodiscard]] Snapshot latest() const
  {
    const std::scoped_lock lock(mutex_);
    return current_;
  }

 private:
  mutable std::mutex mutex_;
  Snapshot current_;
};

}  // namespace slalom::core
