// A synthetic world that can be asked what any ray meets: exact distance, colour, and what lies behind.
//
// Takes a description (analytic objects, ground, hills, sky); answers rays in world axes (z up, metres). A ray is
// origin + t * direction with a direction of any length, so that t is z-depth for camera rays with z = 1 and the
// paper's cylinder distance for panorama rays u + v n. Solid objects are met where a ray enters them, leaves and
// pictures from both sides. Bounding-volume hierarchy; safe to use from several threads.
// Colours are linear; there are no shadows but the shade that half of the world may lie in, and no reflections, so a
// point has one colour from everywhere.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "sim/scene/texture.h"

namespace ldp {

enum class Shape : uint8_t { ellipsoid, cylinder, box, quad, leaf };

// Axes are the columns of world_from_local. half: semi-axes of an ellipsoid, half extents of a box, half width and
// half height (x, y) of a quad or leaf, radius (x) and half length (z) of a cylinder.
struct Object {
  Shape shape = Shape::box;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d world_from_local = Eigen::Matrix3d::Identity();
  Eigen::Vector3d half = Eigen::Vector3d::Ones();
  Material material;
  int group = 0;  // objects that move together; 0 = fixed to the ground
};

// A closed curtain of hills or distant woods around the origin: a cylinder of this radius, up to a rolling skyline.
struct Hills {
  double radius = 150, base_height = 5, relief = 8;
  Material material;
};

struct SceneDescription {
  std::vector<Object> objects;
  bool has_ground = true;  // the plane z = 0
  Material ground;
  std::vector<Hills> hills;
  float cloud_cover = 0.5F;  // 0 .. 1
  uint32_t seed = 1;
  Eigen::Vector3d towards_sun = {0.35, 0.45, 0.82};
  float shade = 1;  // share of the light that the half with x < 0 has, as seen from the origin, its sky included
};

struct Ray {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();
  double pixel_size = 0.0014;  // width of a pixel at t = 1; sets how fine a texture may be
};

struct Hit {
  double t = std::numeric_limits<double>::infinity();  // infinity = sky
  int object = -1;                                     // index in the description; < -1 ground and hills; -1 sky
  Eigen::Vector3f colour = Eigen::Vector3f::Zero();    // linear
};

class Scene {
 public:
  explicit Scene(SceneDescription description);

  const SceneDescription& description() const { return description_; }

  // What the ray meets first beyond t_min; the sky when nothing else.
  Hit first_hit(const Ray& ray, double t_min = 0) const;

  // Everything the ray meets, front to back, at most `limit` hits; the last one may be the sky.
  std::vector<Hit> hits(const Ray& ray, int limit) const;

 private:
  static constexpr float kHuge = std::numeric_limits<float>::max();

  // Bounds; the fourth lane is idle and lets the compiler use whole vectors.
  struct Box {
    Eigen::Array4f low = {kHuge, kHuge, kHuge, 0}, high = {-kHuge, -kHuge, -kHuge, 0};

    void add(const Box& other) {
      low = low.min(other.low);
      high = high.max(other.high);
    }
    float area() const {
      const Eigen::Array4f side = high - low;
      return side[0] * side[1] + side[1] * side[2] + side[2] * side[0];
    }
  };
  struct Node {
    Eigen::Array4f low, high;
    int32_t first = 0, count = 0;  // count 0: the children are the next node and node `first`
  };
  struct Solid {  // what the search needs of an object
    Eigen::Matrix3d local_from_world;
    Eigen::Vector3d centre, half;
    Shape shape;
  };
  struct Found {
    double t;
    int object;
    Eigen::Vector3d local;   // meeting point in object axes
    Eigen::Vector3d normal;  // object axes
  };

  int build_node(int first, int count);
  Box bounds_of(int first, int count) const;
  void sort_along(int first, int count, int axis);
  int split(int first, int count, float whole_area);
  void find_among_objects(const Ray& ray, double t_min, Found& found) const;
  void find_ground_and_hills(const Ray& ray, double t_min, Found& found) const;
  Eigen::Vector3f reflected(const Ray& ray, const Found& found) const;
  float light_at(const Eigen::Vector3d& place) const;  // or in a direction: share of full light
  Eigen::Vector3f sky(const Eigen::Vector3d& direction, double pixel_size) const;

  SceneDescription description_;
  std::vector<int> order_;     // objects as the tree's leaves list them
  std::vector<Box> boxes_;     // per object
  std::vector<Solid> solids_;  // in `order_`
  std::vector<Node> nodes_;
};

}  // namespace ldp
