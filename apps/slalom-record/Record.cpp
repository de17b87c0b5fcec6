// SPDX-License-Identifier: BSD-3-Clause
#include "Record.h"

#include <cstdio>
#include <fstream>

#include "InputFiles.h"
#include "Progress.h"
#include "RecordSettings.h"
#include "slalom/mrpt_io/RawlogWriter.h"
#include "slalom/simulation/World.h"

namespace slalom::record
{
namespace
{
namespace fs = std::filesystem;
using simulation::ScriptedFlight;
using simulation::World;

app::RecordSettings readSettings(const Options& options)
{
  mrpt_io::IniDocument document = options.common.document();
  if (options.speed) document.set("flight.speed_mps=" + std::to_string(*options.speed));
  if (options.acceleration)
    document.set("flight.acceleration_mps2=" + std::to_string(*options.acceleration));
  return app::readRecordSettings(document);
}

/// The file appears under its name when it is complete.
void writeText(const fs::path& file, const std::string& text)
{
  const fs::path part = file.string() + ".part";
  std::ofstream stream(part, std::ios::binary);
  stream << text;
  stream.close();
  std::error_code error;
  if (stream) fs::rename(part, file, error);
  if (!stream || error)
  {
    fs::remove(part, error);
    throw app::UsageError(file.string() + " cannot be written");
  }
}

std::string truthTum(const ScriptedFlight& flight, double end, double rate)
{
  std::string text;
  char line[256];
  for (std::int64_t k = 0; static_cast<double>(k) / rate <= end; ++k)
  {
    const double t = static_cast<double>(k) / rate;
    const simulation::MotionSample m = flight.at(t);
    std::snprintf(line, sizeof(line), "%.6f %.6f %.6f %.6f %.9f %.9f %.9f %.9f\n", t, m.p_W.x(),
                  m.p_W.y(), m.p_W.z(), m.q_WB.x(), m.q_WB.y(), m.q_WB.z(), m.q_WB.w());
    text += line;
  }
  return text;
}

void refuseCollision(const World& world, const ScriptedFlight& flight, double radius)
{
  const auto contact = simulation::firstContact(world, flight, flight.duration(), radius);
  if (!contact) return;
  char text[256];
  std::snprintf(text, sizeof(text),
                "the path comes within %.3f m of the world at t = %.2f s, (%.2f, %.2f, %.2f); the "
                "vehicle's radius is %.2f m. --allow-collision flies it all the same",
                contact->distance, contact->t, contact->p_W.x(), contact->p_W.y(), contact->p_W.z(),
                radius);
  throw app::InputError(text);
}

void makeForest(const Options& options, const app::RecordSettings& settings)
{
  app::refuseExisting(options.make_forest, options.common.overwrite);
  try
  {
    writeText(options.make_forest,
              simulation::forestCsv(simulation::makeForest(settings.forest, options.seed)));
  }
  catch (const std::invalid_argument& error)
  {
    throw app::UsageError(error.what());
  }
}

/// @return log time of the last observation [s]
double writeRawlog(const Options& options, const app::RecordSettings& settings, const World& world,
                   const ScriptedFlight& flight)
{
  simulation::FlightRecorder recorder(world, flight, flight.duration(), settings.sensors,
                                      options.seed);
  mrpt_io::RawlogWriter writer(options.rawlog, settings.sensors.record.gzip_level);
  app::Progress progress("record", options.common.quiet);
  while (!app::interrupted())
  {
    const auto observation = recorder.next();
    if (!observation) break;
    writer.write(*observation);
    progress.show(recorder.time() / flight.duration());
  }
  writer.close();
  return recorder.time();
}

int record(const Options& options, const app::RecordSettings& settings)
{
  if (options.world.empty() || options.trajectory.empty() || options.rawlog.empty())
    throw app::UsageError("--world, --trajectory and --rawlog are needed");
  app::refuseExisting(options.rawlog, options.common.overwrite);
  const World world = app::loaded([&] { return World::load(options.world); });
  const ScriptedFlight flight =
      app::loaded([&] { return ScriptedFlight::load(options.trajectory, settings.flight); });
  if (!options.allow_collision) refuseCollision(world, flight, settings.vehicle.radius_m);

  const fs::path& out = options.common.out;
  if (!out.empty())
  {
    std::error_code error;
    fs::create_directories(out, error);
    if (error) throw app::UsageError(out.string() + " cannot be made: " + error.message());
    for (const char* name : {"truth.tum", "effective.ini"})
      app::refuseExisting(out / name, options.common.overwrite);
  }
  const double end = writeRawlog(options, settings, world, flight);
  if (!out.empty())
  {
    writeText(out / "truth.tum", truthTum(flight, end, settings.sensors.record.truth_rate_hz));
    writeText(out / "effective.ini", settings.effective);
  }
  return app::interrupted() ? app::kInterrupted : app::kDone;
}
}  // namespace

int run(const Options& options)
{
  const app::RecordSettings settings = readSettings(options);
  try
  {
    if (options.make_forest.empty()) return record(options, settings);
    makeForest(options, settings);
    return app::kDone;
  }
  catch (const app::InputError& error)
  {
    std::cerr << "slalom-record: " << error.what() << "\n";
    return app::kBadInput;
  }
}

}  // namespace slalom::record
