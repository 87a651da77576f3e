// Degrees are for people and for files; everything else is in radians.
#pragma once

#include <numbers>

namespace ldp {

constexpr double kTurn = 2 * std::numbers::pi;  // rad
constexpr double kDegreesPerRadian = 180 / std::numbers::pi, kRadiansPerDegree = std::numbers::pi / 180;

}  // namespace ldp
