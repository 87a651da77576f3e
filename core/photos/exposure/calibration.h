// Radiometric calibration: the camera's response, and how much light each photograph was given, from what overlapping
// photographs show of the same things (Debevec, Malik 1997; Mitsunaga, Nayar 1999).
//
// Takes what photographs overlap in; gives one response for all of them and factors that bring each to the light of
// all, their mean (of logarithms) being 1 for each channel. In what unit light is (to which power) is of no meaning.
// How: the logarithms of levels of one thing in two photographs differ by what their exposures' do, times the mean
// slope of level over light between the two; slopes are linear between a few levels. Exposures and slopes are solved in
// turns, by least squares that are re-weighted, so that moving things and parallax matter little; slopes bend little,
// and photographs differ little in their tints. Clipped blocks take no part.
#pragma once

#include <cstddef>
#include <vector>

#include "core/photos/exposure/overlap_samples.h"
#include "core/photos/exposure/response_curve.h"
#include "core/photos/exposure_gain.h"

namespace ldp {

struct Calibration {
  ResponseCurve response;
  std::vector<Gain> light_gains;  // per photograph
};

Calibration calibrate(const std::vector<exposure::Overlap>& overlapping, size_t photos);

}  // namespace ldp
