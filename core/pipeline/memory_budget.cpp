#include "core/pipeline/memory_budget.h"

#include <algorithm>

namespace ldp {
namespace {

constexpr size_t kProgram = 33'000'000;                    // code, libraries, poses
constexpr size_t kPhotoPixel = 6;                          // of one photo and the next
constexpr size_t kSolver = 6'000'000, kStripRow = 11'000;  // windows of two threads; columns in work
constexpr size_t kUprightPixel = 4;                        // grey, tint and visibility
constexpr size_t kDisparity = 2, kSolvedPixel = 12;        // of each layer; of the layer that is being found
constexpr size_t kColouredLayerPixel = 10, kSeams = 11;    // everything of each layer; where photos meet
constexpr size_t kOpenPhotoPixel = 18;                     // of the other six photos that colours are read from
// Of each layer held against the photographs; of its part of a mesh, and of one layer more; of three photos in memory;
// of the photos' differences from the front layer.
constexpr size_t kHeldLayerPixel = 5, kMeshPixel = 6, kComparedPhotoPixel = 18, kDifferences = 6;
constexpr size_t kHeldPixel = 8, kArraysInWork = 8'000'000;  // beside a scratch space: what is no array of samples;
                                                             // what is touched before it is let go again

}  // namespace

ExpectedMemory expected_memory(const PanoramaGrid& grid, int columns_of_colour, size_t photo_px, size_t upright_px,
                               int layers) {
  const auto height = static_cast<size_t>(grid.height), count = static_cast<size_t>(layers);
  const size_t panorama_px = static_cast<size_t>(grid.width) * height,
               stored_px = panorama_px * static_cast<size_t>(columns_of_colour);
  const size_t always = kProgram + kPhotoPixel * photo_px, strip = kSolver + kStripRow * height;
  const size_t solving = strip + kUprightPixel * upright_px + (kDisparity * count + kSolvedPixel) * panorama_px;
  // The upright frames are gone by then.
  const size_t colouring =
      kColouredLayerPixel * count * stored_px + std::max(kSeams * stored_px, kOpenPhotoPixel * photo_px);
  const size_t comparing =
      (kHeldLayerPixel * count + kMeshPixel * (count + 1) + kDifferences) * stored_px + kComparedPhotoPixel * photo_px;
  const size_t all = always + std::max({solving, colouring, comparing});
  return {all, std::min(all, always + strip + kHeldPixel * stored_px + kArraysInWork)};
}

}  // namespace ldp
