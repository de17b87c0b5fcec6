// SPDX-License-Identifier: BSD-3-Clause
// slalom-experiment: many flights of slalom-fly from one INI file, their table and the verdict.
#include "Run.h"

int main(int argc, char** argv)
{
  slalom::experiment::Options options;
  return slalom::app::runProgram(
      argc, argv, "slalom-experiment",
      "Flies an experiment: every flight that its INI file asks for, one process of slalom-fly "
      "each, "
      "and writes table.md, table.csv and comparison.md with a verdict for each acceptance number. "
      "A flight that is already there with the same settings and the same build is not flown "
      "again.\n"
      "Exit codes: 0 all acceptance numbers met, nothing missing; 4 one is not met or not "
      "measured; "
      "2 usage or configuration; 130 interrupted (the tables hold what was flown); 1 internal "
      "error",
      [&options](CLI::App& app)
      {
        app.add_option("experiment", options.experiment,
                       "e1, e2, e3, e4, gallery, soak, or an INI file")
            ->required();
        options.common.addTo(app);
        app.add_option("--jobs", options.jobs, "flights at a time")->check(CLI::Range(1, 256));
        app.add_option("--data", options.data,
                       "folder of worlds to fly instead of the generated ones, where the "
                       "experiment names some (e4: dev_00.csv ... and meta.csv)");
        app.add_option("--only", options.only, "groups to fly, separated by commas");
        app.add_flag("--dry-run", options.dry_run, "list the flights and stop");
      },
      [&options] { return slalom::experiment::run(options); });
}
