// How much memory the stages after the poses hold at most: what `--memory` compares.
#pragma once

#include <cstddef>

namespace ldp {

// Bytes of the whole process, from the pixels of the panorama, those of all upright frames together, and the layers.
// An estimate: on eight sweeps of 13 to 30 frames with panoramas of 0.5 to 8.6 megapixels never below what was used, at
// most twice of it.
size_t expected_peak_bytes(size_t panorama_px, size_t upright_px, int layers);

}  // namespace ldp
