// Views of a panorama from camera after camera, with only as much of its mesh in memory as the camera at hand may see.
//
// The columns are cut into strips; those that a camera may see are made a mesh, the others are let go. Cameras that
// follow each other along a sweep see much the same, so that each strip is prepared about once. Nothing is made up
// beyond the photographs' frames.
#pragma once

#include <memory>

#include "core/base/job.h"
#include "core/geometry/geometry.h"
#include "core/panorama/panorama.h"
#include "core/view/render.h"

namespace ldp {

class StripRenderer {
 public:
  explicit StripRenderer(const LayeredPanorama& panorama);  // which must outlive it
  ~StripRenderer();
  // What render() needs of the panorama for a camera, so that it only draws.
  void prepare(const Camera& camera, const Job& job);
  // The same for any cameras before it and any number of threads. Options of layers and fill are honoured.
  View render(const Camera& camera, const RenderOptions& options, const Job& job);

 private:
  struct Prepared;
  std::unique_ptr<Prepared> prepared_;
};

}  // namespace ldp
