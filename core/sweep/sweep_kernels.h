// The sweep's inner loops: integers only, nothing allocated, one loop nest each. Lanes run over rows (v).
//
// Compiled once for the base instruction set and, on x86-64, once for AVX2; both give the same bytes.
// Buffers may be read and written up to kPadding elements past `count`; what is written there is meaningless. Image
// columns (left, right, surface) are not read past their end. Nothing needs to be aligned.
#pragma once

#include <cstdint>

namespace ldp::sweep::kernels {

constexpr int kPadding = 64;
constexpr int kMaxViews = 8;              // cameras whose samples are compared at a voxel
constexpr uint8_t kLargestVariance = 40;  // 10 grey levels: what differs more is just another surface
constexpr uint8_t kLargestDoubt = 8;      // grey levels: what a camera that does not agree can add
constexpr uint8_t kGreyNoise = 2;         // grey levels that two samples of one surface may differ by
constexpr uint8_t kTintNoise = 4;         // and levels of tint: chroma is coarser in photos
constexpr int kWeightBits = 6;            // of linear interpolation
constexpr int kWeightOne = 1 << kWeightBits;

constexpr uint8_t kAlike = 10;  // grey levels that pixels of one surface next to each other may differ by
constexpr int kBoxShare = 10;   // pixels that the box counts for beside those alike

constexpr int kSmoothReach = 5;       // of the smoothing window: 11 x 11
constexpr int kSmoothBinSteps = 128;  // disparity steps of a bin of its median
constexpr uint8_t kNoBin = 255;       // of a pixel without disparity
constexpr int kSmoothWeights = 48;    // weights by difference of grey; what differs more has none

// Rows of a picture around the one that is smoothed: bin = disparity / kSmoothBinSteps, kNoBin where there is none.
struct SmoothRow {
  const uint8_t* grey = nullptr;
  const uint8_t* bin = nullptr;
  const uint16_t* disparity = nullptr;
};

// Samples and, beside them, their tints.
template <typename T>
struct Tinted {
  T *grey = nullptr, *tint = nullptr;
};

using Samples = Tinted<const uint8_t* const>;  // a column of each view

struct Kernels {
  // out[i] = (left[i] (64 - weight) + right[i] weight + 32) >> 6.
  void (*blend_columns)(const uint8_t* left, const uint8_t* right, int weight, int count, uint8_t* out);

  // Linear interpolation of a column and its tint at rows (row_q16 + i step_q16) / 65536 >= 0:
  // out[i] = (column[r] (64 - f) + column[r + 1] f + 32) >> 6 with r the row's integer part, f the first 6 bits of the
  // rest. 0 < step_q16. The columns may be read kPadding past the last row needed.
  void (*resample_rows)(const Tinted<const uint8_t>& column, int64_t row_q16, int32_t step_q16, int count,
                        const Tinted<uint8_t>& out);

  // mask[i] = 255 where surface[(row_q16 + i step_q16) / 65536] <= limit, else 0.
  void (*test_visibility)(const uint16_t* surface, int64_t row_q16, int32_t step_q16, int limit, int count,
                          uint8_t* mask);

  // Robust variance over `views` samples (2 .. kMaxViews) of each row, the first being the camera nearest to the rays.
  // It is the reference, and given back. Two views differ by
  //   max(0, |grey - grey'| - kGreyNoise) + max(0, |tint - tint'| - kTintNoise), at most 255;
  // with d the sorted differences from the reference, d[0] = 0,
  //   phi = min(kLargestVariance, 2 (d[1] + d[2]) + e), two views: 4 d[1],
  //   e = (512 / (views - 3) * (min(d[3], 8) + min(d[4], 8) + ...)) / 256, from four views on:
  // in 1/4 grey level, the mean deviation of the two cameras that agree best with it, and a little of the others'.
  // Beside depth edges most cameras do not see the voxel, so that a median over all of them takes the nearer surface
  // for true. The others tell chance matches apart on surfaces with little texture.
  void (*robust_variance)(const Samples& samples, int views, int count, uint8_t* phi, const Tinted<uint8_t>& reference);

  // The same over the samples whose mask is 255; the reference is the first of them. Where one is left phi
  // = prior, where none is kLargestVariance and the reference 128. 1 <= views <= kMaxViews.
  void (*masked_robust_variance)(const Samples& samples, const uint8_t* const* masks, int views, int prior, int count,
                                 uint8_t* phi, const Tinted<uint8_t>& reference);

  // low[i] and high[i] = the least and the largest of in[i] .. in[i + 6].
  void (*range7)(const uint8_t* in, int count, uint8_t* low, uint8_t* high);

  // The contrast of windows of 7 columns' ranges: with grey the largest high[k].grey[i] less the least low[k].grey[i],
  // and tint alike, out[i] = max(grey, tint / 2).
  void (*contrast7)(const Tinted<const uint8_t>* low, const Tinted<const uint8_t>* high, int count, uint8_t* out);

  // out[i] = in[i] + in[i + 1] + ... + in[i + 4].
  void (*sum5)(const uint8_t* in, int count, uint16_t* out);

  // total[i] += entering[i] - leaving[i].
  void (*slide)(const uint16_t* entering, const uint16_t* leaving, int count, uint16_t* total);

  // out[i] = min(in[i], in[i + 1], in[i + 2]); values below 2^15.
  void (*min3_rows)(const uint16_t* in, int count, uint16_t* out);

  // out[i] = min(a[i], b[i], c[i]); values below 2^15.
  void (*min3_columns)(const uint16_t* a, const uint16_t* b, const uint16_t* c, int count, uint16_t* out);

  // The mean of a column's costs over the pixels around each that look like it: adaptive support (Yoon and Kweon, PAMI
  // 2006) with weights of 0 and 1 on every second pixel of a window of 7 x 7, its own among them. cost[k] and grey[k],
  // k = 0 .. 6, are the columns from the third before it on; with n of the 25 greys within kAlike of grey[3][i + 3],
  // and s the sum of their costs, each at most kLargestVariance,
  //   out[i] = (25 s + kBoxShare box[i]) / (n + kBoxShare), rounded down.
  // `box`: sums of 25 costs, which are trusted where few pixels are alike.
  void (*adaptive_support)(const uint8_t* const* cost, const uint8_t* const* grey, const uint16_t* box, int count,
                           uint16_t* out);

  // Where sum[i] / 25 < best[i] (or `first`): best[i] = sum[i] / 25, best_median[i] = median[i].
  void (*keep_best)(const uint16_t* sum, const uint8_t* median, bool first, int count, uint8_t* best,
                    uint8_t* best_median);

  // The weighted medians of a row of windows, and the means beside them. Pixel i's window spans columns i .. i + 10 of
  // all rows (at most 11); its own pixel is column i + 5 of rows[own]. Pixels weigh weights[|grey - own grey|]; with m
  // the first bin up to which at least half of the weight lies, out[i] = the weighted mean of the bins m - 1 .. m + 1,
  // rounded. Pixels without a bin do not count; where the own one has none out[i] is meaningless.
  void (*smooth_row)(const SmoothRow* rows, int row_count, int own, const uint8_t* weights, int count, uint16_t* out);
};

const Kernels& best();   // for the processor at hand
const Kernels& plain();  // for the base instruction set; the same bytes

}  // namespace ldp::sweep::kernels
