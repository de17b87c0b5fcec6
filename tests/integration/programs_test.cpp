// SPDX-License-Identifier: BSD-3-Clause
/** The programs as a user meets them: exit codes, one clear line on stderr, nothing lost. Runs the
 * built programs on a short recording that it makes itself, and on what Debian's mrpt-common
 * installs. */
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <vector>

#include "SharedData.h"

namespace
{
namespace fs = std::filesystem;

const std::string kBin = SLALOM_BIN_DIR;

struct Result
{
  int code = -1;
  std::string output;  ///< stdout and stderr
};

Result call(const std::string& command)
{
  Result result;
  FILE* pipe = popen(("exec 2>&1; " + command).c_str(), "r");
  char block[4096];
  while (const std::size_t n = std::fread(block, 1, sizeof block, pipe))
    result.output.append(block, n);
  const int status = pclose(pipe);
  result.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return result;
}

std::string slurp(const fs::path& file)
{
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void spill(const fs::path& file, const std::string& content)
{
  std::ofstream(file, std::ios::binary) << content;
}

/// A recording of some seconds past one tree, made once.
class Programs : public testing::Test
{
 protected:
  static void SetUpTestSuite()
  {
    folder_ = fs::temp_directory_path() / ("slalom_programs_" + std::to_string(getpid()));
    fs::create_directories(folder_);
    spill(folder_ / "world.csv", "x,y,radius,height\n4,0.1,0.3,6\n2,3,0.3,6\n7,-2,0.4,6\n");
    spill(folder_ / "flown.csv", "x,y,z\n0,0,1.5\n4,1.6,1.5\n8,0,1.5\n");
    spill(folder_ / "mission.csv", "x,y,z\n0,0,1.5\n8,0,1.5\n");
    const Result made =
        call(kBin + "/slalom-record -q --seed 3 --world " + path("world.csv") + " --trajectory " +
             path("flown.csv") + " --rawlog " + path("flight.rawlog") +
             " --set gps.datum=47.3667,8.55,450 --set gps.bias_sigma_m=0.05 --set gps.sigma_m=0.05 "
             "--set gps.sigma_up_m=0.1");
    ASSERT_EQ(made.code, 0) << made.output;
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  static std::string path(const std::string& name) { return (folder_ / name).string(); }

  static Result replay(const std::string& rawlog, const std::string& out,
                       const std::string& more = "")
  {
    return call(kBin + "/slalom-replay -q --set report.picture_interval_s=5 --rawlog '" + rawlog +
                "' -o '" + path(out) + "' " + more);
  }
  static Result replayFlight(const std::string& out, const std::string& more = "")
  {
    return replay(
        path("flight.rawlog"), out,
        "--mission " + path("mission.csv") + " --set input.datum=47.3667,8.55,450 " + more);
  }
  static nlohmann::json metrics(const std::string& out)
  {
    return nlohmann::json::parse(slurp(path(out + "/metrics.json")));
  }

  static fs::path folder_;
};
fs::path Programs::folder_;

TEST_F(Programs, ReplayReachesTheGoalAndWritesTheReport)
{
  const Result run = replayFlight("good");
  EXPECT_EQ(run.code, 0) << run.output;
  for (const char* name :
       {"metrics.json", "cycles.csv", "commands.csv", "estimate.tum", "reference.tum",
        "refined.tum", "setpoints.tum", "truth.tum", "overview.png", "timing.png", "tracking.png",
        "map.bt", "effective.ini", "cycles/000000.png"})
    EXPECT_TRUE(fs::exists(path(std::string("good/") + name))) << name;
  const auto m = metrics("good");
  EXPECT_EQ(m["result"]["name"], "GOAL_REACHED");
  EXPECT_GT(m["planning"]["refined_ok"], 10);
  EXPECT_LT(m["tracking"]["estimate_error_m"]["mean"], 1.0);
  EXPECT_GT(m["input"]["points_per_scan"]["median"], 1000);
}

TEST_F(Programs, ReplayIsBitIdenticalAndVerifies)
{
  ASSERT_EQ(replayFlight("first").code, 0);
  const Result same = replayFlight("second", "--verify " + path("first"));
  EXPECT_EQ(same.code, 0) << same.output;
  EXPECT_NE(same.output.find("verified"), std::string::npos) << same.output;
  for (const char* name : {"cycles.csv", "commands.csv", "estimate.tum", "refined.tum",
                           "setpoints.tum", "overview.png"})
    EXPECT_TRUE(slurp(path(std::string("first/") + name)) ==
                slurp(path(std::string("second/") + name)))
        << name;

  EXPECT_EQ(metrics("second")["verify"]["equal"], true);
  EXPECT_EQ(metrics("second")["result"]["code"], 0);
  EXPECT_FALSE(metrics("first").contains("verify"));

  const Result other =
      replayFlight("third", "--verify " + path("first") + " --set global_planner.clearance_m=0.9");
  EXPECT_EQ(other.code, 7) << other.output;
  EXPECT_NE(other.output.find("first differing cycle"), std::string::npos) << other.output;
  const auto m = metrics("third");
  EXPECT_EQ(m["result"]["code"], 7) << "as the program exits";
  EXPECT_EQ(m["success"], false);
  EXPECT_EQ(m["verify"]["equal"], false);
  EXPECT_NE(m["verify"]["message"].get<std::string>().find("first differing cycle"),
            std::string::npos);
}

TEST_F(Programs, VerifyNeedsAnotherRunToCompareWith)
{
  EXPECT_EQ(replayFlight("alone", "--verify " + path("nowhere")).code, 2);
  ASSERT_EQ(replayFlight("alone").code, 0);
  EXPECT_EQ(replayFlight("alone", "-w --verify " + path("alone")).code, 2);
}

TEST_F(Programs, ReplayMissesAnImpossibleDeadlineObjective)
{
  const Result run = replayFlight("slow", "--set replay.min_realtime_factor=1000");
  EXPECT_EQ(run.code, 6) << run.output;
  EXPECT_EQ(metrics("slow")["result"]["code"], 6);
}

TEST_F(Programs, ReplayRunsThreaded)
{
  // Paced, so that the threads keep up; the goal is the recording's, whatever the threads do.
  const Result run = replayFlight("threaded", "--threaded --rate 4");
  EXPECT_EQ(run.code, 0) << run.output;
  EXPECT_GT(metrics("threaded")["planning"]["replans"], 5);
}

TEST_F(Programs, ReplayNamesAMistakeInTheConfiguration)
{
  spill(path("bad.ini"), "[mapping]\nresolutoin_m = 0.2\n");
  Result run = replayFlight("bad", "-c " + path("bad.ini"));
  EXPECT_EQ(run.code, 2);
  EXPECT_NE(run.output.find("bad.ini:2"), std::string::npos) << run.output;
  EXPECT_NE(run.output.find("resolution_m"), std::string::npos) << "did you mean: " << run.output;

  run = replayFlight("bad", "--set vehicle.radius_m=nan");
  EXPECT_EQ(run.code, 2) << run.output;
  run = replayFlight("bad", "--set vehicle.radius_m=1.5x");
  EXPECT_EQ(run.code, 2) << run.output;
  run = replayFlight("bad", "--set vehicle.radius_m=0.9");
  EXPECT_EQ(run.code, 2) << "clearance below radius: " << run.output;
  EXPECT_NE(run.output.find("clearance_m"), std::string::npos) << run.output;
  EXPECT_EQ(replayFlight("bad", "-c /nonexistent.ini").code, 2);
  EXPECT_EQ(replayFlight("bad", "--no-such-option").code, 2);
  EXPECT_FALSE(fs::exists(path("bad"))) << "nothing is written before the configuration is good";
}

TEST_F(Programs, ReplayRefusesWhatIsNoRecording)
{
  spill(path("empty.rawlog"), "");
  spill(path("text.rawlog"), "this is a text file, not a recording\n");
  EXPECT_EQ(replay(path("empty.rawlog"), "none").code, 3);
  EXPECT_EQ(replay(path("text.rawlog"), "none").code, 3);
  const Result missing = replay("/nonexistent.rawlog", "none");
  EXPECT_EQ(missing.code, 3);
  EXPECT_NE(missing.output.find("/nonexistent.rawlog"), std::string::npos) << missing.output;
  EXPECT_EQ(std::count(missing.output.begin(), missing.output.end(), '\n'), 1) << missing.output;
}

TEST_F(Programs, ReplayKeepsWhatLiesBeforeTheDamage)
{
  const std::string whole = slurp(path("flight.rawlog"));
  spill(path("cut.rawlog"), whole.substr(0, whole.size() / 2));
  const Result run = replay(path("cut.rawlog"), "cut");
  EXPECT_EQ(run.code, 3) << run.output;
  ASSERT_TRUE(fs::exists(path("cut/metrics.json"))) << run.output;
  EXPECT_EQ(metrics("cut")["result"]["name"], "INPUT_DAMAGED");
  EXPECT_GT(metrics("cut")["duration_s"], 1.0);

  std::string flipped = whole;
  flipped[flipped.size() / 2] = char(flipped[flipped.size() / 2] ^ 0x10);
  spill(path("flip.rawlog"), flipped);
  EXPECT_EQ(replay(path("flip.rawlog"), "flip").code, 3);
}

TEST_F(Programs, ReplayDoesNotOverwriteUnasked)
{
  ASSERT_EQ(replayFlight("mine").code, 0);
  const std::string before = slurp(path("mine/metrics.json"));
  const Result again = replayFlight("mine");
  EXPECT_EQ(again.code, 2) << again.output;
  EXPECT_EQ(slurp(path("mine/metrics.json")), before);
  EXPECT_EQ(replayFlight("mine", "-w").code, 0);
}

TEST_F(Programs, ReplaySaysThatItCannotWrite)
{
  const Result run =
      call(kBin + "/slalom-replay -q --rawlog " + path("flight.rawlog") + " -o /proc/slalom");
  EXPECT_EQ(run.code, 2) << run.output;
  EXPECT_NE(run.output.find("/proc/slalom"), std::string::npos) << run.output;
}

// --foreground: without it, timeout signals twice, and a second Ctrl-C ends the program at once.
TEST_F(Programs, ReplayFinishesTheReportOnCtrlC)
{
  const Result run =
      call("timeout --foreground -s INT 2 " + kBin + "/slalom-replay -q --rate 1 --rawlog " +
           path("flight.rawlog") + " -o " + path("interrupted") + "; echo code $?");
  EXPECT_NE(run.output.find("INTERRUPTED"), std::string::npos) << run.output;
  EXPECT_TRUE(fs::exists(path("interrupted/overview.png"))) << run.output;
  EXPECT_EQ(metrics("interrupted")["result"]["code"], 130);
}

TEST_F(Programs, ReplayChecksWithoutPlaying)
{
  const Result run = replayFlight("dry", "--dry-run");
  EXPECT_EQ(run.code, 0) << run.output;
  EXPECT_FALSE(fs::exists(path("dry")));
}

/// A short flight past the trees in a hall, whose walls answer every ray.
class Fly : public Programs
{
 protected:
  static void SetUpTestSuite()
  {
    Programs::SetUpTestSuite();
    spill(path("hall.ini"),
          "[world]\nground = true\n"
          "[box.west]\nmin = -4,-6,0\nmax = -3.5,6,5\n[box.east]\nmin = 11,-6,0\nmax = 11.5,6,5\n"
          "[box.south]\nmin = -4,-6.5,0\nmax = 11.5,-6,5\n"
          "[box.north]\nmin = -4,6,0\nmax = 11.5,6.5,5\n"
          "[tree.a]\nx = 4\ny = 0.1\nradius = 0.3\nheight = 5\n"
          "[tree.b]\nx = 7\ny = -2\nradius = 0.4\nheight = 5\n");
  }
  static Result fly(const std::string& out, const std::string& more, int seed = 2,
                    const std::string& goal = "8,0,1.5")
  {
    return call(kBin + "/slalom-fly -q --vehicle-state truth --set report.picture_interval_s=5 " +
                "--world " + path("hall.ini") + " --start 0,0,1.5 --goal " + goal + " --seed " +
                std::to_string(seed) + " -o " + path(out) + " " + more);
  }
};

TEST_F(Fly, ReachesItsGoalAndIsRecordedForReplay)
{
  const Result run = fly("flown", "--record " + path("flown.rawlog"));
  ASSERT_EQ(run.code, 0) << run.output;
  for (const char* name :
       {"metrics.json", "cycles.csv", "commands.csv", "estimate.tum", "truth.tum", "overview.png",
        "timing.png", "tracking.png", "map.bt", "effective.ini", "events.csv", "cycles/000000.png"})
    EXPECT_TRUE(fs::exists(path(std::string("flown/") + name))) << name;
  const auto m = metrics("flown");
  EXPECT_EQ(m["result"]["name"], "GOAL_REACHED");
  EXPECT_EQ(m["success"], true);
  EXPECT_EQ(m["run"]["seed"], 2);
  EXPECT_EQ(m["flight"]["contacts"], 0);
  EXPECT_GE(m["flight"]["min_clearance_m"], 0.35);
  EXPECT_EQ(m["clearance"]["min_true_m"], m["flight"]["min_clearance_m"]);
  EXPECT_NEAR(m["flight"]["straight_m"], 8.0, 1e-9);
  EXPECT_GT(m["flight"]["length_m"], 7.0);
  EXPECT_LT(m["flight"]["length_m"], 14.0);
  EXPECT_LE(m["goal_error_m"], 0.6);
  EXPECT_GT(m["flight"]["realtime_factor"], 0.0);
  const std::string events = slurp(path("flown/events.csv"));
  EXPECT_EQ(events.substr(0, 15), "t,event,detail\n");
  EXPECT_NE(events.find("GOAL_REACHED"), std::string::npos) << events;

  const Result played = replay(path("flown.rawlog"), "flown_replayed",
                               "--mission " + path("mission.csv") + " --set state.source=truth");
  EXPECT_EQ(played.code, 0) << played.output;
  EXPECT_EQ(metrics("flown_replayed")["result"]["name"], "GOAL_REACHED");
}

TEST_F(Fly, TheSameSeedIsTheSameFlight)
{
  const std::string limit = "--time-limit 3 ";
  EXPECT_EQ(fly("seed_a", limit).code, 4);
  EXPECT_EQ(fly("seed_b", limit).code, 4);
  EXPECT_EQ(fly("seed_c", limit, 3).code, 4);
  EXPECT_EQ(metrics("seed_a")["result"]["name"], "TIMEOUT");
  const auto hash = [](const char* out) { return metrics(out)["run"]["decision_hash"]; };
  EXPECT_EQ(hash("seed_a"), hash("seed_b"));
  EXPECT_NE(hash("seed_a"), hash("seed_c"));
  for (const char* name : {"cycles.csv", "commands.csv", "truth.tum", "events.csv"})
    EXPECT_TRUE(slurp(path(std::string("seed_a/") + name)) ==
                slurp(path(std::string("seed_b/") + name)))
        << name;
}

TEST_F(Fly, OfANavigatorThatSeesNothingEndsInTheTree)
{
  const std::string straight =
      "--set fly.navigator=StraightNavigatorFactory "
      "--set fly.plugin=" SLALOM_STRAIGHT_MODULE " ";
  const Result run = fly("blind", straight);
  EXPECT_EQ(run.code, 5) << run.output;
  const auto m = metrics("blind");
  EXPECT_EQ(m["result"]["name"], "COLLISION");
  EXPECT_EQ(m["success"], false);
  EXPECT_EQ(m["flight"]["contacts"], 1);
  EXPECT_LT(m["flight"]["min_clearance_m"], 0.35);

  // The way beside the trees is free, and the same navigator arrives there.
  const Result free = fly("beside", straight, 2, "0,4,1.5");
  EXPECT_EQ(free.code, 0) << free.output;
  EXPECT_EQ(metrics("beside")["result"]["name"], "GOAL_REACHED");
}

TEST_F(Fly, NamesWhatIsWrong)
{
  const std::string bin = kBin + "/slalom-fly -q -o " + path("refused") + " ";
  const std::string world = "--world " + path("hall.ini") + " ";
  spill(path("far.csv"), "x,y,z\n0,0,1\n-1e7,0,1\n");
  spill(path("bad_world.csv"), "x,y,radius,height\n1,2,three,4\n");
  const std::tuple<std::string, int, const char*> bad[] = {
      {world + "--start 0,0,1.5", 2, "--goal"},
      {"--start 0,0,1 --goal 8,0,1", 2, "--world"},
      {world + "--start 0,0 --goal 8,0,1", 2, "--start 0,0"},
      {world + "--start 0,0,1x --goal 8,0,1", 2, "--start"},
      {world + "--start 0,0,1 --goal 8,nan,1", 2, "--goal 8,nan,1"},
      {world + "--start 0,0,1 --goal 8,0,1 --set airframe.velocity_lga_s=1", 2, "velocity_lag_s"},
      {world + "--start 0,0,1 --goal 8,0,1 --set fly.time_limit_s=-1", 2, "time_limit_s"},
      {world + "--start 0,0,1 --waypoints /nowhere.csv", 2, "/nowhere.csv"},
      {world + "--start 0,0,1 --goal 30000,0,1", 2, "mission.max_length_m = 20000"},
      {world + "--start 0,0,1 --goal 1e30,0,1", 2, "1e+30"},
      {world + "--start 0,1e9,1 --goal 0,1e9,1", 2, "1000000"},
      {world + "--start 0,0,1 --waypoints " + path("far.csv"), 2, "far.csv"},
      {"--world /nowhere.csv --start 0,0,1 --goal 8,0,1", 3, "/nowhere.csv"},
      {"--world " + path("bad_world.csv") + " --start 0,0,1 --goal 8,0,1", 3, "bad_world.csv:2"},
      {world + "--start 4,0.2,1.5 --goal 8,0,1", 3, "start"},
      {world + "--start 4,0.7,1.5 --goal 8,0,1", 3, "radius is 0.35"}};
  for (const auto& [arguments, code, says] : bad)
  {
    SCOPED_TRACE(arguments);
    const Result run = call(bin + arguments);
    EXPECT_EQ(run.code, code) << run.output;
    EXPECT_NE(run.output.find(says), std::string::npos) << run.output;
    EXPECT_FALSE(fs::exists(path("refused")));
  }
}

/// Every number on a command line is checked: name, value and bounds in one line, exit code 2.
TEST_F(Programs, NameANumericOptionThatIsNotWhatItMustBe)
{
  const std::string flight = "--world " + path("world.csv") + " -o " + path("numbers");
  const std::string fly = "/slalom-fly " + flight + " --start 0,0,1 --goal 8,0,1 ",
                    play = "/slalom-replay --rawlog " + path("flight.rawlog") + " -o " +
                           path("numbers") + " ",
                    record = "/slalom-record " + flight + " --trajectory " + path("flown.csv") +
                             " --rawlog " + path("numbers.rawlog") + " ",
                    import = "/slalom-import --pcap " + path("none.pcap") + " --rawlog " +
                             path("numbers.rawlog") + " ";
  const std::vector<std::string> numbers{"nan", "inf", "-inf", "1e400", "x", "1x", ""};
  const std::vector<std::tuple<std::string, std::string, std::vector<std::string>>> options{
      {fly, "--seed", {"-1", "1.5", "18446744073709551616", "0x1"}},
      {fly, "--time-limit", {"-1", "0", "1e9"}},
      {play, "--start", {"-1", "1e12"}},
      {play, "--duration", {"-1", "0"}},
      {play, "--rate", {"-1"}},
      {record, "--seed", {"-1", "1.5"}},
      {record, "--speed", {"-1", "0", "1e9"}},
      {record, "--acceleration", {"-1", "0", "1e9"}},
      {import, "--mount", {"1e9,0,0"}}};
  for (const auto& [program, option, own] : options)
  {
    std::vector<std::string> values = numbers;
    values.insert(values.end(), own.begin(), own.end());
    for (const std::string& value : values)
    {
      SCOPED_TRACE(program.substr(1, 13) + option + "=" + value);
      const Result run = call(kBin + program + option + "='" + value + "'");
      EXPECT_EQ(run.code, 2) << run.output;
      EXPECT_NE(run.output.find(option), std::string::npos) << run.output;
      EXPECT_FALSE(fs::exists(path("numbers")));
    }
  }
  const Result run = call(kBin + fly + "--seed -1");
  EXPECT_EQ(run.code, 2) << run.output;
  EXPECT_NE(run.output.find("--seed: -1: a whole number from 0 to"), std::string::npos)
      << run.output;
}

TEST_F(Programs, DoctorFindsWhatTheReplayRefuses)
{
  const auto examine = [&](const std::string& more)
  { return call(kBin + "/slalom-doctor " + more); };
  spill(path("good.ini"), "[vehicle]\nradius_m = 0.3\n[replay]\nmission = mission.csv\n");
  const Result good = examine("-c " + path("good.ini"));
  EXPECT_EQ(good.code, 0) << good.output;
  EXPECT_NE(good.output.find("2 waypoints"), std::string::npos) << good.output;

  const std::pair<const char*, const char*> bad[] = {
      {"[mapping]\nresolutoin_m = 0.2\n", "resolution_m"},
      {"[mappping]\nresolution_m = 0.2\n", "[mappping]"},
      {"[vehicle]\nradius_m = nan\n", "bad.ini:2"},
      {"[vehicle]\nradius_m = 1000\n", "bad.ini:2"},
      {"[report]\npicture_size_px = 1\n", "bad.ini:2"},
      {"[vehicle]\nradius_m = 0.9\n", "clearance_m"},
      {"[replay]\nmission = nowhere.csv\n", "nowhere.csv"}};
  for (const auto& [text, says] : bad)
  {
    SCOPED_TRACE(text);
    spill(path("bad.ini"), text);
    const Result run = examine("-c " + path("bad.ini"));
    EXPECT_EQ(run.code, 2) << run.output;
    EXPECT_NE(run.output.find(says), std::string::npos) << run.output;
    EXPECT_EQ(replayFlight("bad", "--dry-run -c " + path("bad.ini")).code,
              std::string(says) == "nowhere.csv" ? 0 : 2)
        << "only a mission file may be replaced, by --mission";
  }
  spill(path("bad.ini"), "[airframe]\nwind_mps = 1,2\n");
  EXPECT_EQ(examine("-c " + path("bad.ini")).code, 2) << "sections of slalom-fly are examined too";
}

TEST_F(Programs, ConfigurationReferenceIsUpToDate)
{
  const Result run = call(kBin + "/slalom-doctor --config-reference");
  EXPECT_EQ(run.code, 0);
  EXPECT_TRUE(run.output == slurp(fs::path(SLALOM_SOURCE_DIR) / "docs/configuration.md"))
      << "run: slalom-doctor --config-reference > docs/configuration.md";
}

TEST_F(Programs, EveryProgramHasHelpAndVersion)
{
  for (const char* program :
       {"slalom-replay", "slalom-fly", "slalom-record", "slalom-import", "slalom-doctor"})
  {
    EXPECT_EQ(call(kBin + "/" + program + " --help").code, 0) << program;
    EXPECT_EQ(call(kBin + "/" + program + " --version").code, 0) << program;
    EXPECT_EQ(call(kBin + "/" + program + " --nonsense").code, 2) << program;
  }
}

/// The recordings of Debian's mrpt-common: what each must be answered with.
/// A flight of an experiment as it is shipped: what it has to show, and how it ends.
struct Shipped
{
  std::string name;
  int code;
  std::string ends;
  double within_m;  ///< mean error of the estimate, against the truth in the recording
};

class ShippedFlight : public testing::TestWithParam<Shipped>
{
};

TEST_P(ShippedFlight, IsReplayed)
{
  const Shipped& shipped = GetParam();
  const fs::path folder = fs::path(SLALOM_SOURCE_DIR) / "datasets" / shipped.name;
  const fs::path out =
      fs::temp_directory_path() / ("slalom_" + shipped.name + "_" + std::to_string(getpid()));
  const Result run = call(kBin + "/slalom-replay -q --set report.picture_interval_s=2 --rawlog " +
                          (folder / "flight.rawlog").string() + " -c " +
                          (folder / "flight.ini").string() + " -o " + out.string());
  EXPECT_EQ(run.code, shipped.code) << run.output;
  const auto m = nlohmann::json::parse(slurp(out / "metrics.json"));
  EXPECT_EQ(m["result"]["name"], shipped.ends);
  EXPECT_LT(m["tracking"]["estimate_error_m"]["mean"], shipped.within_m);
  EXPECT_GT(m["length_m"], 2.0) << "it flies";
  EXPECT_GT(m["planning"]["replans"], 10);
  for (const char* name : {"overview.png", "timing.png", "tracking.png", "cycles/000000.png"})
    EXPECT_GT(fs::file_size(out / name), 5000u) << name;
  // As long as the truth is, and never far from it.
  std::ifstream truth(out / "truth.tum"), estimate(out / "estimate.tum");
  EXPECT_TRUE(std::string(std::istreambuf_iterator<char>(truth), {}).size() > 1000);
  EXPECT_TRUE(std::string(std::istreambuf_iterator<char>(estimate), {}).size() > 1000);
  EXPECT_LE(fs::file_size(folder / "flight.rawlog"), 3u << 20);
  fs::remove_all(out);
}
INSTANTIATE_TEST_SUITE_P(Datasets, ShippedFlight,
                         testing::Values(Shipped{"e1_circle", 0, "GOAL_REACHED", 0.3},
                                         Shipped{"e2_blocked_goal", 4, "GOAL_BLOCKED", 0.3},
                                         Shipped{"e3_cluttered", 0, "GOAL_REACHED", 0.3},
                                         Shipped{"e4_forest", 0, "GOAL_REACHED", 0.3}),
                         [](const auto& flight) { return flight.param.name; });

struct Installed
{
  const char* file;
  int code;
  const char* says;
};

class InstalledRecording : public Programs, public testing::WithParamInterface<Installed>
{
};

TEST_P(InstalledRecording, IsAnsweredSensibly)
{
  const fs::path file = fs::path("/usr/share/mrpt/datasets") / GetParam().file;
  if (!fs::exists(file)) GTEST_SKIP() << file << " is not installed (package mrpt-common)";
  const Result run = replay(file.string(), std::string("installed_") + GetParam().file, "-w");
  EXPECT_EQ(run.code, GetParam().code) << run.output;
  EXPECT_NE(run.output.find(GetParam().says), std::string::npos) << run.output;
}

INSTANTIATE_TEST_SUITE_P(
    Mrpt, InstalledRecording,
    testing::Values(Installed{"test_velodyne_VLP16.rawlog", 0, "MAPPED"},
                    Installed{"rot_scan_velodyne.rawlog", 0, "MAPPED"},
                    Installed{"rot_scan_2d.rawlog", 3, "2-D"},
                    Installed{"tests_rgbd.rawlog", 0, "MAPPED"},
                    Installed{"test_rtk_path.rawlog", 0, "ESTIMATED"},
                    Installed{"2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog", 3,
                              "2-D laser log"},
                    Installed{"localization_demo.rawlog", 3, "2-D laser log"},
                    Installed{"kf-slam_6D_demo.rawlog", 3, "not a flight"},
                    Installed{"RO-SLAM_demo.rawlog", 3, "not a flight"}),
    [](const auto& recording)
    {
      std::string name = recording.param.file;
      for (char& c : name)
        if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
      return name;
    });

/// The evaluation recordings, where they are present.
class SharedRecording : public Programs,
                        public testing::WithParamInterface<std::pair<const char*, const char*>>
{
};

TEST_P(SharedRecording, IsPlayed)
{
  const fs::path file = slalom::test::sharedData(fs::path("real") / GetParam().first);
  if (!fs::exists(file)) GTEST_SKIP() << file << " is not here";
  const Result run = replay(file.string(), "shared", "-w --set report.picture_interval_s=0");
  EXPECT_EQ(run.code, 0) << run.output;
  EXPECT_NE(run.output.find(GetParam().second), std::string::npos) << run.output;
}

INSTANTIATE_TEST_SUITE_P(
    Real, SharedRecording,
    testing::Values(std::pair{"vlp16_einride_static/vlp16_13rev.rawlog", "MAPPED"},
                    std::pair{"vlp16_mrpt_pcap_gps/vlp16_gps.rawlog", "MAPPED"},
                    std::pair{"vlp16_mrpt_pcap_gps/test_velodyne_VLP16.rawlog", "MAPPED"},
                    std::pair{"rtk_gps_mrpt/test_rtk_path.rawlog", "ESTIMATED"},
                    std::pair{"inav_3dr_quad/flight.rawlog", "ESTIMATED"},
                    std::pair{"px4_indoor_offboard/flight.rawlog", "ESTIMATED"},
                    std::pair{"px4_outdoor_manual_fast/flight.rawlog", "ESTIMATED"},
                    std::pair{"px4_outdoor_mission_motorfail/flight.rawlog", "ESTIMATED"}));

}  // namespace
