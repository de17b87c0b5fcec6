// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

namespace slalom::search::detail
{
/** Priority queue of buckets of equal width, last in first out within a bucket: what it returns is
 * less than one width worse than the best, and the same every time. Priorities may fall. */
template <class Entry>
class BucketQueue
{
 public:
  /// Empties it. No priority will be below `lowest`.
  void reset(float lowest, float width)
  {
    lowest_ = lowest;
    per_unit_ = 1.0f / width;
    heads_.clear();
    links_.clear();
    front_ = 0;
  }
  void push(float priority, const Entry& entry)
  {
    const std::size_t bucket = bucketOf(priority);
    if (bucket >= heads_.size()) heads_.resize(bucket + bucket / 2 + 64, kNone);
    links_.push_back({entry, heads_[bucket]});
    heads_[bucket] = static_cast<std::uint32_t>(links_.size() - 1);
    front_ = std::min(front_, bucket);
  }
  /// False if there is none left.
  bool pop(Entry& entry)
  {
    if (!toFront()) return false;
    const Link& link = links_[heads_[front_]];
    entry = link.entry;
    heads_[front_] = link.next;
    return true;
  }
  /// True if all that is left is in later buckets than this priority.
  [[nodiscard]] bool before(float priority) { return !toFront() || bucketOf(priority) < front_; }
  /// No priority that is left is below this; infinite if none is left.
  [[nodiscard]] float lowest()
  {
    return toFront() ? lowest_ + static_cast<float>(front_) / per_unit_
                     : std::numeric_limits<float>::infinity();
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  /// Priorities beyond this share one bucket: two thousand widths make ten straight distances.
  static constexpr int kMostBuckets = 1 << 18;

  struct Link
  {
    Entry entry;
    std::uint32_t next;
  };
  [[nodiscard]] std::size_t bucketOf(float priority) const
  {
    const float at = std::min((priority - lowest_) * per_unit_, static_cast<float>(kMostBuckets));
    return at > 0.0f ? static_cast<std::size_t>(at) : 0;
  }
  bool toFront()
  {
    while (front_ < heads_.size() && heads_[front_] == kNone) ++front_;
    return front_ < heads_.size();
  }

  std::vector<std::uint32_t> heads_;
  std::vector<Link> links_;
  std::size_t front_ = 0;
  float lowest_ = 0.0f, per_unit_ = 1.0f;
};
}  // namespace slalom::search::detail
