// SPDX-License-Identifier: BSD-3-Clause
// slalom-record: a scripted flight through a world, written as a rawlog with raw sensor data.
#include "Record.h"

int main(int argc, char** argv)
{
  slalom::record::Options options;
  return slalom::app::runProgram(
      argc, argv, "slalom-record",
      "Flies a script through a world and records what the sensors say: raw Velodyne packets, GPS, "
      "IMU, velocity and ground truth. The same seed gives the same bytes.",
      [&options](CLI::App& app)
      {
        options.common.addTo(app);
        app.add_option("--world", options.world,
                       "octree (.bt, .ot), trees (.csv: x,y,radius,height) or shapes (.ini)");
        app.add_option("--trajectory", options.trajectory,
                       "waypoints (csv: x,y,z[,yaw_rad]) or poses (TUM)");
        app.add_option("--seed", options.seed, "of all noise")
            ->check(slalom::app::wholeNumber(0.0));
        app.add_option("--rawlog", options.rawlog, "recording to write");
        app.add_option("--speed", options.speed, "m/s per axis; wins over [flight] speed_mps")
            ->check(slalom::app::number(0.05, 30.0));
        app.add_option("--acceleration", options.acceleration,
                       "m/s^2 per axis; wins over [flight] acceleration_mps2")
            ->check(slalom::app::number(0.05, 9.0));
        app.add_flag("--allow-collision", options.allow_collision,
                     "fly even where the path touches the world");
        app.add_option("--make-forest", options.make_forest,
                       "write a random forest ([forest], --seed) to this csv and stop");
      },
      [&options] { return slalom::record::run(options); });
}
