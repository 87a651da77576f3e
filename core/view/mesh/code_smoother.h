// Depth codes smoothed within what their rounding hides.
#pragma once

#include "core/view/mesh/prepared_layer.h"

namespace ldp::view {

// Takes the steps out of coarsely coded surfaces (a block that an edge crosses has one range for both sides): every
// pixel moves towards the mean of its neighbours on the same surface, finely coded ones counting more, but no farther
// than its code's rounding allows.
// `parallax` as in `connected`. Changes layer.w only.
void smooth_codes(PreparedLayer& layer, const CodedDepths& depths, float parallax);

}  // namespace ldp::view
