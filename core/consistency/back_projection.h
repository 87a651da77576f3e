// Colours drawn to the photographs: where those that show a pixel's surface agree on how far the panorama, rendered
// into them, is off, its colour moves by that (one round of iterative back-projection, Irani and Peleg 1991). Gives
// back what two resamplings, the colours' and the renderer's, have blurred. Residuals told are those of before.
//
// Takes what an observer of `hold_against` is shown, so that no photograph is rendered again; depths and coverage stay.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/job.h"
#include "core/consistency/held.h"
#include "core/geometry/voxel_projection.h"
#include "core/panorama/panorama.h"

namespace ldp {

class BackProjection : public consistency::Observer {
 public:
  // Of the panorama that is held against its photographs. Refers to both; takes 6 bytes for each pixel of the grid.
  BackProjection(const LayeredPanorama& panorama, const Job& job);

  void rendered(size_t camera, const consistency::Held& own, const consistency::Rendering& rendering,
                const consistency::Held* before) override;

  // Moves the front layer's colours, which have not changed since. Too few photographs see what lies behind.
  void correct(Layer& front) const;

 private:
  struct Differences {     // of photographs from their renderings, in grey, at one pixel
    int16_t sum = 0;       // [1/16 level]
    uint16_t squares = 0;  // [level^2]
    uint8_t photos = 0;
  };
  struct InView {  // a column of the panorama that a camera may see
    int x = 0;
    PhotoProjection::Column direction;
  };
  std::vector<InView> in_view(const Camera& camera, const PhotoProjection& projection) const;
  void add_row(const consistency::Held& own, const consistency::Rendering& rendering, const PhotoProjection& projection,
               const std::vector<InView>& columns, int y);

  const LayeredPanorama& panorama_;
  const Job& job_;
  std::vector<Heading> headings_;  // of the middles of columns
  Plane<Differences> differences_;
};

}  // namespace ldp
