// The .ldp file a command was given.
#pragma once

#include <string>

#include "core/base/job.h"
#include "core/panorama/panorama.h"

namespace ldp {

// Throws BadInput naming the file: missing, not an .ldp file, or damaged.
LayeredPanorama read_panorama(const std::string& file, const Job& job);

}  // namespace ldp
