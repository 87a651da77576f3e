// The inner loops of message passing and of the expansion's unary terms: 16 slots are one vector of 16 bytes.
//
// Messages never exceed truncation * weight <= 255, so they are bytes, and the sums inside a message saturate: what
// saturates could not have been the minimum. Compiled once for the base instruction set and, on x86-64, once for AVX2;
// both give the same bytes.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ldp::solve {

// A LabelGrid and a Smoothness as flat arrays (see there). Pixels of a grid with positions have one grey in all slots.
struct KernelGrid {
  int width = 0, height = 0;
  const uint16_t* cost = nullptr;
  const uint8_t* grey = nullptr;
  const uint8_t* grey_range = nullptr;  // 2 per pixel: least and largest grey
  const uint8_t* position = nullptr;    // modulo 256; nullptr: slot number = position
  const uint8_t* down = nullptr;
  const uint8_t* right = nullptr;
  uint8_t* message = nullptr;
  uint8_t* label = nullptr;
  uint8_t* fresh = nullptr;  // 1 per pixel, not 0 where messages came in that were not yet passed on; at first 3
  int truncation = 0;
  const uint8_t* coarse = nullptr;  // 16 per factor
  const uint8_t* fine = nullptr;    // 16
  const uint8_t* weight = nullptr;  // 256 per factor
};

struct MessageKernels {
  // One pass of sequential tree-reweighted message passing: forward updates messages to lower and right neighbours in
  // pixel order, backward those to upper and left neighbours in reverse order. Columns [begin, end).
  void (*sweep)(const KernelGrid& grid, bool forward, int begin, int end);
  // Labels in pixel order: each pixel takes the best slot given the labels before it and the messages after it.
  void (*decide)(const KernelGrid& grid);
  // Unary cost of moving p to each of the 16 slots, pair terms shared as in Expansion::edge_terms. Returns a bit per
  // slot whose cost is negative.
  unsigned (*gains)(const KernelGrid& grid, int p, int16_t* gain);
  // The first slot of least cost of each of `count` pixels. Costs below 2^15.
  void (*cheapest)(const uint16_t* cost, int count, uint8_t* slot);
  // Least and largest of the 16 greys of each of `count` pixels, 2 per pixel.
  void (*grey_ranges)(const uint8_t* grey, int count, uint8_t* range);
};

const MessageKernels& message_kernels();  // for the processor at hand

namespace base_kernels {
extern const MessageKernels kMessageKernels;
}
#if defined(__x86_64__)
namespace avx2_kernels {
extern const MessageKernels kMessageKernels;
}
#endif

}  // namespace ldp::solve
