// SPDX-License-Identifier: BSD-3-Clause
/** One look for each thing, in every picture and every legend. */
#pragma once

#include "Canvas.h"

namespace slalom::report::detail::style
{
inline constexpr Colour kInk{30, 30, 30}, kFaint{110, 110, 110}, kPanel{250, 250, 250};
inline constexpr Colour kGood{24, 128, 56}, kWarn{196, 108, 0}, kBad{196, 24, 24};

inline const Stroke kReference{kWhite, 1, kInk};
inline const Stroke kRefined{{214, 20, 120}, 2, kWhite, 9.0, 6.0};
inline const Stroke kCommitted{{214, 20, 120}, 4, kWhite};
/// In the overview: a band that stays visible below the flown path.
inline const Stroke kRefinedBand{{240, 120, 185}, 13};
inline const Stroke kOccupiedSegment{{228, 26, 28}, 8};
inline const Stroke kGuide{{250, 220, 40}, 2, Colour{90, 70, 0}, 9.0, 6.0};
inline const Stroke kPushingPath{{60, 210, 60}, 2, Colour{0, 70, 10}};
inline const Stroke kDirection{{255, 240, 120}, 1, Colour{60, 50, 0}};
inline const Stroke kHorizon{{255, 127, 14}, 2, Colour{80, 36, 0}};
inline const Stroke kTrail{{70, 50, 40}, 2, Colour{235, 225, 215}};
inline constexpr Colour kPolyhedron{175, 85, 235};
inline constexpr double kPolyhedronOpacity = 0.2;
inline const Stroke kPolyhedronEdge{kPolyhedron, 2};
inline const Stroke kHardContour{{200, 30, 30}, 1};
inline const Stroke kWantedContour{{255, 255, 255}, 1};
inline constexpr Colour kMover{200, 60, 160};
inline constexpr double kMoverOpacity = 0.55;
inline const Stroke kMoverMotion{kMover, 2, kWhite};
inline constexpr Colour kVehicle{255, 255, 255};
inline constexpr Colour kGoal{24, 150, 60}, kStart{30, 100, 220};
inline const Stroke kTruth{{0, 0, 0}, 1, {}, 5.0, 4.0};
}  // namespace slalom::report::detail::style
