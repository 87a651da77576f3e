// How close a rendered view comes to a true one: PSNR and SSIM, as the field measures them.
//
// Takes a view (colour, and alpha 0 where nothing was rendered) and the true picture of the same size. Holes count as
// mid-grey. SSIM: Wang et al. 2004, grey by Rec. 601, 11x11 Gaussian of deviation 1.5, mirrored at the border.
#pragma once

#include "core/base/plane.h"

namespace ldp {

struct ViewQuality {
  double psnr_db = 0;          // over all pixels
  double ssim = 0;             // over all pixels
  double psnr_covered_db = 0;  // over covered pixels; 0 when there is none
  double psnr_matched_db = 0;  // over all pixels, after the best factor for each channel (exposure left aside)
  double holes = 0;            // share of pixels, 0 .. 1
};

// An empty alpha means that every pixel is covered. Throws std::logic_error when sizes differ.
ViewQuality view_quality(const RgbImage& view, const Plane<uint8_t>& alpha, const RgbImage& truth);

double ssim(const Plane<double>& a, const Plane<double>& b);

}  // namespace ldp
