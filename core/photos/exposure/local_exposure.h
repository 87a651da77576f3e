// Local exposure: in every direction a panorama is as bright as the photographs that looked there.
//
// A camera on automatic exposure shows sun and shade each well exposed; at one exposure for all, the shade is black and
// the sky white. So photographs are brought to one exposure by their gains, and that is multiplied by a factor that
// depends on the direction alone: low in frequency, so that contrast near by stays as it was and no silhouette has a
// halo, and going back to even exposure is one division.
//
// Takes cameras and the gains that bring their photographs to the exposure of all, whatever they are factors of; gives
// the factor of any direction: the weighted mean, of logarithms, of what takes each photograph's exposure back, with
// weights that fall off with the angle from its axis.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/geometry/geometry.h"
#include "core/photos/exposure/gain_field.h"
#include "core/photos/exposure_gain.h"

namespace ldp {

class LocalExposure {
 public:
  // One gain a camera. Refers to the cameras. With gains of light (calibration.h) factors are those of light.
  LocalExposure(const std::vector<Camera>& cameras, const std::vector<Gain>& gains);

  // Whether at even exposure the direction of some photograph would differ much from it: gains are those of levels.
  bool is_wanted() const;

  // What even exposure is to be multiplied by, over a panorama.
  GainField over(const PanoramaGrid& grid) const;

  // What one photograph is to be multiplied by, over its pixels: its gain and the factor of where they look.
  GainField over_photo(size_t camera) const;
  // What takes a view of local exposure to that of a photograph of this gain from there, over its pixels.
  GainField back_to_photo(const Camera& view, const Gain& gain) const;

 private:
  using LogGain = std::array<double, 3>;

  GainField over_picture(const Camera& from, const LogGain& log_gain, double sign) const;
  LogGain log_factor(const Eigen::Vector3d& direction) const;

  const std::vector<Camera>& cameras_;
  std::vector<LogGain> log_gains_;
};

}  // namespace ldp
