// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/simulation/SimulatedFlight.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <stdexcept>

namespace slalom::simulation
{
namespace
{
constexpr double kEndless = std::numeric_limits<double>::infinity();

/// The slowest revolution, and the oldest GPS fix.
double memoryFor(const SensorSuite& suite)
{
  constexpr double kScan_s = 0.5;
  return kScan_s + suite.gps.delay_s;
}
}  // namespace

SimulatedFlight::SimulatedFlight(const World& world, const AirframeConfig& airframe,
                                 const SensorSuite& suite, const FlightStart& start,
                                 std::uint64_t seed)
    : world_(world),
      radius_(start.radius_m),
      vehicle_(makeVehicle(airframe, start.p_W, start.yaw, streamSeed(seed, "wind"))),
      path_(kStep, memoryFor(suite), vehicle_->sample()),
      sensors_(world, path_, kEndless, suite, seed)
{
  judge(path_.newest());
  if (!truth_.first_contact) return;
  char text[200];
  std::snprintf(text, sizeof text,
                "the start (%.2f, %.2f, %.2f) is in contact with the world: %.3f m from it, the "
                "vehicle's radius is %.2f m",
                start.p_W.x(), start.p_W.y(), start.p_W.z(), truth_.first_contact->distance,
                radius_);
  throw std::invalid_argument(text);
}

void ClearanceHistogram::add(double clearance)
{
  const double bin = std::clamp(clearance / kBin, 0.0, static_cast<double>(kBins - 1));
  ++counts_[static_cast<std::size_t>(bin)];
}

double ClearanceHistogram::quantile(double share) const
{
  const auto all = std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0});
  if (all == 0) return std::numeric_limits<double>::quiet_NaN();
  std::uint64_t below = 0;
  for (int bin = 0; bin < kBins; ++bin)
  {
    below += counts_[static_cast<std::size_t>(bin)];
    if (static_cast<double>(below) >= share * static_cast<double>(all)) return kBin * (bin + 1);
  }
  return kBin * kBins;
}

void SimulatedFlight::judge(const MotionSample& now)
{
  // As in firstContact(): the ground counts for the centre alone.
  const double still = world_.distance(now.p_W);
  const double moving = MoversAt(world_.movers(), truth_.t).distance(now.p_W);
  const double distance = std::min(still, moving);
  const bool under_ground = world_.hasGround() && now.p_W.z() < 0.0;
  const Contact here{truth_.t, now.p_W, under_ground ? std::min(distance, now.p_W.z()) : distance};
  if (here.distance < truth_.nearest.distance) truth_.nearest = here;
  if (moving < truth_.nearest_mover.distance) truth_.nearest_mover = {truth_.t, now.p_W, moving};
  truth_.clearances.add(here.distance);
  const bool contact = distance < radius_ || under_ground;
  if (contact && !in_contact_) ++truth_.contacts;
  if (contact && !truth_.first_contact)
  {
    truth_.first_contact = here;
    truth_.hit_mover = moving < still && !under_ground;
  }
  in_contact_ = contact;
}

void SimulatedFlight::step()
{
  const Eigen::Vector3d before = path_.newest().p_W;
  vehicle_->advance(kStep * static_cast<double>(++steps_) - vehicle_->time());
  const MotionSample& now = vehicle_->sample();
  path_.append(now);
  truth_.t = vehicle_->time();
  truth_.length_m += (now.p_W - before).norm();
  truth_.max_speed_mps = std::max(truth_.max_speed_mps, now.v_W.norm());
  truth_.max_acceleration_mps2 = std::max(truth_.max_acceleration_mps2, now.a_W.norm());
  truth_.acceleration_effort += kStep * now.a_W.squaredNorm();
  truth_.jerk_effort += (now.a_W - last_acceleration_).squaredNorm() / kStep;
  last_acceleration_ = now.a_W;
  judge(now);
}

std::vector<mrpt::obs::CObservation::Ptr> SimulatedFlight::advance(
    double dt, const core::VelocityCommand& command)
{
  vehicle_->command(command);
  until_ += dt;
  while (kStep * static_cast<double>(steps_ + 1) <= until_ + 1e-9) step();
  return sensors_.arrivedBy(path_.end());
}

}  // namespace slalom::simulation
