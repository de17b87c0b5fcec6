// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/estimation/StateEstimator.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "Alignment.h"
#include "HeadingBank.h"
#include "InputCheck.h"

namespace slalom::estimation
{
namespace
{
constexpr double kStrangeJump = 5.0;    // [s] between successive times
constexpr double kStrangeLead = 1.5;    // [s] of a fix before a living IMU
constexpr int kStrangeRun = 10;         // after so many the clock is believed to have changed
constexpr double kVelocityKnown = 3.0;  // [m/s]
constexpr double kResumeWindow = 0.5;   // [s] of IMU before gravity is used again

void requirePositive(const char* name, double value)
{
  if (!(value > 0.0) || !std::isfinite(value))
    throw std::invalid_argument(std::string("estimation.") + name + " = " + std::to_string(value) +
                                " must be positive and finite");
}
}  // namespace

struct StateEstimator::Impl
{
  explicit Impl(const FilterConfig& c) : config(c) { restart(); }

  template <class Fix>
  void addFix(const Fix& fix, char kind, std::uint64_t& count)
  {
    if (const char* reason = detail::defect(fix)) return drop(reason);
    if (!timely(fix.t, gauge->adequate() ? kStrangeLead : kStrangeJump)) return;
    if (fix.t < newest - config.max_delay_s) return drop("too_old");
    if (bank && !bank->leader().reaches(fix.t)) return drop("too_old");
    newest = std::max(newest, fix.t);
    ++count;
    const detail::Aid aid = detail::toAid(fix, slotOf(kind + fix.source));
    if (bank)
      bank->add(aid);
    else
      alignment->add(aid);
    advance();
  }

  void addImu(const core::ImuSample& sample)
  {
    if (const char* reason = detail::defect(sample)) return drop(reason);
    if (!timely(sample.t, kStrangeJump)) return;
    if (sample.t <= newest_imu) return drop("out_of_order");
    if (bank && !bank->leader().reaches(sample.t)) return drop("too_old");
    newest = std::max(newest, sample.t);
    ++counters.imu;
    const detail::RatedImu imu = rater->rate(sample);
    const bool resumed = !gauge->adequate() || sample.t - newest_imu > silence();
    newest_imu = sample.t;
    gauge->add(sample.t);
    if (bank)
      integrate(imu, resumed);
    else
      alignment->add(imu, gauge->adequate());
    advance();
  }

  // A slow IMU is only listened to; one that comes (back) in flight first tells where "up" is.
  void integrate(const detail::RatedImu& imu, bool resumed)
  {
    recent.push_back(imu);
    while (recent.front().sample.t < imu.sample.t - 2.0 * kResumeWindow) recent.pop_front();
    if (resumed) gravity_due = imu.sample.t + kResumeWindow;
    if (!gauge->adequate()) return drop("imu_too_slow");
    bank->add(imu);
    if (!gravity_due || imu.sample.t < *gravity_due) return;
    gravity_due.reset();
    if (const auto gravity = detail::gravityAt(imu.sample.t, recent)) bank->add(*gravity);
  }

  [[nodiscard]] double silence() const { return detail::DelayedFilter::imuGap(config); }

  void advance()
  {
    if (!bank)
    {
      if (const auto start = alignment->tryStart()) bank.emplace(config, *start);
      if (!bank) return;
    }
    const detail::FilterState& s = bank->leader().newest();
    if (!running && canRun(s))
    {
      running = true;
      bank->startLocalFrame();
    }
    if (const auto n = bank->leader().gated(); n + gated_before > 0)
      counters.dropped["gated"] = n + gated_before;
    if (const auto n = bank->leader().undefined(); n > 0) counters.dropped["undefined"] = n;
    counters.resets = resets_before + s.resets;
  }

  [[nodiscard]] bool canRun(const detail::FilterState& s) const
  {
    const bool patient = s.t - bank->startTime() < config.heading_patience_s;
    const double sigma_v = std::sqrt(s.P.diagonal().segment<3>(detail::kV).maxCoeff());
    return (bank->headingKnown() || !patient) && sigma_v < kVelocityKnown;
  }

  // A single strange stamp is an error, a run of them a new clock.
  bool timely(double t, double lead)
  {
    const double ahead = t - newest;
    if (!std::isfinite(newest) || (ahead <= lead && -ahead <= kStrangeJump + config.max_delay_s))
    {
      strange = 0;
      return true;
    }
    if (++strange < kStrangeRun)
    {
      drop("strange_time");
      return false;
    }
    restart();
    return true;
  }

