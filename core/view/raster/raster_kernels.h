// The renderer's inner loops: nothing allocated, one loop nest each, lanes run over vertices, quads or pixels.
//
// Compiled once for the base instruction set and, on x86-64, once for AVX2; both give the same bytes.
#pragma once

#include <cstdint>

namespace ldp::view {

// Colour and opacity: r | g << 8 | b << 16 | a << 24.
using Rgba = uint32_t;

constexpr int kSubPx = 256;  // screen positions are integers in 1/256 pixel; pixel centres are multiples of it
constexpr float kOffScreen = -(1 << 23);  // x of a vertex behind the camera or far outside
constexpr float kNothing = -1;            // inverse z of a pixel that no surface covers; infinity is 0
constexpr int kRowQuads = 32;             // at most so many in a row

struct Fragment {
  float inverse_z = kNothing;
  Rgba colour = 0;
};

namespace kernels {

// A pinhole camera with distortion, in pixels.
struct Lens {
  float fx, fy, cx, cy, k1, k2, p1, p2;
  float max_r2;  // beyond this squared radius the distortion folds back
  bool distorts;
};

// Vertices in front of a camera: a + w b in its axes, up to a positive factor.
struct Rays {
  const float *ax, *ay, *az, *bx, *by, *bz;
};

// Vertices on the screen, number by number. Positions are integers below 2^23, which floats hold exactly.
struct ScreenRow {
  float x[kRowQuads + 1], y[kRowQuads + 1], inverse_z[kRowQuads + 1];
};

// A vertex on the screen, and once more with its colour.
struct Vertex {
  float x, y, inverse_z;
  Rgba colour;
};

// Quads on the screen. Corner k of quad i is vertices[k][i]; the same number by number is x[k][i], y[k][i],
// inverse_z[k][i]. Corners are in the order left above, right above, left below, right below.
struct QuadRow {
  const Vertex* vertices[4];
  const float *x[4], *y[4], *inverse_z[4];
};

// A quad by the indices of its corners.
struct IndexedQuad {
  uint16_t corner[4];
};

// What a QuadRow refers to, of quads that share vertices in any way.
struct QuadTable {
  Vertex vertices[4][kRowQuads];
  float x[4][kRowQuads], y[4][kRowQuads], inverse_z[4][kRowQuads];
};

// Pixels of a picture: columns x0 .. x1, rows 0 .. y1.
struct Clip {
  int x0, x1, y1;
};

// The pixels whose centres lie in the box of each quad, clipped: x .. right, y .. bottom. Bit i of a mask is about
// quad i.
struct Boxes {
  int32_t x[kRowQuads], y[kRowQuads], right[kRowQuads], bottom[kRowQuads];
  float nearest[kRowQuads];  // largest inverse z
  uint32_t some;             // the box is not empty
  uint32_t wide, high;       // x < right, y < bottom
  uint32_t beyond;           // x + 1 < right or y + 1 < bottom
  uint32_t large;            // of more than kSmallQuad along either axis
};
constexpr int kSmallQuad = 8 * kSubPx;

// Pixels that may lie in quads of a row.
struct Candidates {
  static constexpr int kMostOfOneQuad = 81, kRoom = 4 * kRowQuads + kMostOfOneQuad, kPadding = 8;
  int count = 0;
  int32_t pixel[kRoom + kPadding];  // x | y << 16
  int32_t quad[kRoom + kPadding];
};

struct Kernels {
  // out[i] for i in [first, first + count) from rays and w from 0 on; (vx, vy, vz) is added to each a. Ones behind the
  // camera, far outside or beyond the distortion's range are at x = kOffScreen.
  void (*project)(const Rays& rays, const float (&v)[3], const float* w, const Lens& lens, int count, int first,
                  ScreenRow& out);

  // out[first + i] = row[first + i] with colours[i].
  void (*interleave)(const ScreenRow& row, const Rgba* colours, int count, int first, Vertex* out);

  // Quads [0, count); then the last one over again up to a multiple of 8.
  void (*collect)(const Vertex* vertices, const IndexedQuad* quads, int count, QuadTable& out);

  // Of quads [first, end), both multiples of 8.
  void (*find_boxes)(const QuadRow& row, int first, int end, const Clip& clip, Boxes& out);

  // The quads at the candidates' pixel centres; inverse_z = kNothing where the quad is not there, or seen from behind.
  // A quad is split along the diagonal from corner 1 to corner 2; inverse z is linear on the screen within each half,
  // colour bilinear in the quad. Of halves that share an edge exactly one owns the points on it. Quads must not be
  // large. `out` has room for kPadding more than there are; so have the candidates.
  void (*find_hits)(const QuadRow& row, Candidates& candidates, Fragment* out);

  // The same for one pixel of one quad of any size.
  Fragment (*find_hit)(const QuadRow& row, int quad, int x, int y);
};

const Kernels& best();   // for the processor at hand
const Kernels& plain();  // for the base instruction set; the same bytes

}  // namespace kernels
}  // namespace ldp::view
