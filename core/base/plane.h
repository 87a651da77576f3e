// A two-dimensional array of samples, row-major, and the pixel types stored in it.
//
// Coordinates: x grows to the right (0 .. width-1), y grows downwards (0 .. height-1). The centre of pixel (x, y)
// lies at (x + 0.5, y + 0.5) in continuous image coordinates; so the image spans [0, width] x [0, height].
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/memory/large_arrays.h"

namespace ldp {

// An 8-bit sRGB colour, as stored in photographs (gamma-coded).
struct Rgb {
  uint8_t r = 0, g = 0, b = 0;
  friend bool operator==(const Rgb&, const Rgb&) = default;
};

template <typename T>
using Samples = std::vector<T, LargeArrays<T>>;

template <typename T>
struct Plane {
  int width = 0, height = 0;
  Samples<T> samples;  // width * height, row by row

  Plane() = default;
  Plane(int w, int h, T value = T{})
      : width(w), height(h), samples(static_cast<size_t>(w) * static_cast<size_t>(h), value) {}

  bool empty() const { return samples.empty(); }
  bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  size_t index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
  }
  T& at(int x, int y) { return samples[index(x, y)]; }
  const T& at(int x, int y) const { return samples[index(x, y)]; }
  T* row(int y) { return samples.data() + index(0, y); }
  const T* row(int y) const { return samples.data() + index(0, y); }
  friend bool operator==(const Plane&, const Plane&) = default;
};

using RgbImage = Plane<Rgb>;
using GreyImage = Plane<uint8_t>;

}  // namespace ldp
