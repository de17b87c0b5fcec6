// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <stdexcept>

#include "FlightPath.h"
#include "NaturalSpline.h"
#include "slalom/core/Math.h"

namespace slalom::simulation
{
namespace
{
constexpr double kKnotStep = 0.1;   // [s] finer knots would turn millimetres of noise into m/s^2
constexpr double kRestSpeed = 0.1;  // [m/s]

struct PosePath : ScriptedFlight::Path
{
  detail::NaturalSpline curve;
  explicit PosePath(detail::NaturalSpline spline) : curve(std::move(spline)) {}

  Sample at(double t) const override
  {
    const detail::NaturalSpline::Sample s = curve.at(t);
    return {s.value.head<3>(), s.first.head<3>(), s.second.head<3>(), s.value.w()};
  }
  double duration() const override { return curve.end(); }
};

struct Knots
{
  std::vector<double> times;
  std::vector<Eigen::Vector4d> values;

  void hold(double seconds)
  {
    const std::size_t steps = static_cast<std::size_t>(std::ceil(seconds / kKnotStep));
    const double from = times.back();
    for (std::size_t k = 1; k <= steps; ++k)
    {
      times.push_back(from + seconds * static_cast<double>(k) / static_cast<double>(steps));
      values.push_back(values.back());
    }
  }
};

std::vector<core::TimedPose> thinned(const std::vector<core::TimedPose>& poses)
{
  std::vector<core::TimedPose> kept{poses.front()};
  for (std::size_t k = 1; k + 1 < poses.size(); ++k)
    if (poses[k].t - kept.back().t >= kKnotStep - 1e-6 &&
        poses.back().t - poses[k].t >= 0.5 * kKnotStep)
      kept.push_back(poses[k]);
  kept.push_back(poses.back());
  return kept;
}

bool atRest(const core::TimedPose& a, const core::TimedPose& b)
{
  return (b.position - a.position).norm() < kRestSpeed * (b.t - a.t);
}
}  // namespace

ScriptedFlight ScriptedFlight::along(const std::vector<core::TimedPose>& poses,
                                     const FlightConfig& config)
{
  if (poses.size() < 2) throw std::invalid_argument("a trajectory needs at least two poses");
  for (std::size_t k = 1; k < poses.size(); ++k)
    if (!(poses[k].t > poses[k - 1].t))
      throw std::invalid_argument("pose " + std::to_string(k + 1) + " is not after the one before");
  const std::vector<core::TimedPose> kept = thinned(poses);

  Knots knots;
  double yaw = core::yawOf(kept.front().orientation);
  const auto valueOf = [&](const core::TimedPose& pose)
  {
    yaw += core::wrapAngle(core::yawOf(pose.orientation) - yaw);
    return Eigen::Vector4d(pose.position.x(), pose.position.y(), pose.position.z(), yaw);
  };
  knots.times.push_back(0.0);
  knots.values.push_back(valueOf(kept.front()));
  if (atRest(kept[0], kept[1])) knots.hold(config.hover_before_s);
  const double shift = knots.times.back() - kept.front().t;
  for (std::size_t k = 1; k < kept.size(); ++k)
  {
    knots.times.push_back(kept[k].t + shift);
    knots.values.push_back(valueOf(kept[k]));
  }
  if (atRest(kept[kept.size() - 2], kept.back())) knots.hold(config.hover_after_s);
  return ScriptedFlight(std::make_unique<PosePath>(
      detail::NaturalSpline(std::move(knots.times), std::move(knots.values))));
}

}  // namespace slalom::simulation
