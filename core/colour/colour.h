// The colour of every pixel of a layer: which photograph it is taken from (a graph cut, paper 3.3.2), then its value.
#pragma once

#include <vector>

#include "disparity.h"
#include "frames.h"
#include "geometry.h"
#include "job.h"
#include "upright.h"

namespace ldp {}  // namespace ldp
