// SPDX-License-Identifier: BSD-3-Clause
#include "FlightPool.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

// glibc 2.36 forgets that this may be read as C++.
extern "C"
{
#include <sys/pidfd.h>
}

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "Program.h"
#include "slalom/report/AtomicFile.h"

namespace slalom::experiment
{
namespace
{
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int kSampleMs = 1000;

[[noreturn]] void failed(const char* what)
{
  throw std::runtime_error(std::string(what) + ": " + std::strerror(errno));
}

/// What the child does between fork and exec: async-signal-safe calls only.
[[noreturn]] void becomeFlight(const std::vector<char*>& argv, int log, pid_t parent)
{
  // A process group of its own: Ctrl-C at the terminal reaches it through us, and once only.
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(127);
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  const int nothing = open("/dev/null", O_RDONLY);
  if (nothing >= 0) dup2(nothing, STDIN_FILENO);
  execv(argv[0], argv.data());
  _exit(127);
}

/// One running slalom-fly.
class Process
{
 public:
  Process(const PlannedFlight& flight, const fs::path& program) : flight_(&flight)
  {
    fs::create_directories(flight.folder);
    fs::remove(flight.folder / "flight.json");
    std::vector<std::string> words{program.string(), "-q", "-w", "-o", flight.folder.string()};
    words.insert(words.end(), flight.arguments.begin(), flight.arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    memory_.open(flight.folder / "memory.csv");
    memory_ << "t_s,rss_mb\n";
    const fs::path log = flight.folder / "log.txt";
    const int log_fd = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (log_fd < 0) failed(log.c_str());
    const pid_t parent = getpid();
    pid_ = fork();
    if (pid_ == 0) becomeFlight(argv, log_fd, parent);
    close(log_fd);
    if (pid_ < 0) failed("fork");
    handle_ = pidfd_open(pid_, 0);
    if (handle_ < 0) failed("pidfd_open");
  }
  ~Process()
  {
    if (handle_ >= 0) close(handle_);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  [[nodiscard]] const PlannedFlight& flight() const { return *flight_; }
  [[nodiscard]] int handle() const { return handle_; }
  void askToFinish() const { kill(pid_, SIGTERM); }

  void sampleMemory()
  {
    std::ifstream status("/proc/" + std::to_string(pid_) + "/status");
    for (std::string line; std::getline(status, line);)
      if (line.starts_with("VmRSS:"))
        memory_ << seconds() << "," << std::stod(line.substr(6)) / 1024.0 << "\n";
  }

  /// Waits for its end and writes flight.json.
  FlightRecord finish()
  {
    int status = 0;
    while (waitpid(pid_, &status, 0) < 0 && errno == EINTR)
    {
    }
    memory_.close();
    FlightRecord record{
        flight_->key, WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), seconds()};
    const nlohmann::ordered_json json{{"key", record.key},
                                      {"code", record.code},
                                      {"wall_s", record.wall_s},
                                      {"arguments", flight_->arguments}};
    report::writeFileAtomically(flight_->folder / "flight.json", json.dump(2) + "\n");
    return record;
  }

 private:
  [[nodiscard]] double seconds() const
  {
    return std::chrono::duration<double>(Clock::now() - begin_).count();
  }

  const PlannedFlight* flight_;
  Clock::time_point begin_ = Clock::now();
  pid_t pid_ = -1;
  int handle_ = -1;
  std::ofstream memory_;
};

using Running = std::vector<std::unique_ptr<Process>>;

/// Sleeps until a process ends, a signal comes, or it is time for a sample. @return those that
/// ended
std::vector<bool> waitForNews(const Running& running)
{
  std::vector<pollfd> handles;
  for (const auto& process : running) handles.push_back({process->handle(), POLLIN, 0});
  const int ready = poll(handles.data(), handles.size(), kSampleMs);
  std::vector<bool> ended(running.size(), false);
  if (ready < 0 && errno != EINTR) failed("poll");
  for (std::size_t i = 0; i < running.size(); ++i)
    ended[i] = ready > 0 && (handles[i].revents & POLLIN) != 0;
  return ended;
}
}  // namespace

std::optional<FlightRecord> finishedFlight(const PlannedFlight& flight)
{
  std::ifstream file(flight.folder / "flight.json");
  if (!file) return std::nullopt;
  const auto json = nlohmann::json::parse(file, nullptr, false);
  if (!json.is_object()) return std::nullopt;
  FlightRecord record;
  try
  {
    record = {json.at("key"), json.at("code"), json.at("wall_s")};
  }
  catch (const nlohmann::json::exception&)
  {
    return std::nullopt;
  }
  constexpr std::array kByItself{app::kDone, app::kGoalNotReached, app::kLimitViolated,
                                 app::kDeadlineMissed};
  const bool ended = std::find(kByItself.begin(), kByItself.end(), record.code) != kByItself.end();
  if (record.key != flight.key || !ended || !fs::exists(flight.folder / "metrics.json"))
    return std::nullopt;
  return record;
}

bool flyAll(const std::vector<const PlannedFlight*>& flights, const fs::path& program, int jobs,
            const std::function<void(const PlannedFlight&, const FlightRecord&)>& ended)
{
  Running running;
  std::size_t next = 0;
  bool asked = false;
  while (!running.empty() || (next < flights.size() && !app::interrupted()))
  {
    while (running.size() < static_cast<std::size_t>(jobs) && next < flights.size() &&
           !app::interrupted())
      running.push_back(std::make_unique<Process>(*flights[next++], program));
    const std::vector<bool> over = waitForNews(running);
    if (app::interrupted() && !asked)
    {
      for (const auto& process : running) process->askToFinish();
      asked = true;
    }
    for (std::size_t i = running.size(); i-- > 0;)
    {
      if (!over[i])
      {
        running[i]->sampleMemory();
        continue;
      }
      const FlightRecord record = running[i]->finish();
      ended(running[i]->flight(), record);
      running.erase(running.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }
  return !app::interrupted();
}

}  // namespace slalom::experiment
