#include "memory.h"

namespace ldp {
namespace {

constexpr size_t kProgram = 50'000'000;             // code, libraries, one photo being decoded
constexpr size_t kUprightPixel = 4;                 // grey, tint and visibility
constexpr size_t kPanoramaPixel = 22, kLayer = 10;  // sources, seams and output; disparity and more of each layer

}  // namespace

size_t expected_peak_bytes(size_t panorama_px, size_t upright_px, int layers) {
  return kProgram + kUprightPixel * upright_px + (kPanoramaPixel + kLayer * static_cast<size_t>(layers)) * panorama_px;
}

}  // namespace ldp
