// SPDX-License-Identifier: BSD-3-Clause
#include <dlfcn.h>
#include <mrpt/core/initializer.h>
#include <mrpt/system/os.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <stdexcept>

#include "slalom/navigator/Navigator.h"

IMPLEMENTS_VIRTUAL_MRPT_OBJECT(NavigatorFactory, mrpt::rtti::CObject, slalom::navigator)

MRPT_INITIALIZER(registerAllClasses_slalom_navigator)
{
  mrpt::rtti::registerClass(CLASS_ID(slalom::navigator::VelocityCommand3D));
  mrpt::rtti::registerClass(CLASS_ID(slalom::navigator::NavigatorFactory));
}

namespace slalom::navigator
{
namespace
{
namespace fs = std::filesystem;

std::string joined(const std::vector<std::string>& words)
{
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

// dlopen() searches its own places for a name without '/', and MRPT hands it the name as it is.
std::string resolve(const std::string& module)
{
  std::vector<std::string> tried;
  const auto exists = [&tried](const fs::path& file)
  {
    tried.push_back(file.string());
    std::error_code ignored;
    return fs::is_regular_file(file, ignored);
  };
  if (module.find('/') != std::string::npos)
  {
    if (exists(module)) return module;
  }
  else
  {
    for (const std::string& directory : NavigatorFactory::pluginDirectories())
      for (const std::string& name : {module, module + ".so"})
        if (const fs::path file = fs::path(directory) / name; exists(file)) return file.string();
  }
  throw std::runtime_error("navigator module '" + module + "' not found; tried " + joined(tried));
}

}  // namespace

std::vector<std::string> NavigatorFactory::pluginDirectories()
{
  std::vector<std::string> directories;
  if (const char* path = std::getenv("SLALOM_PLUGIN_PATH"))
  {
    std::istringstream parts(path);
    for (std::string part; std::getline(parts, part, ':');)
      if (!part.empty()) directories.push_back(part);
  }
  static const char anchor = 0;
  Dl_info here{};
  if (dladdr(&anchor, &here) != 0 && here.dli_fname)
  {
    const fs::path beside = fs::absolute(here.dli_fname).parent_path();
    directories.push_back(beside.string());
    directories.push_back((beside / "slalom").string());
  }
  return directories;
}

void NavigatorFactory::loadModule(const std::string& module)
{
  const std::string file = resolve(module);
  std::string complaint;
  if (!mrpt::system::loadPluginModule(file, complaint))
    throw std::runtime_error("navigator module '" + file + "' cannot be loaded: " + complaint);
}

std::vector<std::string> NavigatorFactory::availableNames()
{
  std::vector<std::string> names;
  for (const auto* id : mrpt::rtti::getAllRegisteredClassesChildrenOf(CLASS_ID(NavigatorFactory)))
    if (id->ptrCreateObject) names.emplace_back(id->className);
  std::sort(names.begin(), names.end());
  return names;
}

NavigatorFactory::Ptr NavigatorFactory::named(const std::string& class_name)
{
  const auto* id = mrpt::rtti::findRegisteredClass(class_name);
  const std::string available = joined(availableNames());
  const std::string hint = available.empty() ? "; none is registered, is the module loaded?"
                                             : "; available: " + available;
  if (!id) throw std::runtime_error("unknown navigator class '" + class_name + "'" + hint);
  if (!id->ptrCreateObject || !id->derivedFrom(CLASS_ID(NavigatorFactory)))
    throw std::runtime_error("class '" + class_name + "' is not a navigator factory" + hint);
  return std::dynamic_pointer_cast<NavigatorFactory>(id->createObject());
}

}  // namespace slalom::navigator
