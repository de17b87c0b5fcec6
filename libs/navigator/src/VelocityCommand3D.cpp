// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/core/exceptions.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <cmath>

#include "slalom/navigator/Navigator.h"

IMPLEMENTS_SERIALIZABLE(VelocityCommand3D, mrpt::kinematics::CVehicleVelCmd, slalom::navigator)

namespace slalom::navigator
{
namespace
{
struct Element
{
  const char* name;
  double VelocityCommand3D::*member;
};
constexpr Element kElements[] = {{"vx", &VelocityCommand3D::vx},
                                 {"vy", &VelocityCommand3D::vy},
                                 {"vz", &VelocityCommand3D::vz},
                                 {"wz", &VelocityCommand3D::wz}};

const Element& element(int index)
{
  ASSERTMSG_(index >= 0 && index < static_cast<int>(std::size(kElements)),
             "VelocityCommand3D has the elements 0 to 3");
  return kElements[index];
}

}  // namespace

std::string VelocityCommand3D::getVelCmdDescription(int index) const
{
  return element(index).name;
}
double VelocityCommand3D::getVelCmdElement(int index) const
{
  return this->*element(index).member;
}
void VelocityCommand3D::setVelCmdElement(int index, double value)
{
  this->*element(index).member = value;
}

bool VelocityCommand3D::isStopCmd() const
{
  return vx == 0.0 && vy == 0.0 && vz == 0.0 && wz == 0.0;
}
void VelocityCommand3D::setToStop()
{
  vx = vy = vz = wz = 0.0;
}

void VelocityCommand3D::cmdVel_scale(double scale)
{
  for (const Element& e : kElements) this->*e.member *= scale;
}

double VelocityCommand3D::cmdVel_limits(const mrpt::kinematics::CVehicleVelCmd& previous,
                                        double beta, const TVelCmdParams& params)
{
  const auto* before = dynamic_cast<const VelocityCommand3D*>(&previous);
  ASSERTMSG_(before, "the previous command is not a VelocityCommand3D");
  for (const Element& e : kElements)
    this->*e.member = beta * (this->*e.member) + (1.0 - beta) * (before->*e.member);

  double scale = 1.0;
  const auto limit = [&scale](double value, double bound)
  {
    if (bound > 0.0 && value > bound) scale = std::min(scale, bound / value);
  };
  limit(std::hypot(vx, vy, vz), params.robotMax_V_mps);
  limit(std::abs(wz), params.robotMax_W_radps);
  cmdVel_scale(scale);
  return scale;
}

uint8_t VelocityCommand3D::serializeGetVersion() const
{
  return 0;
}
void VelocityCommand3D::serializeTo(mrpt::serialization::CArchive& out) const
{
  out << vx << vy << vz << wz;
}
void VelocityCommand3D::serializeFrom(mrpt::serialization::CArchive& in, uint8_t serial_version)
{
  if (serial_version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(serial_version);
  in >> vx >> vy >> vz >> wz;
}

}  // namespace slalom::navigator
