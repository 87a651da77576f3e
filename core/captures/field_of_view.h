// Horizontal fields of view that a camera of a sweep can have, as programs are told them.
#pragma once

namespace ldp {

// Degrees. With less a turn of a quarter circle is more frames than a sweep has; with more no picture is flat.
inline constexpr double kLeastFov_deg = 5;
inline constexpr double kMostFov_deg = 150;

}  // namespace ldp
