// The circle of a path seen from above, in the arc's plane.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace ldp::arcs {

struct Circle {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius = 0;
};

struct FlatCamera {
  Eigen::Vector2d centre, forward;  // in the arc's plane; forward is of unit length
};

// Weight of a residual whose square, in squares of what is usual, is given.
inline double cauchy_weight(double squared) { return 1 / (1 + squared); }

// Of cameras that look outward, robustly; none where they do not go round anything. `scale`: spread of the centres.
std::optional<Circle> fit_circle(const std::vector<FlatCamera>& cameras, double scale);

double path_length(const std::vector<FlatCamera>& cameras);  // of its projection on its main direction

// Whether a path that hardly bends goes along the line of sight rather than across it.
bool goes_forward(const std::vector<FlatCamera>& cameras);

// For a path that hardly bends. Across the line of sight: the circle is so large that it hardly bends either, and
// touches the path where the cameras stand, on the side away from where they look. Along it no circle means anything,
// and rays that start on one would see nothing the cameras see: a point as far back as the camera farthest back.
Circle straight_circle(const std::vector<FlatCamera>& cameras);

}  // namespace ldp::arcs
