// How the points that photographs share move between them: how many they are, how far they shift, how much of that is
// parallax, and whether they move apart, as they do when the camera goes forward. Of the poses only turns are believed.
#pragma once

#include <vector>

#include "core/geometry/geometry.h"
#include "core/verdict/evidence.h"

namespace ldp {

// Sightings of each point in its cameras [pixels], as structure from motion gives them. Sets the flow and
// the step of each of `evidence.photos`, which stand for the cameras, and `evidence.inward`.
void measure_flow(const std::vector<ScenePoint>& points, const std::vector<std::vector<Eigen::Vector2d>>& sightings,
                  const std::vector<Camera>& cameras, SweepEvidence& evidence);

}  // namespace ldp
