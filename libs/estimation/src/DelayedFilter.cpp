// SPDX-License-Identifier: BSD-3-Clause
#include "DelayedFilter.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "slalom/core/Math.h"

namespace slalom::estimation::detail
{
namespace
{
constexpr double kHistory = 1.0;         // [s] at least, for motion compensation
constexpr double kBlindForCourse = 2.0;  // [s] without IMU or heading before course is a heading

// Equal times need an order of their own, else the order of arrival would matter.
template <class Node>
auto key(const Node& node)
{
  const auto* aid = std::get_if<Aid>(&node.event);
  return std::make_tuple(node.t, node.event.index(), aid ? static_cast<int>(aid->kind) : -1,
                         aid ? aid->slot : -1);
}

Vector15 difference(const FilterState& there, const FilterState& here)
{
  const Eigen::AngleAxisd turn((there.q * here.q.conjugate()).normalized());
  Vector15 dx;
  dx << there.p - here.p, there.v - here.v, turn.angle() * turn.axis(), there.bg - here.bg,
      there.ba - here.ba;
  return dx;
}

bool courseIsHeading(const FilterState& s)
{
  const double known = std::max({s.last_imu, s.last_heading, s.last_body_velocity});
  return s.t - known > kBlindForCourse;
}
}  // namespace

DelayedFilter::DelayedFilter(const FilterConfig& config, const FilterState& start,
                             const std::optional<RatedImu>& before, double gate)
    : config_(config), gate_(gate), before_(before)
{
  Node anchor;
  anchor.t = start.t;
  anchor.state = start;
  anchor.has_p_L = true;
  nodes_.push_back(anchor);
  if (before) last_imu_ = before->sample.t;
}

void DelayedFilter::add(const RatedImu& imu)
{
  last_imu_ = std::max(last_imu_, imu.sample.t);
  Node node;
  node.event = imu;
  node.t = imu.sample.t;
  insert(std::move(node));
}

void DelayedFilter::add(const Aid& aid)
{
  Node node;
  node.event = aid;
  node.t = aid.t;
  insert(std::move(node));
}

void DelayedFilter::insert(Node node)
{
  const bool is_imu = std::holds_alternative<RatedImu>(node.event);
  const auto place = std::upper_bound(nodes_.begin() + 1, nodes_.end(), node,
                                      [](const Node& a, const Node& b) { return key(a) < key(b); });
  auto index = static_cast<std::size_t>(place - nodes_.begin());
  nodes_.insert(place, std::move(node));
  if (index < processed_)
  {
    ++processed_;
    placeLocally(index);
    // A late IMU sample also changes how the interval before it is integrated.
    if (is_imu)
      while (index > 1 && !std::holds_alternative<RatedImu>(nodes_[index - 1].event)) --index;
    processed_ = index;
  }
  advance();
}

void DelayedFilter::advance()
{
  // Without a living IMU nothing waits; with one, aids behind its newest sample do.
  std::size_t end = nodes_.size();
  if (nodes_.back().t - last_imu_ <= imuGap(config_))
    while (end > processed_ && !std::holds_alternative<RatedImu>(nodes_[end - 1].event)) --end;
  while (processed_ < end) step(processed_++);
  tell();
  prune();
}

const RatedImu* DelayedFilter::imuUpTo(std::size_t index) const
{
  for (std::size_t i = index + 1; i-- > 0;)
    if (const auto* imu = std::get_if<RatedImu>(&nodes_[i].event)) return imu;
  return before_ ? &*before_ : nullptr;
}

const RatedImu* DelayedFilter::imuFrom(std::size_t index) const
{
  for (std::size_t i = index; i < nodes_.size(); ++i)
    if (const auto* imu = std::get_if<RatedImu>(&nodes_[i].event)) return imu;
  return nullptr;
}

void DelayedFilter::step(std::size_t index)
{
  Node& node = nodes_[index];
  node.state = nodes_[index - 1].state;
  move(node.state, index);
  if (std::holds_alternative<Aid>(node.event)) correct(node);
  placeLocally(index);
}

void DelayedFilter::move(FilterState& state, std::size_t index) const
{
  const double t = nodes_[index].t;
  if (t <= state.t) return;
  const RatedImu* before = imuUpTo(index - 1);
  const RatedImu* after = imuFrom(index);
  if (before && after && after->sample.t - before->sample.t <= imuGap(config_))
    predictInertial(state, t, *before, *after, config_);
  else
    predictKinematic(state, t, config_);
}

void DelayedFilter::correct(Node& node)
{
  const Aid& aid = std::get<Aid>(node.event);
  const Outcome outcome = applyAid(node.state, aid, config_, gate_);
  if (outcome == Outcome::Accepted && courseIsHeading(node.state)) applyCourse(node.state, config_);
  count(node.outcome, -1);
  node.outcome = outcome;
  count(node.outcome, +1);
}

void DelayedFilter::count(const std::optional<Outcome>& outcome, std::int64_t change)
{
  if (outcome == Outcome::Gated) gated_ += static_cast<std::uint64_t>(change);
  if (outcome == Outcome::Undefined) undefined_ += static_cast<std::uint64_t>(change);
}

void DelayedFilter::placeLocally(std::size_t index)
{
  Node& node = nodes_[index];
  if (node.has_p_L) return;
  const Node& previous = nodes_[index - 1];
  const double dt = node.t - previous.t;
  node.v_L = node.state.v;
  // A late event lies on the path that has already been told.
  if (index + 1 < processed_ && nodes_[index + 1].has_p_L)
  {
    const Node& next = nodes_[index + 1];
    const double span = next.t - previous.t;
    node.p_L = previous.p_L + (span > 0.0 ? dt / span : 0.0) * (next.p_L - previous.p_L);
  }
  else
  {
    node.p_L = previous.p_L + 0.5 * dt * (previous.v_L + node.v_L);
  }
  node.has_p_L = true;
}

void DelayedFilter::tell()
{
  nodes_[processed_ - 1].v_L = newest().v;
}

void DelayedFilter::prune()
{
  const double oldest = newest().t - std::max(kHistory, config_.max_delay_s);
  while (processed_ > 2 && nodes_[1].t <= oldest)
  {
    if (const auto* imu = std::get_if<RatedImu>(&nodes_.front().event)) before_ = *imu;
    nodes_.pop_front();
    --processed_;
  }
}

core::VehicleState DelayedFilter::vehicle(const Node& node) const
{
  core::VehicleState out;
  out.t = node.t;
  out.p_L = node.p_L;
  out.p_W = node.state.p;
  out.q_WB = node.state.q;
  out.v_W = node.state.v;
  out.w_B = node.state.w_B;
  out.covariance = node.state.P.topLeftCorner<9, 9>();
  return out;
}

core::VehicleState DelayedFilter::newestVehicle() const
{
  return vehicle(nodes_[processed_ - 1]);
}

std::optional<core::VehicleState> DelayedFilter::at(double t) const
{
  const Node& last = nodes_[processed_ - 1];
  if (!(t >= nodes_.front().t) || !(t <= last.t + config_.max_extrapolation_s)) return std::nullopt;
  if (t >= last.t)
  {
    FilterState ahead = last.state;
    predictKinematic(ahead, t, config_);
    core::VehicleState out = vehicle(last);
    out.t = t;
    out.p_L += (t - last.t) * last.state.v;
    out.p_W = ahead.p;
    out.q_WB = last.state.q * core::expSO3((t - last.t) * last.state.w_B);
    out.covariance = ahead.P.topLeftCorner<9, 9>();
    return out;
  }
  const auto end = nodes_.begin() + static_cast<std::ptrdiff_t>(processed_);
  const auto after = std::upper_bound(nodes_.begin(), end, t,
                                      [](double time, const Node& node) { return time < node.t; });
  const core::VehicleState a = vehicle(*(after - 1));
  const core::VehicleState b = vehicle(*after);
  const double u = (t - a.t) / (b.t - a.t);
  core::VehicleState out = a;
  out.t = t;
  out.p_L += u * (b.p_L - a.p_L);
  out.p_W += u * (b.p_W - a.p_W);
  out.q_WB = a.q_WB.slerp(u, b.q_WB);
  out.v_W += u * (b.v_W - a.v_W);
  out.w_B += u * (b.w_B - a.w_B);
  out.covariance += u * (b.covariance - a.covariance);
  return out;
}

void DelayedFilter::startLocalFrame()
{
  for (std::size_t i = processed_; i-- > 0;)
  {
    Node& node = nodes_[i];
    node.has_p_L = true;
    node.p_L.setZero();
    node.v_L = node.state.v;
    if (i + 1 == processed_) continue;
    // The past is told backwards along the velocity: position corrections leave no trace in L.
    const Node& next = nodes_[i + 1];
    node.p_L = next.p_L - 0.5 * (next.t - node.t) * (node.v_L + next.v_L);
  }
}

void DelayedFilter::adoptLocalFrame(const DelayedFilter& other)
{
  for (std::size_t i = 0; i < nodes_.size() && i < other.nodes_.size(); ++i)
  {
    nodes_[i].p_L = other.nodes_[i].p_L;
    nodes_[i].v_L = other.nodes_[i].v_L;
    nodes_[i].has_p_L = other.nodes_[i].has_p_L;
  }
  tell();
}

void DelayedFilter::blend(const std::vector<const DelayedFilter*>& others,
                          const std::vector<double>& weights)
{
  for (std::size_t i = 0; i < processed_; ++i)
  {
    const FilterState here = nodes_[i].state;
    Vector15 mean = Vector15::Zero();
    Matrix15 second = Matrix15::Zero();
    for (std::size_t j = 0; j < others.size(); ++j)
    {
      const FilterState& there = others[j]->nodes_[i].state;
      const Vector15 dx = difference(there, here);
      mean += weights[j] * dx;
      second += weights[j] * (there.P + dx * dx.transpose());
    }
    FilterState& s = nodes_[i].state;
    s.P = second - mean * mean.transpose();
    s.p += mean.segment<3>(kP);
    s.v += mean.segment<3>(kV);
    s.q = (core::expSO3(mean.segment<3>(kR)) * s.q).normalized();
    s.bg += mean.segment<3>(kBg);
    s.ba += mean.segment<3>(kBa);
  }
  tell();
}

}  // namespace slalom::estimation::detail
