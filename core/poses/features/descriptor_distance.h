// Descriptor distance: the inner loops of matching descriptors, integers only, one loop nest each.
//
// Compiled once for the base instruction set and, on x86-64, once for AVX2; both give the same numbers.
#pragma once

#include <cstdint>

namespace ldp::sfm::descriptor_distance {

constexpr int kLength = 128;  // numbers of a descriptor

// The nearest and second nearest so far of each of many descriptors: squared distances, and who the nearest is.
struct NearestRow {
  int *best, *second, *index;
};

struct Kernels {
  // out[j] = squared + squares[j] - 2 (inner product of `one` and the j-th of those that follow each other in
  // `others`), which is their squared distance if `squared` and `squares` are squared lengths.
  void (*distances)(const int16_t* one, int squared, const int16_t* others, const int* squares, int count, int* out);

  // Descriptor `candidate` is at these distances from each.
  void (*update_nearest)(const int* distances, int candidate, int count, const NearestRow& nearest);

  int (*minimum)(const int* distances, int count);  // count > 0
};

const Kernels& best();   // for the processor at hand
const Kernels& plain();  // for the base instruction set; the same numbers

}  // namespace ldp::sfm::descriptor_distance
