// SPDX-License-Identifier: BSD-3-Clause
#include "TrackerConfig.h"

#include <algorithm>
#include <cctype>
#include <numeric>
#include <vector>

#include "slalom/mrpt_io/ConfigBinder.h"

namespace slalom::navigator
{
namespace
{
constexpr std::size_t kSlip = 2;  // letters; a section name farther from ours is not ours

/// Letters to insert, remove or replace to get from `a` to `b`, ignoring case (Levenshtein).
std::size_t letterDistance(const std::string& a, const std::string& b)
{
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  for (std::size_t i = 0; i < a.size(); ++i)
  {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j)
    {
      const std::size_t replace = diagonal + (lower(a[i]) != lower(b[j]));
      diagonal = row[j + 1];
      row[j + 1] = std::min({replace, row[j + 1] + 1, row[j] + 1});
    }
  }
  return row.back();
}

}  // namespace

TrackerConfig readTrackerConfig(const mrpt_io::IniDocument& document)
{
  TrackerConfig config;
  mrpt_io::ConfigBinder binder(document);
  engine::bind(binder, config.engine);
  binder.bind("input", config.input);
  binder.bind("CAbstractNavigator", config.mrpt);
  config.effective = binder.effective();

  const auto ours = mrpt_io::IniDocument::parse(config.effective, "effective").sections();
  for (const std::string& section : document.sections())
    if (std::all_of(ours.begin(), ours.end(),
                    [&section](const std::string& known)
                    { return letterDistance(section, known) > kSlip; }))
      binder.ignore(section);
  binder.finish();
  engine::check(config.engine);
  return config;
}

}  // namespace slalom::navigator
