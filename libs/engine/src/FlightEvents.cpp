// SPDX-License-Identifier: BSD-3-Clause
#include "FlightEvents.h"

#include <utility>

namespace slalom::engine
{
namespace
{
constexpr int kGoodCycles = 10;
constexpr double kPatience_s = 1.0;
}  // namespace

/// Why the vehicle is not flying as it should, for a reason of safety; empty if it is.
std::string FlightEvents::unsafe(const Facts& facts)
{
  if (!facts.unsafe.empty()) return facts.unsafe;
  if (!facts.waiting)
  {
    waiting_since_.reset();
    return {};
  }
  if (!waiting_since_) waiting_since_ = facts.t;
  return facts.t - *waiting_since_ > kPatience_s ? facts.reason : std::string();
}

std::vector<core::Event> FlightEvents::update(const Facts& facts)
{
  std::vector<core::Event> news;
  if (std::exchange(status_, facts.status) != facts.status &&
      facts.status != EngineStatus::NoMission)
    news.push_back({std::string(toString(facts.status)), facts.reason});
  const std::string why = unsafe(facts);
  const bool under_way = facts.status == EngineStatus::Navigating;
  if (!facts.driven || (why.empty() && !under_way))
  {
    // Nobody wants it to fly on: the stop is over without a recovery. A suspended one may go on.
    if (facts.status != EngineStatus::Navigating) stopped_ = false;
    good_cycles_ = 0;
  }
  else if (!why.empty())
  {
    good_cycles_ = 0;
    if (!std::exchange(stopped_, true))
    {
      ++safe_stops_;
      news.push_back({"SAFE_STOP", why});
    }
  }
  else if (stopped_ && !facts.waiting && ++good_cycles_ >= kGoodCycles)
  {
    stopped_ = false;
    good_cycles_ = 0;
    ++recoveries_;
    news.push_back({"RECOVER", facts.reason});
  }
  return news;
}

}  // namespace slalom::engine
