// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/mrpt_io/ObservationDecoder.h"

#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <algorithm>
#include <set>

#include "GpsDecoder.h"
#include "IniParser.h"
#include "MotionDecoder.h"
#include "ObservationClock.h"
#include "RangeDecoder.h"

namespace slalom::mrpt_io
{
namespace
{
using mrpt::obs::CObservation;
using mrpt::obs::CObservationGPS;
using mrpt::obs::CObservationIMU;
using mrpt::obs::CObservationOdometry;
using mrpt::obs::CObservationRobotPose;

std::set<std::string> labels(std::string_view list)
{
  std::set<std::string> names;
  while (!list.empty())
  {
    const std::size_t comma = list.find(',');
    if (const std::string_view name = detail::trim(list.substr(0, comma)); !name.empty())
      names.emplace(name);
    list.remove_prefix(comma == std::string_view::npos ? list.size() : comma + 1);
  }
  return names;
}
}  // namespace

struct ObservationDecoder::Impl
{
  explicit Impl(const InputConfig& c)
      : config(c), gps(c), gps_labels(labels(c.gps_labels)), pose_labels(labels(c.pose_labels))
  {
  }

  /// "" when the observation is understood and wanted.
  std::string refusal(const CObservation& o) const;
  void decode(const CObservation& o, double t, std::vector<core::Measurement>& out);
  void decodePose(const CObservationRobotPose& o, double t, std::vector<core::Measurement>& out);
  std::optional<double> believe(const CObservation& o);

  InputConfig config;
  detail::GpsDecoder gps;
  std::set<std::string> gps_labels, pose_labels;
  detail::ObservationClock clock;
  detail::Dropped dropped;
};

std::string ObservationDecoder::Impl::refusal(const CObservation& o) const
{
  if (detail::isRangeObservation(o) || dynamic_cast<const CObservationIMU*>(&o) ||
      dynamic_cast<const CObservationOdometry*>(&o))
    return "";
  if (dynamic_cast<const CObservationGPS*>(&o))
    return gps_labels.empty() || gps_labels.contains(o.sensorLabel) ? "" : "GPS label not wanted";
  if (dynamic_cast<const CObservationRobotPose*>(&o))
    return pose_labels.empty() || pose_labels.contains(o.sensorLabel) ? ""
                                                                      : "pose label not wanted";
  return std::string(o.GetRuntimeClass()->className) + " not understood";
}

std::optional<double> ObservationDecoder::Impl::believe(const CObservation& o)
{
  std::string reason;
  const std::string sensor = std::string(o.GetRuntimeClass()->className) + " " + o.sensorLabel;
  const auto t = clock.believe(sensor, o.timestamp, reason);
  if (!t) ++dropped[reason];
  return t;
}

void ObservationDecoder::Impl::decodePose(const CObservationRobotPose& o, double t,
                                          std::vector<core::Measurement>& out)
{
  const core::PoseFix fix = detail::decodePose(o, t);
  if (fix.T_WB.matrix().allFinite())
    out.emplace_back(fix);
  else
    ++dropped["pose not finite"];
}

void ObservationDecoder::Impl::decode(const CObservation& o, double t,
                                      std::vector<core::Measurement>& out)
{
  if (const auto* g = dynamic_cast<const CObservationGPS*>(&o))
    return gps.decode(*g, t - config.gps_delay_s, out, dropped);
  if (const auto* imu = dynamic_cast<const CObservationIMU*>(&o))
    return detail::decodeImu(*imu, t, config.velocity_sigma_mps, out, dropped);
  if (const auto* odometry = dynamic_cast<const CObservationOdometry*>(&o))
    return detail::decodeOdometry(*odometry, t, config.velocity_sigma_mps,
                                  pose_labels.contains(o.sensorLabel), out, dropped);
  if (const auto* pose = dynamic_cast<const CObservationRobotPose*>(&o))
    return decodePose(*pose, t, out);
  core::RangeScan scan;
  scan.t = t;
  scan.label = o.sensorLabel;
  detail::decodeRange(o, scan, dropped);
  detail::filterRange(scan, config.min_range_m, config.max_range_m, dropped);
  out.emplace_back(std::move(scan));
}

ObservationDecoder::ObservationDecoder(const InputConfig& config)
    : impl_(std::make_unique<Impl>(config))
{
}

ObservationDecoder::~ObservationDecoder() = default;

std::vector<core::Measurement> ObservationDecoder::decode(const CObservation& observation)
{
  std::vector<core::Measurement> out;
  if (dynamic_cast<const CObservationRobotPose*>(&observation) &&
      observation.sensorLabel == impl_->config.truth_label)
    return out;
  if (const std::string reason = impl_->refusal(observation); !reason.empty())
    ++impl_->dropped[reason];
  else if (const auto t = impl_->believe(observation))
    impl_->decode(observation, *t, out);
  return out;
}

std::optional<core::TimedPose> ObservationDecoder::truth(const CObservation& observation)
{
  const auto* pose = dynamic_cast<const CObservationRobotPose*>(&observation);
  if (!pose || observation.sensorLabel != impl_->config.truth_label) return std::nullopt;
  const auto t = impl_->believe(observation);
  if (!t) return std::nullopt;
  const Eigen::Isometry3d T = detail::decodePose(*pose, *t).T_WB;
  if (!T.matrix().allFinite()) return std::nullopt;
  return core::TimedPose{*t, T.translation(), Eigen::Quaterniond(T.linear())};
}

double ObservationDecoder::logTime(const mrpt::Clock::time_point& stamp)
{
  return impl_->clock.logTime(stamp);
}

double ObservationDecoder::epoch() const
{
  return impl_->clock.epoch();
}

std::optional<Eigen::Vector3d> ObservationDecoder::datum() const
{
  const auto& frame = impl_->gps.frame();
  return frame ? std::optional(frame->datum()) : std::nullopt;
}

const std::map<std::string, std::uint64_t>& ObservationDecoder::dropped() const
{
  return impl_->dropped;
}

}  // namespace slalom::mrpt_io