  void restart()
  {
    if (bank)
    {
      gated_before += bank->leader().gated();
      resets_before += bank->leader().newest().resets + 1;
      counters.resets = resets_before;
    }
    rater.emplace(config);
    gauge.emplace(config);
    alignment.emplace(config);
    bank.reset();
    recent.clear();
    gravity_due.reset();
    running = false;
    newest = newest_imu = detail::kNever;
    strange = 0;
  }

  int slotOf(const std::string& source)
  {
    const int next = std::min<int>(static_cast<int>(slots.size()), detail::kSlots - 2);
    return slots.try_emplace(source, next).first->second;
  }

  void drop(const char* reason) { ++counters.dropped[reason]; }

  [[nodiscard]] core::VehicleState publish(core::VehicleState state) const
  {
    // While several headings compete, the spread between them counts too.
    double& variance = state.covariance(detail::kR + 2, detail::kR + 2);
    if (!bank->headingKnown()) variance = std::max(variance, std::pow(bank->headingSigma(), 2));
    return state;
  }

  FilterConfig config;
  EstimatorCounters counters;
  std::optional<detail::ImuRater> rater;
  std::optional<detail::ImuGauge> gauge;
  std::optional<detail::Alignment> alignment;
  std::optional<detail::HeadingBank> bank;
  std::deque<detail::RatedImu> recent;
  std::optional<double> gravity_due;
  std::map<std::string, int> slots;
  bool running = false;
  double newest = detail::kNever;
  double newest_imu = detail::kNever;
  int strange = 0;
  std::uint64_t gated_before = 0;
  std::uint64_t resets_before = 0;
};

StateEstimator::StateEstimator(const FilterConfig& config)
{
  requirePositive("accel_noise", config.accel_noise);
  requirePositive("gyro_noise", config.gyro_noise);
  requirePositive("gate", config.gate);
  requirePositive("max_rejects", config.max_rejects);
  requirePositive("min_imu_rate_hz", config.min_imu_rate_hz);
  requirePositive("manoeuvre_noise", config.manoeuvre_noise);
  requirePositive("turn_noise", config.turn_noise);
  impl_ = std::make_unique<Impl>(config);
}

StateEstimator::~StateEstimator() = default;
StateEstimator::StateEstimator(StateEstimator&&) noexcept = default;
StateEstimator& StateEstimator::operator=(StateEstimator&&) noexcept = default;

void StateEstimator::add(const core::ImuSample& sample)
{
  impl_->addImu(sample);
}
void StateEstimator::add(const core::PositionFix& fix)
{
  impl_->addFix(fix, 'p', impl_->counters.position);
}
void StateEstimator::add(const core::VelocityFix& fix)
{
  impl_->addFix(fix, fix.in_body ? 'b' : 'v', impl_->counters.velocity);
}
void StateEstimator::add(const core::YawFix& fix)
{
  impl_->addFix(fix, 'y', impl_->counters.yaw);
}
void StateEstimator::add(const core::PoseFix& fix)
{
  impl_->addFix(fix, 'o', impl_->counters.pose);
}

EstimatorStatus StateEstimator::status() const
{
  if (!impl_->running)
    return impl_->bank || impl_->alignment->hasGravity() ? EstimatorStatus::Aligning
                                                         : EstimatorStatus::Waiting;
  const detail::FilterState& s = impl_->bank->leader().newest();
  const double aided = std::max(s.last_position, s.last_velocity);
  return s.t - aided > impl_->config.timeout_s ? EstimatorStatus::DeadReckoning
                                               : EstimatorStatus::Running;
}

std::optional<core::VehicleState> StateEstimator::state() const
{
  if (!impl_->running) return std::nullopt;
  return impl_->publish(impl_->bank->leader().newestVehicle());
}

std::optional<core::VehicleState> StateEstimator::stateAt(double t) const
{
  if (!impl_->running) return std::nullopt;
  auto state = impl_->bank->leader().at(t);
  if (!state) return std::nullopt;
  return impl_->publish(std::move(*state));
}

const EstimatorCounters& StateEstimator::counters() const
{
  return impl_->counters;
}

void StateEstimator::reset()
{
  impl_ = std::make_unique<Impl>(impl_->config);
}

}  // namespace slalom::estimation
