// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <optional>

namespace slalom::core
{
/** The moment after which a result is too late. Injected into steps: a steady clock in flight;
 * `none()` in replay and tests, where iteration caps bound the work and results must not depend on
 * the machine's load. */
class Deadline
{
 public:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] static Deadline none() { return Deadline{}; }
  [[nodiscard]] static Deadline in(std::chrono::nanoseconds budget)
  {
    Deadline deadline;
    deadline.at_ = Clock::now() + budget;
    return deadline;
  }

  [[nodiscard]] bool passed() const { return at_ && Clock::now() >= *at_; }

 private:
  std::optional<Clock::time_point> at_;
};

}  // namespace slalom::core
