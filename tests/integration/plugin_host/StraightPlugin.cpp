// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/core/initializer.h>

#include "StraightNavigator.h"

namespace slalom::test
{
class StraightNavigatorFactory : public navigator::NavigatorFactory
{
  DEFINE_MRPT_OBJECT(StraightNavigatorFactory, slalom::test)

 public:
  std::unique_ptr<navigator::AbstractNavigator3D> create(
      navigator::RobotInterface3D& robot) const override
  {
    return std::make_unique<StraightNavigator>(robot);
  }
};
}  // namespace slalom::test

IMPLEMENTS_MRPT_OBJECT(StraightNavigatorFactory, slalom::navigator::NavigatorFactory, slalom::test)

MRPT_INITIALIZER(registerAllClasses_slalom_test_straight)
{
  mrpt::rtti::registerClass(CLASS_ID(slalom::test::StraightNavigatorFactory));
}
