// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/simulation/FlightRecorder.h"

#include <algorithm>
#include <cmath>

#include "slalom/mrpt_io/Encoders.h"

namespace slalom::simulation
{
std::uint64_t streamSeed(std::uint64_t seed, std::string_view sensor)
{
  std::uint64_t hash = 0xcbf29ce484222325ULL ^ seed;  // FNV-1a
  for (const char c : sensor)
  {
    hash ^= static_cast<unsigned char>(c);
    hash *= 0x100000001b3ULL;
  }
  return hash;
}

FlightRecorder::FlightRecorder(const World& world, const Motion& motion, double duration,
                               const SensorSuite& suite, std::uint64_t seed)
    : world_(world),
      motion_(motion),
      duration_(duration),
      epoch_(suite.record.epoch_s),
      frame_(suite.gps.datum),
      lidar_config_(suite.lidar),
      lidar_(suite.lidar, streamSeed(seed, "lidar"), std::fmod(suite.record.epoch_s, 3600.0)),
      imu_(suite.imu, streamSeed(seed, "imu")),
      gps_(suite.gps, streamSeed(seed, "gps")),
      velocity_(suite.velocity, streamSeed(seed, "velocity"))
{
  addStreams(suite);
}

void FlightRecorder::addStreams(const SensorSuite& suite)
{
  using mrpt::obs::CObservation;
  using Ptr = CObservation::Ptr;
  const auto truth = [this](double t)
  {
    core::PoseFix pose;
    pose.t = t;
    pose.T_WB = motion_.pose(t);
    pose.sigma_position = 1e-3;
    pose.sigma_rotation = 1e-3;
    return mrpt_io::makePoseObservation(epoch_ + t, pose, "GROUND_TRUTH");
  };
  const auto imu = [this](double t)
  { return mrpt_io::makeImuObservation(epoch_ + t, imu_.sample(motion_, t)); };
  const auto velocity = [this, config = suite.velocity](double t)
  {
    const Eigen::Vector3d v_W = velocity_.sample(motion_, t);  // its noise goes on
    if (isOut(config, t)) return Ptr();
    return Ptr(mrpt_io::makeVelocityObservation(epoch_ + t, v_W));
  };
  const auto gps = [this, config = suite.gps](double t)
  {
    const mrpt_io::GpsReading reading = gps_.reading(motion_, t);
    return isOut(config, t) ? Ptr() : Ptr(mrpt_io::makeGpsObservation(epoch_ + t, reading, frame_));
  };
  streams_ = {{suite.record.truth_rate_hz, 0, truth},
              {suite.imu.rate_hz, 0, imu},
              {suite.velocity.rate_hz, 0, velocity},
              {suite.gps.rate_hz, 0, gps}};
}

mrpt::obs::CObservation::Ptr FlightRecorder::nextScan()
{
  const Vlp16Model::Scan scan = lidar_.nextScan(world_, motion_);
  time_ = scan.t;
  if (isOut(lidar_config_, scan.t)) return nullptr;
  return mrpt_io::makeVelodyneObservation(epoch_ + scan.t, scan.packets, lidar_.mount());
}

/// The first of the earliest: equal times are always told in the same order.
FlightRecorder::Stream& FlightRecorder::earliest()
{
  return *std::min_element(streams_.begin(), streams_.end(),
                           [](const Stream& a, const Stream& b) { return a.next() < b.next(); });
}

mrpt::obs::CObservation::Ptr FlightRecorder::observe(Stream& stream)
{
  time_ = stream.next();
  ++stream.count;
  return stream.observe(time_);
}

mrpt::obs::CObservation::Ptr FlightRecorder::next()
{
  for (;;)
  {
    Stream& stream = earliest();
    const double t = stream.next();
    mrpt::obs::CObservation::Ptr observation;
    if (lidar_.nextScanStart() < t && lidar_.nextScanEnd() <= duration_)
      observation = nextScan();
    else if (t > duration_)
      return nullptr;
    else
      observation = observe(stream);
    if (observation) return observation;  // else: an outage
  }
}

std::vector<mrpt::obs::CObservation::Ptr> FlightRecorder::arrivedBy(double now)
{
  constexpr double kSameTime = 1e-9;  // [s]
  std::vector<mrpt::obs::CObservation::Ptr> arrived;
  for (now = std::min(now, duration_) + kSameTime;;)
  {
    Stream& stream = earliest();
    const double scanned = lidar_.nextScanEnd();
    if (std::min(scanned, stream.next()) > now) return arrived;
    auto observation = scanned < stream.next() ? nextScan() : observe(stream);
    if (observation) arrived.push_back(std::move(observation));
  }
}

std::optional<Contact> firstContact(const World& world, const Motion& motion, double duration,
                                    double radius)
{
  constexpr double kStep = 5e-3;  // [s]
  for (double t = 0.0; t <= duration; t += kStep)
  {
    const Eigen::Vector3d p = motion.pose(t).translation();
    const double distance = std::min(world.distance(p), MoversAt(world.movers(), t).distance(p));
    if (distance < radius) return Contact{t, p, distance};
    if (world.hasGround() && p.z() < 0.0) return Contact{t, p, p.z()};
  }
  return std::nullopt;
}

}  // namespace slalom::simulation
