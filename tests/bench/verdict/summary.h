// How well verdicts hold over many judged sweeps, good and spoiled.
#pragma once

#include <string>
#include <vector>

#include "tests/bench/verdict/judged_sweep.h"

namespace ldp {

// Lines of text: rank correlation of expected and true PSNR, median error, how many of the sweeps are told whose views
// are more than 6 dB worse than the clean one's of that seed, how many clean ones are, each miss by name.
std::string summary_of(const std::vector<JudgedSweep>& sweeps);

}  // namespace ldp
