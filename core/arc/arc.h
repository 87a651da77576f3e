// Fits the circle on which the hand moved (paper section 4: least squares; here robust, with residuals), and lays the
// panorama's grid over what the cameras see.
//
// Takes cameras (world frame) and sparse points; gives an Arc and a PanoramaGrid. The axis n points up as the cameras
// hold up (mean of their -y axes), which settles what a short or nearly straight path leaves open.
#pragma once

#include <string>
#include <vector>

#include "core/geometry/geometry.h"

namespace ldp {

struct ArcFit {
  Arc arc;
  std::vector<double> radial_residuals, height_residuals;  // per camera, capture's unit
  bool straight = false;                                   // the path did not bend enough to fix a radius
  bool forward = false;  // nor does it go across the lines of sight: rays start in one point, radius 0
};

ArcFit fit_arc(const std::vector<Camera>& cameras);

// What to do where the photos lie on their side, told by cameras in the order of the sweep that go or turn up or down
// in their pictures; empty where they go to the side, or nothing is clear.
std::string sideways(const std::vector<Camera>& cameras);

// Whether they turn up or down, not aside. Then their path may seem a line, or one along their lines of sight, seen in
// the arc's plane, and be none.
bool nods(const std::vector<Camera>& cameras);

struct GridOptions {
  Rays rays = Rays::pushbroom;
  double pitch_px = 1;  // panorama pitch in photo pixels: d_theta = d_v = pitch_px / focal
  // Inverse depth to which photos match nearer than the points tell (cost_volume.h); 0 = not known.
  double matched_near = 0;
  // 0 = from the points (2nd and 98th percentile, or what a few points of three cameras and more surely lie on, with a
  // margin; far becomes infinity when > 100 r) and matched_near.
  double near_depth = 0, far_depth = 0;
};

// Extends half a field of view past both ends of the path, and to every row that the cameras see; wraps when closed or
// when 2 pi is reached.
PanoramaGrid lay_grid(const Arc& arc, const std::vector<Camera>& cameras, const std::vector<ScenePoint>& points,
                      const GridOptions& options);

// Rays start on the arc, not in a camera: on a surface at depth z a column as wide as a photo's pixel at infinity spans
// (r + z) / z of the photo's pixels. How many columns of colour one column of depths is worth at the points' median
// depth, 1 or 2; 1 where the photos have fewer columns or pixels together, or a file could not hold as many columns.
// (Depths are found as well, and faster, in the wide ones.)
int columns_of_colour(const PanoramaGrid& grid, const std::vector<Camera>& cameras,
                      const std::vector<ScenePoint>& points);

// The same panorama with `times` as many columns.
PanoramaGrid with_finer_columns(PanoramaGrid grid, int times);

// The part from column x and row y on; one that wraps has all columns.
PanoramaGrid part_of(PanoramaGrid grid, int x, int y, int width, int height);

}  // namespace ldp
