// Inner loops of what cameras see of a layer, and of where one camera sees what another does: nothing allocated, one
// loop nest each, lanes run over rows. In single precision, which moves nothing by more than about 1e-4 pixels.
//
// Compiled once for the base instruction set and, on x86-64, once for AVX2; both give the same bytes. Rows may be read
// and written up to kPadding elements past their end.
#pragma once

#include <cstdint>

namespace ldp::layers::kernels {

constexpr int kPadding = 8;
constexpr int kAbsent = 0xFFFF;        // disparity of a pixel that is absent from the layer
constexpr float kLeastForward = 0.1F;  // that of core/geometry/voxel_projection.h

// at(x) = constant + slope x.
struct Linear {
  float constant = 0, slope = 0;
};

// A column of a layer and those beside it: disparities, and whether a pixel is on one surface with them (0 or 1).
struct DisparityColumn {
  const uint16_t *here, *left, *right;
  const uint8_t *joined_left, *joined_right;
};

// A column's projection into a camera's map. A pixel's left and right sides lie half way between the disparities of
// joined neighbours, at its own where they are not.
struct ColumnInView {
  Linear inverse_depth;  // by half steps of disparity
  // By inverse depth: distance along the camera's axis at the middle and the sides, and that times the sides' column.
  Linear forward, forward_left, forward_right, across_left, across_right;
  float focal, cy;      // of the camera
  float up;             // of inverse depth: how much higher than v the pixel stands above the camera
  float columns, rows;  // of the map
  float steps;          // of the map, to inverse distance
};

// The map's pixels that each pixel of a column covers, none where a begin is not before its end; inverse distance in
// the map's steps, 1 .. 65535.
struct Boxes {
  int32_t *begin_x, *end_x, *begin_y, *end_y, *inverse_z;
};

// From pixels of one upright camera's column to another one's. By steps of inverse distance from the first:
struct ToWitness {
  Linear forward, across;  // distance along the other camera's axis, and that times its column
  float down;              // forward times what they add to its row
  Linear row;              // by the row: forward times the other camera's row, from cy, but for that
  float width, height, cy;
  float steps;    // the other map's, to one of the first's
  int tolerance;  // of the other map
};

struct Kernels {
  // `edges_v`: of the pixels' upper sides, and of the last one's lower side.
  void (*find_boxes)(const DisparityColumn& column, const ColumnInView& view, const float* edges_v, int count,
                     const Boxes& boxes);

  // Where the other camera would see the surface at rows[i], steps[i], in 1/16 px from its picture's corner; x16[i] =
  // -1 where it is not in its picture. It does where the other map is at most nearest[i] there.
  void (*look_from_witness)(const ToWitness& to, const int32_t* rows, const int32_t* steps, int count, int32_t* x16,
                            int32_t* y16, int32_t* nearest);
};

const Kernels& best();   // for the processor at hand
const Kernels& plain();  // for the base instruction set; the same bytes

}  // namespace ldp::layers::kernels
