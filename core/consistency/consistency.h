// The panorama held against its photographs: rendered back into each of them, with what differs told apart.
//
// Takes the finished panorama (depths through their codes, colours as they will be stored but for compression), the
// photographs and their exposure gains; gives residual statistics per photograph and per direction. Depths and colours
// of the panorama are not changed. (Beyond the paper; Virtual Rephotography, Waechter et al. 2017.)
// How: one photograph after another is rendered with the panorama's own renderer, at its own size, and compared at even
// exposure. What differs by more than noise and half a pixel is looked up in the photographs taken just before and
// after it, at the panorama's depth and at others.
// A colour taken from a photograph agrees with that photograph: residuals are a lower bound of what new views have.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/base/job.h"
#include "core/consistency/held.h"
#include "core/panorama/panorama.h"
#include "core/photos/exposure_gain.h"
#include "core/photos/frame_source.h"

namespace ldp {

// What a photograph's pixel says of the panorama.
enum class Agreement : uint8_t {
  agrees,        // within noise, or within half a pixel beside an edge
  hole,          // the panorama shows nothing
  exposure,      // agrees once the brightness of its surroundings is made equal
  wrong_colour,  // photographs agree with each other at the panorama's depth, not with its colour
  missing,       // they agree on a surface in front of the panorama's
  wrong_depth,   // they agree on a surface behind the panorama's
  moved,         // they agree with each other at no depth
  alone,         // differs, and no other photograph can tell why
};
constexpr int kAgreements = 8;
const char* name_of(Agreement agreement);  // "agrees", "hole", ...

// Sums over pixels. Squared differences are over all pixels, R, G and B; classes over every second row and column.
struct ResidualStatistics {
  int64_t pixels = 0;
  int64_t squared_difference = 0;  // levels^2, holes as mid-grey
  int64_t holes = 0;
  std::array<int64_t, kAgreements> classes{};

  void add(const ResidualStatistics& other);
  double psnr_db() const;  // at even exposure; 0 without pixels, at most 99
  double hole_share() const;
  double share(Agreement agreement) const;  // of the pixels classified
  // Of the pixels on which two photographs agree (all but alone, moved and hole): what shows another colour.
  double unexplained_share() const;
};

struct PhotoResiduals {
  std::string name;
  ResidualStatistics statistics;
  double noise = 0;                 // median absolute difference in grey where the photograph is plain [levels]
  double shift_x = 0, shift_y = 0;  // of the photograph against the panorama, where they agree [px]
  // Mean absolute gradient of the photograph over that of its rendering, where they agree: below 1, it is blurred.
  double sharpness = 1;
};

// Of what photographs show in a range of directions, as seen from the arc's centre.
struct DirectionResiduals {
  double from = 0, to = 0;  // theta, rad, from < to
  ResidualStatistics statistics;
};

struct ConsistencyReport {
  std::vector<PhotoResiduals> photos;  // in the order of the cameras
  std::vector<DirectionResiduals> directions;
  ResidualStatistics all;
};

struct ConsistencyOptions {
  int directions = 24;          // parts of the panorama's width
  int least_tolerance = 4;      // levels by which a channel may differ whatever the noise
  int most_tolerance = 12;      // and however large the noise
  double tolerance_noises = 3;  // median absolute differences in between
  int most_depths = 256;        // tried where photographs contradict the panorama, a pixel of parallax apart at least
};

// The photographs that the panorama was made from. cameras[i] of the panorama belongs to
// frames.load(frame_of_camera[i]).
struct Evidence {
  const FrameSource& frames;
  const std::vector<int>& frame_of_camera;
  const std::vector<Gain>& gains;  // per camera; of light where the panorama has local exposure
};

// What to do with a photograph's map of Agreement, of half its size; may be empty.
using AgreementSink = std::function<void(const std::string& photo, const Plane<uint8_t>& agreement)>;

// Holds three photographs, their depths, and the panorama's mesh in memory.
ConsistencyReport hold_against(const Evidence& evidence, const LayeredPanorama& panorama,
                               const ConsistencyOptions& options, const Job& job, const AgreementSink& sink = {},
                               const std::vector<consistency::Observer*>& observers = {});

}  // namespace ldp
