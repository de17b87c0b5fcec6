// SPDX-License-Identifier: BSD-3-Clause
#include "Config.h"

#include "slalom/mrpt_io/IniDocument.h"

namespace slalom::doctor
{
using mrpt_io::Finding;
using mrpt_io::Severity;

std::vector<Finding> examineConfig(const std::filesystem::path& file,
                                   const std::vector<std::string>& assignments)
{
  try
  {
    auto document = mrpt_io::IniDocument::read(file);
    for (const std::string& assignment : assignments) document.set(assignment);
    std::size_t keys = 0;
    for (const std::string& section : document.sections()) keys += document.keys(section).size();
    return {{Severity::Ok, file.string() + ": syntax is good; " +
                               std::to_string(document.sections().size()) + " sections, " +
                               std::to_string(keys) + " keys"}};
  }
  catch (const mrpt_io::ConfigError& e)
  {
    return {{Severity::Error, e.what()}};
  }
}

}  // namespace slalom::doctor
