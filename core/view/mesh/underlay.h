// One layer more, made up: continues the deepest surfaces some pixels underneath the nearer ones beside them, where no
// layer shows what is there. Silhouettes lie up to half a matching window beside the truth, and without this a small
// step aside opens cracks along all of them. What is further behind stays a hole.
#pragma once

#include <vector>

#include "core/view/mesh/prepared_layer.h"

namespace ldp::view {

// Layers of one size, at least one. Colours are those of the edge.
PreparedLayer make_underlay(const std::vector<PreparedLayer>& layers, const CodedDepths& depths, float parallax);

}  // namespace ldp::view
