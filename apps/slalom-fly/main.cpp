// SPDX-License-Identifier: BSD-3-Clause
// slalom-fly: the navigator plugin in closed loop with a simulated vehicle in a world.
#include "Fly.h"

int main(int argc, char** argv)
{
  slalom::fly::Options options;
  return slalom::app::runProgram(
      argc, argv, "slalom-fly",
      "Flies the navigator plugin in a simulated world, from start to goal, and writes pictures, "
      "numbers and trajectories. The tracker sees the world only through its sensors and moves the "
      "vehicle only by velocity commands; whether it touched anything is judged from the world's "
      "geometry. The same seed gives the same flight.\n"
      "Exit codes: 0 goal reached without contact; 2 usage or configuration; 3 world or start "
      "unusable; 4 goal not reached (GOAL_BLOCKED, UNREACHABLE, SENSOR_LOST, FAILED or "
      "TIMEOUT in "
      "metrics.json); "
      "5 collision; 6 slower than [fly] min_realtime_factor; 130 interrupted; 1 internal error",
      [&options](CLI::App& app)
      {
        options.common.addTo(app);
        app.add_option("--world", options.world,
                       "octree (.bt, .ot), trees (.csv: x,y,radius,height) or shapes (.ini)");
        app.add_option("--start", options.start, "x,y,z of the vehicle at rest");
        app.add_option("--goal", options.goal, "x,y,z to reach");
        app.add_option(
            "--waypoints", options.waypoints,
            "waypoints on the way (x,y,z per line); without --goal the last is the goal");
        app.add_option("--seed", options.seed, "of all noise")
            ->check(slalom::app::wholeNumber(0.0));
        app.add_option("--vehicle-state", options.vehicle_state,
                       "truth, or the estimate from the sensors; wins over [state] source")
            ->check(CLI::IsMember({"truth", "estimate"}));
        app.add_option("--time-limit,--duration", options.time_limit_s,
                       "simulated seconds; wins over [fly] time_limit_s")
            ->check(slalom::app::number(0.1, 1e5));
        app.add_option("--record", options.record, "rawlog of what the sensors said");
      },
      [&options] { return slalom::fly::run(options); });
}
