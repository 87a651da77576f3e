// Layers from disparity: silhouettes, what hides voxels from cameras (occlusion), and where layers behind the first are
// wanted (disocclusion; paper 3.3.3, 3.3.4). How a view cuts surfaces apart is the renderer's (core/view/mesh/mesh.h).
//
// Takes the disparity maps of the layers so far (front to back, on the panorama's grid) and the upright cameras.
// Gives visibility maps, the pixels at which some camera sees something that no layer explains yet, and a cost source
// that ties a layer behind to the background it continues.
// How: every layer pixel is drawn into every upright camera as a rectangle whose sides it shares with neighbours on the
// same surface; what stays uncovered in a camera is what the next layer has to show.
// Does not choose depths or colours.
#pragma once

#include <vector>

#include "core/base/cost_source.h"
#include "core/base/job.h"
#include "core/geometry/disparity.h"
#include "core/geometry/geometry.h"
#include "core/geometry/visibility_map.h"
#include "core/photos/upright_frame.h"

namespace ldp {

struct LayersOptions {
  double tolerance_labels = 0.4;  // a surface hides what lies further behind it than this
  // Neighbours belong to one surface while their inverse depths differ by less than this share of themselves (a surface
  // seen at a grazing angle) plus this parallax over one arc radius.
  double connect_share = 0.02;
  double connect_px = 3;
  double gap_px = 2;  // a layer behind shows at least so much parallax against the front over one arc radius
};

// The cameras, and what each sees first.
struct CameraViews {
  const std::vector<UprightFrame>& frames;
  const std::vector<VisibilityMap>& maps;  // one per frame
};

constexpr int kLabelSteps = kDisparitySteps / (kLabels - 1);  // disparity steps of one label of 16

// Occlusion (visibility.cpp): draws a layer into the maps of what each camera sees first; empty `maps` are made.
// Covered pixels hold at least 1, pixels that no layer reaches 0. The order of layers does not matter.
void add_layer(const PanoramaGrid& grid, const DisparityMap& layer, const std::vector<UprightFrame>& frames,
               const LayersOptions& options, const Job& job, std::vector<VisibilityMap>& maps);

// The farthest and the nearest disparity in the square that reaches `reach_px` from each pixel (morphology.cpp). The
// farthest are what is left of surfaces well inside their outlines, and so surely hides what lies behind. (Windows of
// matching make near surfaces a few pixels too wide.) Absent pixels count for neither: where all are, the square has
// kNoDisparity.
DisparityMap farthest_around(const PanoramaGrid& grid, const DisparityMap& layer, int reach_px);
DisparityMap nearest_around(const PanoramaGrid& grid, const DisparityMap& layer, int reach_px);

enum Want : uint8_t { kUnwanted = 0, kWanted = 1, kBoundary = 2 };

// Disocclusion (disocclusion.cpp), where the next layer is wanted: pixels with a voxel behind `front` that falls on an
// uncovered pixel of some camera. kBoundary marks unwanted pixels beside wanted ones whose own surface lies behind the
// neighbour's front: the background that the next layer continues. `front` holds the deepest layer so far, kNoDisparity
// where it is absent.
Plane<uint8_t> wanted_behind(const PanoramaGrid& grid, const DisparityMap& front, const CameraViews& views,
                             const LayersOptions& options, const Job& job);

// Disparity steps of `gap_px`.
int gap_steps(const PanoramaGrid& grid, const LayersOptions& options);

// Inpaints depth (background.cpp): continues the background into wanted pixels, row by row from their kBoundary
// neighbours, where the layer is absent or agrees with it to a label. (Labels are coarse where the range is long; the
// background's own disparity is not.)
void continue_background(const Plane<uint8_t>& want, const DisparityMap& surface, int gap, DisparityMap& layer);

// Gives every pixel of a layer behind `surface` the median disparity of those of the layer within `reach_px` of it, up
// and down and to the sides, where that lies behind the surface, too: few photos see what is hidden, and what is found
// of it is noisy from row to row.
void smooth_behind(const PanoramaGrid& grid, const DisparityMap& surface, int gap, int reach_px, const Job& job,
                   DisparityMap& layer);

// Removes from `layer` what no camera sees (pixels become kNoDisparity) and returns the number of pixels kept.
int drop_unseen(const PanoramaGrid& grid, const CameraViews& views, const Job& job, DisparityMap& layer);

// Cuts silhouettes (silhouettes.cpp): moves the outlines of a dense layer's near surfaces inwards to where the
// photographs put them: a pixel beside a surface further back takes its disparity where few pixels around it match
// better there.
void fit_outlines(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, const Job& job,
                  DisparityMap& layer);

// What lies `right` and `down` pixels from each pixel (of the panorama's edge, beyond it).
DisparityMap shifted(const PanoramaGrid& grid, const DisparityMap& layer, int right, int down);

enum class Lightness : uint8_t { as_around, lighter, darker };

// Of each pixel of a layer, as the camera next to its ray shows it, against the mean of the square that reaches
// `reach_px` from it (proposals/lightness.cpp).
Plane<Lightness> lightness(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, const DisparityMap& layer,
                           int reach_px, const Job& job);

// Remembers of every pixel that is read which label is cheapest, and which ones nearly are (proposals/unsmoothed.cpp):
// smoothness takes away what is thin.
class CheapestLabels final : public CostSource {
 public:
  static constexpr uint8_t kUnread = 255;

