// SPDX-License-Identifier: BSD-3-Clause
#include "slalom/report/OutputFolder.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace slalom::report
{
namespace fs = std::filesystem;
namespace
{
constexpr std::array<std::string_view, 17> kReportFiles = {
    "metrics.json",  "cycles.csv",   "commands.csv",  "timing.csv", "estimate.tum",
    "reference.tum", "refined.tum",  "setpoints.tum", "truth.tum",  "overview.png",
    "timing.png",    "tracking.png", "effective.ini", "map.bt",     "report.html",
    "flight.mp4",    "events.csv"};

std::string withoutPart(std::string name)
{
  constexpr std::string_view kPart = ".part";
  if (name.ends_with(kPart)) name.resize(name.size() - kPart.size());
  return name;
}

bool isReportFile(const fs::path& file)
{
  const std::string name = withoutPart(file.filename().string());
  return std::find(kReportFiles.begin(), kReportFiles.end(), name) != kReportFiles.end();
}

bool isCyclePicture(const fs::path& file)
{
  const std::string name = withoutPart(file.filename().string());
  if (!name.ends_with(".png") || name.size() < 10) return false;
  return std::all_of(name.begin(), name.end() - 4,
                     [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; });
}

std::vector<fs::path> filesOfEarlierReport(const fs::path& folder)
{
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && isReportFile(entry.path())) found.push_back(entry.path());
  if (fs::is_directory(folder / "cycles"))
    for (const auto& entry : fs::directory_iterator(folder / "cycles"))
      if (entry.is_regular_file() && isCyclePicture(entry.path())) found.push_back(entry.path());
  return found;
}
}  // namespace

void prepareOutputFolder(const fs::path& folder, bool overwrite)
{
  try
  {
    if (fs::exists(folder) && !fs::is_directory(folder))
      throw OutputError(folder, "is in the way: not a folder");
    fs::create_directories(folder);
    const std::vector<fs::path> earlier = filesOfEarlierReport(folder);
    if (!earlier.empty() && !overwrite)
      throw OutputError(folder, "holds an earlier report (" + earlier.front().filename().string() +
                                    "); it is kept unless overwriting is asked for");
    for (const fs::path& file : earlier) fs::remove(file);
  }
  catch (const fs::filesystem_error& error)
  {
    throw OutputError(folder, "cannot be made ready for output", error.code().value());
  }
  if (::access(folder.c_str(), W_OK) != 0) throw OutputError(folder, "is not writable", errno);
}

}  // namespace slalom::report
