// Layers from disparity: visibility of voxels, and where layers behind the first are wanted (paper 3.3.3, 3.3.4).
#pragma once

#include "disparity.h"
#include "panorama.h"
#include "upright.h"

namespace ldp {}  // namespace ldp
