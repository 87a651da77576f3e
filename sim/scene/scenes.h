// The named synthetic scenes. All surround the origin, with the photographer standing there and looking outward from
// about 1.6 m above the ground; things begin about 1 m away and end at infinity.
//
//   garden     trees, leaves and shrubs from 1.5 m on, two figures, houses, hills
//   courtyard  paved court: low wall, planters, lamp posts, figures, house fronts all around
//   room       furnished room with a wall about 1 m from the camera and a window to the outside
//   terrace    railing and pots near by, nothing between 4 m and 20 m, then town, woods and hills
//   repeated   bricks, checks, equal bars and columns: everything looks like its neighbour
//   figures    a square full of people from 1.2 m to 12 m
//   railings   things a few pixels wide: a railing, overhead wires, stalks and twigs before house fronts
#pragma once

#include <string>
#include <vector>

#include "sim/scene/scene.h"

namespace ldp {

const std::vector<std::string>& scene_names();

// Throws std::invalid_argument naming the known scenes when there is none of that name.
SceneDescription make_scene(const std::string& name, uint32_t seed);

// The same scene at a later moment: this share of its movable groups (figures, leaves) has moved, each on its own way.
SceneDescription moved(const SceneDescription& scene, double share, int frame, uint32_t seed);

}  // namespace ldp
