// SPDX-License-Identifier: BSD-3-Clause
#include "Verify.h"

#include <fstream>
#include <iterator>
#include <stdexcept>
#include <vector>

namespace slalom::replay
{
namespace
{
std::string slurp(const std::filesystem::path& file)
{
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Cells of a CSV row; quotes are kept, commas inside them do not separate.
std::vector<std::string> cells(const std::string& row)
{
  std::vector<std::string> parts(1);
  bool quoted = false;
  for (const char c : row)
  {
    if (c == '"') quoted = !quoted;
    if (c == ',' && !quoted)
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

Verdict differingCycle(std::size_t number, const std::string& header, const std::string& a,
                       const std::string& b)
{
  const std::vector<std::string> names = cells(header), left = cells(a), right = cells(b);
  std::string columns;
  for (std::size_t i = 0; i < names.size() && i < left.size() && i < right.size(); ++i)
    if (left[i] != right[i])
    {
      columns = names[i] + " was " + left[i] + ", is " + right[i];
      break;
    }
  return {false, "first differing cycle: " + std::to_string(number) +
                     " (t = " + (left.empty() ? "?" : left[0]) + " s): " + columns};
}

}  // namespace

Verdict compareRuns(const std::filesystem::path& earlier, const std::filesystem::path& now)
{
  std::ifstream a(earlier / "cycles.csv"), b(now / "cycles.csv");
  if (!a) throw std::runtime_error((earlier / "cycles.csv").string() + ": cannot be read");
  std::string header, header_now, row, row_now;
  std::getline(a, header);
  std::getline(b, header_now);
  if (header != header_now) return {false, "cycles.csv: the columns differ"};
  for (std::size_t number = 0;; ++number)
  {
    const bool more = bool(std::getline(a, row)), more_now = bool(std::getline(b, row_now));
    if (!more && !more_now) break;
    if (more != more_now)
      return {false, "cycles.csv: " + std::string(more ? "the earlier" : "this") +
                         " run has more than " + std::to_string(number) + " cycles"};
    if (row != row_now) return differingCycle(number, header, row, row_now);
  }
  for (const char* name :
       {"commands.csv", "estimate.tum", "reference.tum", "refined.tum", "setpoints.tum"})
    if (slurp(earlier / name) != slurp(now / name))
      return {false, std::string(name) + ": differs though every cycle is equal"};
  return {true, "identical to " + earlier.string()};
}

}  // namespace slalom::replay
