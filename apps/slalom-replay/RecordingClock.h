// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <optional>

namespace slalom::replay
{
/** The present of a recording: the newest believable time stamp. A stamp that jumps by more than
 * ten seconds, in either direction, is believed only when the next one agrees with it (objects of
 * another day, damaged stamps). */
class RecordingClock
{
 public:
  /// @param stamp Unix time of the next observation [s]
  /// @return true if time jumped: what was planned before is history
  bool advance(double stamp)
  {
    constexpr double kJump_s = 10.0;
    const bool near = now_ && std::abs(stamp - *now_) <= kJump_s;
    const bool confirmed = suspect_ && std::abs(stamp - *suspect_) <= kJump_s;
    suspect_ = near ? std::nullopt : std::optional<double>(stamp);
    if (now_ && !near && !confirmed) return false;
    const bool jumped = now_ && !near;
    if (!now_ || jumped) start_ = stamp - (jumped ? *now_ - start_ : 0.0);
    now_ = jumped || !now_ ? stamp : std::max(*now_, stamp);
    suspect_.reset();
    return jumped;
  }

  [[nodiscard]] bool started() const { return now_.has_value(); }
  [[nodiscard]] double now() const { return now_.value_or(0.0); }  ///< [s] Unix time
  [[nodiscard]] double elapsed() const
  {
    return now_ ? *now_ - start_ : 0;
  }  ///< [s] since the start, jumps left out

 private:
  std::optional<double> now_, suspect_;
  double start_ = 0.0;
};

}  // namespace slalom::replay
