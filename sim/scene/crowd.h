// People who walk by while a sweep is taken, round the photographer, beyond arm's reach.
#pragma once

#include <cstdint>

#include "sim/scene/scene.h"
#include "sim/scene/sweep_path.h"

namespace ldp {

// The scene with people where they are at this frame: as many as hide about `share` (0 .. 1) of the sweep's fullest
// picture; fewer where a scene's own things stand before them (they walk through its walls), and hardly any where one
// alone would fill more of a narrow view. They walk at up to 0.45 m a frame either way, every fourth the way the camera
// turns, half as fast as it or faster, and so stays in sight the longest.
SceneDescription with_crowd(SceneDescription scene, const SweepPath& path, double share, int frame, uint32_t seed);

}  // namespace ldp
