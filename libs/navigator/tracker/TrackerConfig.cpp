// SPDX-License-Identifier: BSD-3-Clause
#include "TrackerConfig.h"

#include <algorithm>
#include <vector>

#include "slalom/mrpt_io/ConfigBinder.h"
#include "slalom/mrpt_io/Spelling.h"

namespace slalom::navigator
{
namespace
{
constexpr std::size_t kSlip = 2;  // slips; a section name farther from ours is not ours
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
                    { return mrpt_io::editDistance(section, known) > kSlip; }))
      binder.ignore(section);
  binder.finish();
  engine::check(config.engine);
  return config;
}

}  // namespace slalom::navigator
