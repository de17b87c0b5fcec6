// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/core/format.h>
#include <mrpt/poses/CPose3D.h>

#include "slalom/navigator/Navigator.h"

namespace slalom::navigator
{
bool RobotInterface3D::pullObservations(std::vector<std::shared_ptr<mrpt::obs::CObservation>>&)
{
  return false;
}
mrpt::Clock::time_point RobotInterface3D::now()
{
  return mrpt::Clock::now();
}
void RobotInterface3D::onEvent(const std::string&, const std::string&) {}
bool RobotInterface3D::senseObstacles(mrpt::maps::CSimplePointsMap&, mrpt::system::TTimeStamp&)
{
  return false;
}

bool RobotInterface3D::getCurrentPoseAndSpeeds(mrpt::math::TPose2D& pose,
                                               mrpt::math::TTwist2D& velocity,
                                               mrpt::system::TTimeStamp& timestamp,
                                               mrpt::math::TPose2D& odometry, std::string& frame_id)
{
  State3D state;
  if (!getCurrentState3D(state)) return false;
  pose = odometry = mrpt::math::TPose2D(state.pose);
  velocity = {state.twist.vx, state.twist.vy, state.twist.wz};
  timestamp = state.time;
  frame_id = state.frame;
  return true;
}

bool RobotInterface3D::changeSpeeds(const mrpt::kinematics::CVehicleVelCmd& command)
{
  const auto* command3D = dynamic_cast<const VelocityCommand3D*>(&command);
  return command3D && changeSpeeds3D(*command3D);
}
bool RobotInterface3D::stop(bool emergency)
{
  return stop3D(emergency);
}

mrpt::kinematics::CVehicleVelCmd::Ptr RobotInterface3D::getEmergencyStopCmd()
{
  return std::make_shared<VelocityCommand3D>();
}
mrpt::kinematics::CVehicleVelCmd::Ptr RobotInterface3D::getStopCmd()
{
  return std::make_shared<VelocityCommand3D>();
}

std::string NavigationParams3D::getAsText() const
{
  std::string text = "navparams3D. Target:\n";
  text += mrpt::format("target3D = %s [m deg], frame \"%s\"\n", target3D.asString().c_str(),
                       target.target_frame_id.c_str());
  text += mrpt::format("allowed_distance_m = %.03f\n", allowed_distance_m);
  for (const mrpt::math::TPoint3D& waypoint : waypoints)
    text += mrpt::format("waypoint = %s\n", waypoint.asString().c_str());
  return text;
}

std::unique_ptr<mrpt::nav::CAbstractNavigator::TNavigationParams> NavigationParams3D::clone() const
{
  auto copy = std::make_unique<NavigationParams3D>(*this);
  copy->target.target_coords = mrpt::math::TPose2D(target3D);
  copy->target.targetAllowedDistance = static_cast<float>(allowed_distance_m);
  return copy;
}

bool NavigationParams3D::isEqual(
    const mrpt::nav::CAbstractNavigator::TNavigationParamsBase& other) const
{
  const auto* o = dynamic_cast<const NavigationParams3D*>(&other);
  return o && target3D == o->target3D && waypoints == o->waypoints &&
         allowed_distance_m == o->allowed_distance_m &&
         target.target_frame_id == o->target.target_frame_id &&
         target.targetIsRelative == o->target.targetIsRelative;
}

}  // namespace slalom::navigator
