// Times and limits of the service: unit in the name, meaning, and the range that makes sense. Why these: decisions.md.
#pragma once

#include <cstdint>

namespace ldp {

inline constexpr int64_t kSecond_ns = 1'000'000'000;

// A press this long cancels; 1 .. 10. Told to people.
inline constexpr int kLongPress_s = 3;

// Statuses are repeated, and what is missing is looked for again; 0.2 s .. 5 s.
inline constexpr int64_t kTick_ns = kSecond_ns;

// How long a result stays shown; 5 s .. 300 s.
inline constexpr int64_t kRest_ns = 30 * kSecond_ns;

// From one guidance to the next; 50 ms .. 500 ms.
inline constexpr int64_t kGuidanceInterval_ns = kSecond_ns / 5;

// From one try to open a missing button to the next; 1 .. 10. Told to people.
inline constexpr int kButtonRetry_s = 2;

// At the end of the service, for the next frame to be stored; 2 .. 60.
inline constexpr int kDiskPatience_s = 8;

// Builds of a capture that came to no verdict, before it is left alone; 2 .. 20.
inline constexpr int kMaxInterruptions = 5;

// Exposure counts as settled after so many frames in a row (2 .. 10) whose mean brightness, 0 .. 1, changed by less
// than this each (0.002 .. 0.05).
inline constexpr int kSteadyFrames = 3;
inline constexpr double kSteadyBrightness = 0.01;

// Frames in a row of one size that is not the camera's own, before it is taken for that of the sweep; 2 .. 10. Fewer
// may be JPEG files whose headers were damaged.
inline constexpr int kAlikeFrames = 3;

// Exposure that never settles is locked all the same, after so many times the camera's own time to settle; 2 .. 10.
inline constexpr double kMaxSettleFactor = 4;

// Horizontal field of view that is taken where none is configured, radians; it only scales the angles that are shown.
inline constexpr double kUsualFov_rad = 1.13;

}  // namespace ldp
