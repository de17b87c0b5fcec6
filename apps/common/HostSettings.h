// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "slalom/core/Fields.h"
#include "slalom/engine/EngineConfig.h"
#include "slalom/mrpt_io/ConfigBinder.h"
#include "slalom/mrpt_io/IniDocument.h"
#include "slalom/mrpt_io/ObservationDecoder.h"
#include "slalom/report/ReportConfig.h"

namespace slalom::app
{
/// Which navigator a program flies.
struct PluginConfig
{
  std::string plugin = "slalom-tracker";              ///< navigator module
  std::string navigator = "TrackerNavigatorFactory";  ///< class name of its factory
  std::string method = "slalom";                      ///< name of the method, for metrics.json

  template <class Self, class Visit>
  static void fields(Self& c, Visit&& v)
  {
    using core::Level;
    v("plugin", c.plugin, "navigator module: a name, or a path to the .so", Level::Expert);
    v("navigator", c.navigator, "class name of the navigator's factory", Level::Expert);
    v("method", c.method, "name of the method in metrics.json", Level::Expert);
  }
};

/// Settings of every program that hosts the navigator and reports what it does.
struct HostSettings
{
  mrpt_io::IniDocument document;  ///< what the following was read from
  engine::EngineConfig engine;
  mrpt_io::InputConfig input;
  report::ReportConfig report;
  std::string effective;  ///< INI text of the above, and of the program's own, with origins
};

/** Binds a host's sections.
 *  @param own (ConfigBinder&) -> void binds and ignores the program's own sections
 *  @throws mrpt_io::ConfigError */
template <class Own>
void bindHost(const mrpt_io::IniDocument& document, HostSettings& settings, Own&& own)
{
  settings.document = document;
  mrpt_io::ConfigBinder binder(document);
  engine::bind(binder, settings.engine);
  binder.bind("input", settings.input);
  binder.bind("report", settings.report);
  own(binder);
  binder.ignore("CAbstractNavigator");  // the plugin's
  binder.finish();
  engine::check(settings.engine);
  settings.effective = binder.effective();
}

}  // namespace slalom::app
