// SPDX-License-Identifier: BSD-3-Clause
#include <iostream>

#include "slalom/core/CycleRecord.h"
#include "slalom/navigator/Navigator.h"

int main()
{
  using slalom::navigator::NavigatorFactory;
  NavigatorFactory::loadModule("slalom-tracker");
  for (const std::string& name : NavigatorFactory::availableNames()) std::cout << name << "\n";
  return NavigatorFactory::named("TrackerNavigatorFactory") && slalom::core::CycleRecord().t == 0.0
             ? 0
             : 1;
}
