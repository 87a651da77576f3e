// What synthetic scenes are made of. `foot` is where a thing stands, `angle` and `distance` where it is seen from the
// origin; lengths in metres, angles in radians. Shapes, materials and places of details are drawn from b.random.
#pragma once

#include "sim/scene/scene_builder.h"

namespace ldp::scene {

// Outdoors.
void foliage(SceneBuilder& b, const Vector3d& centre, const Vector3d& spread, int count, double leaf_length);
void tree(SceneBuilder& b, const Vector3d& foot, double height, int leaves);
void figure(SceneBuilder& b, const Vector3d& foot);                                // stands, facing the origin
void figure(SceneBuilder& b, const Vector3d& foot, double facing, double stride);  // walks: a step each half turn
void house(SceneBuilder& b, double angle, double distance, const Vector3d& half);
void houses(SceneBuilder& b, int count, double nearest, double farthest);
void railing(SceneBuilder& b, double radius, double from, double to, double spacing);
void wire(SceneBuilder& b, const Vector3d& from, const Vector3d& to, const Material& m);
void tuft(SceneBuilder& b, const Vector3d& foot, double height, int stalks);
void lamp_post(SceneBuilder& b, const Vector3d& foot, double height);
void planter(SceneBuilder& b, const Vector3d& foot, double height, int leaves);
void low_wall(SceneBuilder& b, double angle, double distance, double half_width, double height);
void countryside(SceneBuilder& b);

// Indoors.
void table(SceneBuilder& b, const Vector3d& foot, double yaw);
void bookshelf(SceneBuilder& b, const Vector3d& foot, double yaw);
void walls(SceneBuilder& b, double west, double east, double south, double north);

}  // namespace ldp::scene
