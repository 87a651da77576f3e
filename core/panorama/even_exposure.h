// Back from local to even exposure.
#pragma once

#include "core/base/job.h"
#include "core/panorama/panorama.h"

namespace ldp {

// Takes the factors by direction out of the colours of all layers: every pixel gets as much less light, or more, as
// response_curve.h has it. What is white stays white, and where colours get brighter their 8 bits show
// as steps. Nothing changes where colours are at even exposure already.
void even_out(LayeredPanorama& panorama, const Job& job = {});

}  // namespace ldp
