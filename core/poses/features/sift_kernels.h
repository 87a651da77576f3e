// The inner loops of finding and describing feature points: nothing allocated, one loop nest each, every operation one
// of IEEE 754 in a fixed order.
//
// Compiled once for the base instruction set and, on x86-64, once for AVX2; both give the same bytes.
#pragma once

#include <cstdint>

namespace ldp::sfm::sift {

// The weights of a symmetrical blur: half[0] in the middle, half[j] at j places to either side, up to j = reach.
struct Blur {
  const float* half;
  int reach;
};

// Of a row of a difference of two blurred pictures: its values, and the largest and smallest in the square of three by
// three around each. Nothing is known of the first and the last place.
struct DifferenceRow {
  float *middle, *largest, *smallest;
};

constexpr int kMaxWindow = 80;  // places of a row of a window

// A row of a window around a keypoint. Places are counted from the pixel nearest to it; `middle` is in its column.
struct WindowRow {
  const float* middle;
  int stride;            // from row to row of the picture
  int y, first, end;     // the row's place; columns first .. end - 1, at most kMaxWindow
  const float* weights;  // of places in a row or a column, weights[0] of the pixel nearest to the keypoint
};

// From pixels to the cells of a descriptor, and where directions are counted from.
struct PatchRotation {
  float cosine, sine, angle_rad;
};

constexpr int kOrientationBins = 36;          // bins for the direction of a keypoint
constexpr int kCells = 4, kOrientations = 8;  // of a descriptor
// With a rim of cells that nobody asks for; it is wider after the last ones, because a place just short of kCells is
// rounded to it.
constexpr int kPaddedCells = 1 + kCells + 2;
using Cells = float[kPaddedCells * kPaddedCells * kOrientations];

struct Kernels {
  // out[x] from rows[0][x] .. rows[2 * reach][x].
  void (*blur_down)(const float* const* rows, const Blur& blur, int width, float* out);

  // out[x] from line[x - reach] .. line[x + reach].
  void (*blur_across)(const float* line, const Blur& blur, int width, float* out);

  // Of rows of two pictures, the middle one of each is the row asked for.
  void (*find_difference)(const float* const (&less)[3], const float* const (&more)[3], int width, DifferenceRow& out);

  // out[x] = 1 where levels[1] is larger than `least` or smaller than -`least`, and nothing near it at the three levels
  // is more so; 0 elsewhere.
  void (*mark_extrema)(const DifferenceRow (&levels)[3], float least, int width, uint8_t* out);

  // Adds the sizes of gradients to the bins of their directions.
  void (*add_to_orientation_histogram)(const WindowRow& row, float (&bins)[kOrientationBins]);

  // Adds the sizes of gradients to the cells and directions nearest to them.
  void (*add_to_descriptor)(const WindowRow& row, const PatchRotation& turn, Cells& cells);
};

const Kernels& best();   // for the processor at hand
const Kernels& plain();  // for the base instruction set; the same bytes

}  // namespace ldp::sfm::sift
