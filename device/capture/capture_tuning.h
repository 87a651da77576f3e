// Tuned constants of the choice of frames and of their storage: unit, meaning, and the range that makes sense. Why
// these: decisions.md. "Step" is how far the content moved since the last kept frame, "wanted step" what the overlap
// asked for allows, both in widths of the picture.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace ldp {

// --- the shift between two thumbnails (image_shift.h) ---

// Half a side, in pixels of the thumbnail, of the window whose mean is taken off each pixel; 2 .. 8.
inline constexpr int kDetailReach_px = 4;
// Pixels that two thumbnails overlap by each way at least, to be compared; 4 .. 16.
inline constexpr int kLeastOverlap_px = 8;
// Grey levels squared a pixel added to the energy, so that noise in flat pictures is no match; 1 .. 16.
inline constexpr double kNoiseEnergy = 4;
// Search sideways, widths, at most; up and down, heights. 0.5 .. 0.8 and 0.1 .. 0.3.
inline constexpr double kMostReach = 0.75;
inline constexpr double kReachDown = 0.2;

// --- which frames are kept (frame_selection.h) ---

// Correlation below which two thumbnails are taken to show different things; 0.2 .. 0.5.
inline constexpr double kGoodMatch = 0.35;
// Pixels of the thumbnail from frame to frame, below which the arm is at rest; 0.2 .. 1.
inline constexpr double kStill_px = 0.5;
// Frames in a row that match each other and not the kept one, before the step counts as passed; 2 .. 6. A smear or a
// passer-by is over by then.
inline constexpr int kAstrayFrames = 3;
// A step that counts as passed, of the wanted one; just above 1.
inline constexpr double kPassedStep = 1.01;
// From here on, of the wanted step, the sharpest frame is held; 0.4 .. 0.8.
inline constexpr double kHoldFrom = 0.6;
// A held frame is worth keeping from here on, of the wanted step; 0.2 .. kHoldFrom.
inline constexpr double kWorthAtEnd = 0.4;
// Weight of the step, against sharpness alone, among held frames: of equally sharp ones the later makes the more even
// steps; 0 .. 0.5.
inline constexpr double kStepWeight = 0.15;

// --- when a sweep has come round ---

// Turn from which on the first frame is looked for, radians; pi / 2 .. 3/2 pi.
inline constexpr double kLookForFirstFrom_rad = std::numbers::pi;
// Correlation of two thumbnails from one place, a hand's width apart; kGoodMatch .. 0.8.
inline constexpr double kSamePlace = 0.6;
// Widths from the first frame, at which the sweep is over; 0.05 .. 0.25.
inline constexpr double kBeside = 0.1;
// Widths by which a hand may shake backwards meanwhile; 0 .. 0.05.
inline constexpr double kHandShake = 0.02;

// --- what the person is told ---

// Widths that the picture may move while the shutter is open; 0.002 .. 0.01.
inline constexpr double kMaxBlur = 0.006;
// Exposure, seconds, that is taken where the camera tells none; 0.001 .. 0.03.
inline constexpr double kUsualExposure_s = 0.01;
// Mean grey, 0 .. 1, below which it is too dark; 0.02 .. 0.15.
inline constexpr double kDark = 0.06;
// Heights of drift up or down; 0.05 .. 0.25.
inline constexpr double kMaxTilt = 0.12;
// Widths a second, below which the arm is idle, and nanoseconds of it until it is told; 0.01 .. 0.1, 1 s .. 5 s.
inline constexpr double kIdleSpeed = 0.03;
inline constexpr int64_t kIdlePatience_ns = 2'000'000'000;
// Widths behind the last kept frame, negative; -0.3 .. -0.05.
inline constexpr double kTurnBack = -0.15;
// Seconds over which the speed is smoothed; 0.1 .. 1.
inline constexpr double kSpeedSmoothing_s = 0.25;

// --- storage ---

// Quality of JPEG files of frames that come as raw pixels, 1 .. 100; 90 .. 98.
inline constexpr int kJpegQuality = 95;
// Bytes of a sweep with its panorama, before there is one to go by; 8 MiB .. 64 MiB.
inline constexpr uint64_t kFirstGuess_bytes = uint64_t{24} << 20;
// Sweeps to go by, the last ones; 1 .. 20.
inline constexpr size_t kSweepsToGoBy = 5;
// Tries at the lock of an output folder, and the time between two: of a service that was killed a build about to start
// may hold it for a moment more. Half a second together; 0.1 s .. 2 s.
inline constexpr int kLockAttempts = 20;
inline constexpr std::chrono::milliseconds kLockInterval{25};

// A camera stands still while every frame matches the first one, moved by less than this (0.03 .. 0.3), and at least so
// many did (3 .. 20).
inline constexpr double kStandsStill_rad = 0.1;
inline constexpr int kStillFrames = 5;

}  // namespace ldp
