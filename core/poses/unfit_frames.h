// Which photos can be part of a sweep: those of one size, none stored twice, and of many those that show something new.
#pragma once

#include <utility>
#include <vector>

#include "core/base/job.h"
#include "core/photos/left_out.h"
#include "core/poses/frame_pairs.h"

namespace ldp::sfm {

// The size that most frames have, width and height; the others cannot share a lens with them.
std::pair<int, int> common_size(const std::vector<Frame>& frames);

// By frame, why it can be no part of the sweep; none where it can. Of not too many frames no pair is asked for.
std::vector<LeftOut> unfit_frames(const std::vector<Frame>& frames, FramePairs& pairs, const Job& job);

// Throws Impossible, naming the first of the others, where fewer than three can.
void require_three_fit(const std::vector<Frame>& frames, const std::vector<LeftOut>& unfit);

}  // namespace ldp::sfm
