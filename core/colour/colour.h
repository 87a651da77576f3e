// The colour of every pixel of a layer: which photograph it is taken from (a graph cut, paper 3.3.2), then its value.
//
// Takes the layers' disparity, the cameras, what hides voxels from them, and the chosen photograph of each pixel; gives
// the candidates that the cut chooses from, and colours.
// How: a candidate sees the voxel; it costs the angle between the panorama's ray and the camera's, more where the
// sample may be mixed with a nearer object's edge, and more where it differs from what most of them see. Colours are
// read from the photographs themselves (one resampling), few of them in memory at a time: where three or more of the
// chosen one and those taken beside it see the voxel, what they agree on, with the brightness of the chosen one
// (blending.h). What steps remain between photographs are spread over the surfaces on both sides. Does not solve for
// the choice (solve.h).
#pragma once

#include <array>
#include <vector>

#include "core/base/job.h"
#include "core/base/source_costs.h"
#include "core/base/source_map.h"
#include "core/geometry/disparity.h"
#include "core/geometry/geometry.h"
#include "core/geometry/visibility_map.h"
#include "core/geometry/voxel_projection.h"
#include "core/photos/exposure/gain_field.h"
#include "core/photos/exposure_gain.h"
#include "core/photos/frame_source.h"
#include "core/photos/upright_frame.h"

namespace ldp {

struct ColourOptions {
  double mixed_px = 1.5;      // a sample so close to a nearer surface may be mixed with it
  double mixed_deg = 8;       // what that costs
  double off_axis_deg = 2;    // what a sample in the photograph's corner costs (blur, vignetting)
  double disagree_deg = 2.5;  // what each level beyond noise costs by which a sample differs from the median, of
                              // three candidates or more
  int seam_cell_px = 16;      // seams are spread in cells of this size
  bool guess_hidden = false;  // a pixel that every camera has hidden takes what lies in front of it
  bool level_seams = true;
};

// The frames that see each pixel of one layer (paper equation 7). What is referred to and not empty must outlive it.
class SourceCandidates final : public ColourCosts {
 public:
  // `visibility` is empty (nothing hides anything) or has one map per frame.
  SourceCandidates(const PanoramaGrid& grid, const DisparityMap& layer, const std::vector<UprightFrame>& frames,
                   const std::vector<VisibilityMap>& visibility, const ColourOptions& options);
  int width() const override { return grid_.width; }
  int height() const override { return grid_.height; }
  bool wraps() const override { return grid_.wraps; }
  int frames() const override { return static_cast<int>(frames_.size()); }
  int candidates(int x, int y, uint16_t frame[16], uint16_t cost[16]) const override;
  uint8_t depth_label(int x, int y) const override;
  bool present(int x, int y) const override { return layer_.at(x, y) != kNoDisparity; }

  // Whether a photograph shows a pixel that is present, and the one that does so best (kNoSource = none).
  bool sees(int frame, int x, int y) const;
  int cheapest(int x, int y) const;

  // Of each pixel that is taken from photograph `source`: which of those beside it see the voxel too, by
  // colour::neighbour_bit.
  Plane<uint8_t> neighbours(const SourceMap& source, const Job& job) const;

 private:
  struct Seen {
    bool visible = false, mixed = false;
  };
  // At a place between the photograph's first and last columns.
  Seen look(size_t frame, double x_px, double y_px, double inverse_z, bool through) const;
  void find_facing(int x);
  struct Candidate {
    uint16_t frame = 0;
    int cost = -1;  // negative: does not see the voxel
    uint8_t grey = 0, tint = 0;
  };
  Candidate candidate(uint16_t frame, int x, int y, double w, bool through) const;
  uint8_t neighbours_of(int x, int y, int own) const;
  static void doubt_odd_ones(double cost_per_level, Candidate* begin, Candidate* end);
  int collect(int x, int y, bool through, uint16_t frame[16], uint16_t cost[16]) const;

  const PanoramaGrid& grid_;
  const DisparityMap& layer_;
  const std::vector<UprightFrame>& frames_;
  const std::vector<VisibilityMap>* visibility_;  // null = nothing hides anything
  ColourOptions options_;
  std::vector<VoxelProjection> projections_;
  std::vector<Heading> headings_;              // of column centres
  std::vector<std::vector<uint16_t>> facing_;  // frames that may see a column, nearest to its rays first
};

// What colours are read from. cameras[i] belongs to frames.load(frame_of_camera[i]).
struct Photographs {
  const FrameSource& frames;
  const std::vector<Camera>& cameras;
  const std::vector<int>& frame_of_camera;
  std::vector<Gain> gains;  // per camera
  // Over the panorama; gains are those of light where it is not empty.
  DisplayExposure local = {};
};

// One layer's choice of photographs (kNoSource = none) and where its colours go.
struct ColourTask {
  const DisparityMap* disparity = nullptr;
  const SourceMap* source = nullptr;
  RgbImage* colour = nullptr;                  // sized like the grid
  const Plane<uint8_t>* neighbours = nullptr;  // of each pixel; null = every pixel's own photograph alone
};

// Fills the colours of all layers, reading each photograph once.
void blend_colours(const PanoramaGrid& grid, const Photographs& photographs, const std::vector<ColourTask>& tasks,
                   const ColourOptions& options, const Job& job);

}  // namespace ldp
