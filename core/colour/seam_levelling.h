// Seam levelling: steps of brightness between photographs, spread over the surfaces on both sides of their border.
//
// A gradient-domain correction in little memory: an offset per channel for every (cell, photograph) pair, so that
// offsets may jump where photographs meet and are smooth elsewhere. Minimises (2)
//   sum over borders (o_a - o_b - step)^2 + k sum over neighbouring cells of one photograph (o - o')^2 + e sum o^2.
#pragma once

#include <functional>
#include <vector>

#include "core/colour/colour.h"
#include "core/colour/photo_sampler.h"

namespace ldp::colour {

constexpr int kSides[4][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}};  // steps in x and y

// At a pixel of photograph `own`, beside one of photograph `other`, on the same surface: what `other` shows there.
struct SeamSample {
  int x = 0, y = 0;
  int own = 0, other = 0;
  uint8_t side = 0;  // where `other` begins: an index of kSides
  Colour step{};     // other minus own
};

// Calls what it is given for each sample, in any order that does not depend on threads.
using SeamSamples = std::function<void(const std::function<void(const SeamSample&)>&)>;

// Changes the colours of all tasks.
void level_seams(const PanoramaGrid& grid, const std::vector<ColourTask>& tasks, const SeamSamples& for_each_sample,
                 const ColourOptions& options, const Job& job);

}  // namespace ldp::colour