  explicit CheapestLabels(const CostSource& inner);
  int width() const override { return inner_.width(); }
  int height() const override { return inner_.height(); }
  int labels() const override { return inner_.labels(); }
  bool wraps() const override { return inner_.wraps(); }
  void read(const Window& window, uint8_t* cost, uint8_t* median) const override;

  const Plane<uint8_t>& cheapest() const { return cheapest_; }

  // 1 where the cheapest label is nearer than the one chosen, and clearly cheaper, in connected parts of at least
  // `least` pixels whose labels are at most one apart from pixel to pixel: fewer are chance.
  Plane<uint8_t> clearly_nearer(const Plane<uint8_t>& chosen, int least) const;

 private:
  const CostSource& inner_;
  mutable Plane<uint8_t> cheapest_;
  mutable Plane<uint16_t> nearly_;  // bit l: label l costs hardly more
};

// Removes connected parts of fewer than `least` pixels, of which pixels side by side differ by at most `apart`: they
// cost much to store, and a renderer lets the background go on there.
void drop_small_components(int least, bool wraps, DisparityMap& layer, int apart = kDisparitySteps);

// Gives connected parts of fewer than `least` pixels, apart from all around them, the median disparity beside them.
void absorb_specks(const PanoramaGrid& grid, int least, DisparityMap& layer);

// The layer on a grid of `times` as many columns: between the middles of columns on one surface disparity is linear.
DisparityMap with_finer_columns(const DisparityMap& layer, int times, bool wraps);

// The costs of `inner`, with pixels of `want` marked kBoundary held at the label of `surface`; and labels of wanted
// pixels farther than `likely` dearer: what is hidden is mostly what goes on from beside it, and the few photographs
// that show it leave the rest to chance. All must outlive it.
class BoundaryCosts final : public CostSource {
 public:
  BoundaryCosts(const CostSource& inner, const Plane<uint8_t>& want, const DisparityMap& surface,
                const DisparityMap& likely)
      : inner_(inner), want_(want), surface_(surface), likely_(likely) {}
  int width() const override { return inner_.width(); }
  int height() const override { return inner_.height(); }
  int labels() const override { return inner_.labels(); }
  bool wraps() const override { return inner_.wraps(); }
  void read(const Window& window, uint8_t* cost, uint8_t* median) const override;

 private:
  const CostSource& inner_;
  const Plane<uint8_t>& want_;
  const DisparityMap &surface_, &likely_;
};

// What hidden surfaces are likely to reach: the farthest disparity of `front` within `reach_px`, and not quite another
// surface. kNoDisparity where the front is absent all around.
DisparityMap likely_behind(const PanoramaGrid& grid, const DisparityMap& front, int reach_px);

}  // namespace ldp
