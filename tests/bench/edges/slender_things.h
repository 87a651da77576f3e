// How much of what is only a few pixels wide in a view stands in a rendering of it: wires, bars, twigs, blades.
//
// Takes the scene (its cylinders are what is looked for), the true view and a rendering from the same camera. Gives
// lengths in pixels by the things' widths. How: along the axis of every long cylinder, where the true view shows it and
// it stands out against what lies on both sides of it, its colour is looked for in the rendering, within a pixel to
// either side. Nearer to it than to what lies beside it: it stands.
// Does not ask for depths.
#pragma once

#include <array>
#include <cstddef>

#include "core/view/render.h"
#include "sim/scene/scene.h"
#include "tests/bench/true_surfaces.h"

namespace ldp {

// Widths in pixels at which the classes of things begin; the last one's end.
constexpr std::array kSlenderWidths = {1.0, 2.5, 4.0, 6.0};
constexpr size_t kSlenderClasses = kSlenderWidths.size() - 1;

struct SlenderLength {
  long shown = 0;          // pixels of length that the true view shows
  long standing = 0;       // of these
  long longest_break = 0;  // pixels shown one after another, of one thing, that do not stand

  void add(const SlenderLength& other);
};
using SlenderLengths = std::array<SlenderLength, kSlenderClasses>;

// The rendering's size must be the view's.
SlenderLengths slender_lengths(const Scene& scene, const TrueView& truth, const View& rendering);

}  // namespace ldp
