// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "SyntheticFlight.h"
#include "slalom/report/FlightReport.h"
#include "slalom/report/OutputFolder.h"
TEST(Preview, Draw)
{
  using namespace slalom;
  test::SyntheticFlight flight;
  report::prepareOutputFolder("/tmp/report_preview", true);
  report::RunInfo info;
  info.title = "forest_01.rawlog";
  info.max_speed_mps = 1.5;
  info.local_deadline_s = 0.02;
  info.global_deadline_s = 0.1;
  info.map_deadline_s = 0.05;
  report::FlightReport r({}, "/tmp/report_preview", info);
  for (int i = 0; i < flight.cycles(); ++i)
  {
    r.addTruth(flight.truth(0.1 * i - 0.02));
    r.add(flight.cycle(i));
  }
  report::RunSummary s;
  s.result = {0, "GOAL_REACHED", "goal reached within 0.3 m", true};
  r.finish(s);
}
