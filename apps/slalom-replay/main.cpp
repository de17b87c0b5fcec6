// SPDX-License-Identifier: BSD-3-Clause
// slalom-replay: a recorded flight through the whole engine, open loop, and the report of it.
#include "Options.h"
#include "Program.h"
#include "Replay.h"

int main(int argc, char** argv)
{
  slalom::replay::Options options;
  return slalom::app::runProgram(
      argc, argv, "slalom-replay",
      "Plays a recorded flight through the whole engine and writes pictures, numbers and "
      "trajectories. The world of a "
      "recording does not react: it shows what the tracker knew, wanted and would have commanded.",
      [&options](CLI::App& app)
      {
        options.common.addTo(app);
        app.add_option("--rawlog", options.rawlog, "recorded flight (.rawlog, plain or gzip)")
            ->required();
        app.add_option("--mission", options.mission,
                       "waypoint file (x,y,z per line); wins over [replay] mission");
        app.add_option("--start", options.start_s, "seconds of the recording to skip")
            ->check(slalom::app::number(0.0, 1e9));
        app.add_option("--duration", options.duration_s, "seconds of the recording to play")
            ->check(slalom::app::number(1e-3, 1e9));
        app.add_option("--rate", options.rate, "times real time; 0 = as fast as possible")
            ->check(slalom::app::number(0.0, 1e6));
        app.add_flag("--threaded", options.threaded,
                     "mapper and global planner in threads of their own");
        app.add_option("--verify", options.verify,
                       "folder of an earlier run: exit with 7 at the first difference");
        app.add_flag("--dry-run", options.dry_run, "check configuration and inputs, play nothing");
      },
      [&options] { return slalom::replay::run(options); });
}
