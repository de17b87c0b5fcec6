// SPDX-License-Identifier: BSD-3-Clause
#include "FlySettings.h"

#include <cstdio>

#include "RecordSettings.h"

namespace slalom::app
{
namespace
{
/// The simulated world's origin is the tracker's, unless somebody wants to see what comes of two.
void shareDatum(mrpt_io::IniDocument& document)
{
  if (document.find("input", "datum")) return;
  simulation::SensorSuite sensors;
  mrpt_io::ConfigBinder binder(document);
  binder.bind("gps", sensors.gps);
  const Eigen::Vector3d& d = sensors.gps.datum;
  char text[128];
  std::snprintf(text, sizeof text, "input.datum=%.9f,%.9f,%.4f", d.x(), d.y(), d.z());
  document.set(text);
}
}  // namespace

FlySettings readFlySettings(mrpt_io::IniDocument document)
{
  FlySettings settings;
  shareDatum(document);
  bindHost(document, settings,
           [&settings](mrpt_io::ConfigBinder& binder)
           {
             binder.bind("fly", settings.fly);
             binder.bind("airframe", settings.airframe);
             sensorSections(settings.sensors, [&binder](const char* name, auto& section)
                            { binder.bind(name, section); });
             binder.ignore("replay");
           });
  return settings;
}

std::string describeFlySettings()
{
  const FlySettings defaults;
  return mrpt_io::describe("fly", defaults.fly) + "\n" +
         mrpt_io::describe("airframe", defaults.airframe) + "\n";
}

}  // namespace slalom::app
