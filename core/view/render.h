// A perspective view with parallax from a layered depth panorama (paper section 3).
//
// Takes a panorama and a camera (any pose, distortion honoured); gives colour, alpha and z-depth. Layers are meshes
// that tear at depth edges, drawn with a z-buffer; the deepest surfaces go on some pixels underneath silhouettes
// (underlay.h), near ones beyond the photographs' frames (frame_extension.h). Pixels that nothing covers have alpha 0
// and depth 0. Outlines are mixed (outlines.h).
#pragma once

#include <cstdint>
#include <memory>

#include "core/base/job.h"
#include "core/geometry/geometry.h"
#include "core/panorama/file/ldp_file.h"
#include "core/panorama/panorama.h"

namespace ldp {

constexpr int kMaxViewSide = 1 << 14;

// Bytes that a renderer of a panorama holds beside it, at most: 12.3 a pixel and 105 more where one is present were
// measured when all was prepared at once, which strip by strip takes less; 40 for each pixel of a view that is filled.
constexpr uint64_t kMeshBytesPerPixel = 14, kMeshBytesPerPresentPixel = 128, kMeshBytesAlways = 16 << 20;
constexpr uint64_t kBytesOfView = 48;
uint64_t rendering_bytes(const LdpDescription& description);  // of all its layers, without views

enum class Fill { none, background };

struct RenderOptions {
  int layers = 8;          // draw at most so many of the panorama's layers; with fewer than all nothing is made up
  Fill fill = Fill::none;  // background: continue the background over holes, alpha 255 everywhere
  bool depth = false;      // also return z-depth
  bool outlines = true;    // close cracks and mix colours at outlines (outlines.h); else every pixel shows one surface
};

struct View {
  RgbImage colour;
  Plane<uint8_t> alpha;  // 0 = hole, 255 = covered
  Plane<float>
      depth;  // z along the camera's forward axis, capture's unit; 0 = none, infinity = at infinity; empty unless asked
  double invented_share = 0;  // share of pixels that `fill` made up
};

// Draws any number of views, from any number of threads. What a view needs of the panorama (positions of vertices,
// tears) is prepared when the first one asks for it, strip by strip of its columns, and kept.
class Renderer {
 public:
  explicit Renderer(const LayeredPanorama& panorama);  // which must outlive it
  explicit Renderer(LayeredPanorama&& panorama);       // lets go of its layers once all of it is prepared
  ~Renderer();
  void prepare(const Job& job);  // all of it, so that views only draw
  View render(const Camera& camera, const RenderOptions& options, const Job& job = {}) const;

 private:
  struct Prepared;
  std::unique_ptr<Prepared> prepared_;
};

}  // namespace ldp
