#include "core/captures/colmap.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace ldp {
namespace {

std::string number(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), " %.17g", value);
  return text.data();
}

using Lens = std::array<double, 10>;

Lens lens_of(const Intrinsics& k) {
  return {static_cast<double>(k.width), static_cast<double>(k.height), k.fx, k.fy, k.cx, k.cy, k.k1, k.k2, k.p1, k.p2};
}

// Index of every camera's lens among the different ones.
std::vector<size_t> share_lenses(std::span<const Camera> cameras, std::vector<Lens>& lenses) {
  std::vector<size_t> index;
  for (const Camera& camera : cameras) {
    const Lens lens = lens_of(camera.intrinsics);
    const auto place = std::find(lenses.begin(), lenses.end(), lens);
    index.push_back(static_cast<size_t>(place - lenses.begin()));
    if (place == lenses.end()) lenses.push_back(lens);
  }
  return index;
}

std::string cameras_text(const std::vector<Lens>& lenses) {
  std::string text = "# CAMERA_ID MODEL WIDTH HEIGHT fx fy cx cy k1 k2 p1 p2\n";
  for (size_t i = 0; i < lenses.size(); ++i) {
    text += std::to_string(i + 1) + " OPENCV";
    for (const double value : lenses[i]) text += number(value);
    text += "\n";
  }
  return text;
}

std::string image_line(const Camera& camera, size_t image, size_t lens) {
  const Eigen::Matrix3d camera_from_world = camera.pose.world_from_camera.transpose();
  const Eigen::Quaterniond q(camera_from_world);
  const Eigen::Vector3d t = -camera_from_world * camera.pose.centre;
  std::string text = std::to_string(image + 1);
  for (const double value : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}) text += number(value);
  return text + number(static_cast<double>(lens + 1)) + " " + camera.name + "\n";
}

// Root of the mean square distance between where a point is seen and where it should be.
double error_px(const ColmapModel& model, size_t point) {
  const ScenePoint& p = model.points[point];
  double sum = 0;
  for (size_t i = 0; i < p.cameras.size(); ++i) {
    const Camera& camera = model.cameras[static_cast<size_t>(p.cameras[i])];
    const Eigen::Vector3d x = camera.pose.world_from_camera.transpose() * (p.position - camera.pose.centre);
    if (x.z() > 0) sum += (project(camera.intrinsics, x) - model.sightings[point][i]).squaredNorm();
  }
  return std::sqrt(sum / std::max(1.0, static_cast<double>(p.cameras.size())));
}

void check(const ColmapModel& model) {
  if (model.sightings.size() != model.points.size() ||
      (!model.colours.empty() && model.colours.size() != model.points.size())) {
    throw std::logic_error("colmap_text: sightings and colours must be as many as points");
  }
  for (size_t i = 0; i < model.points.size(); ++i) {
    if (model.sightings[i].size() != model.points[i].cameras.size())
      throw std::logic_error("colmap_text: point " + std::to_string(i) + " has not one sighting per camera");
  }
}

}  // namespace

ColmapText colmap_text(const ColmapModel& model) {
  check(model);
  std::vector<Lens> lenses;
  const std::vector<size_t> lens = share_lenses(model.cameras, lenses);
  ColmapText text{cameras_text(lenses),
                  "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then X Y POINT3D_ID of each point\n",
                  "# POINT3D_ID X Y Z R G B ERROR, then IMAGE_ID POINT2D_IDX of each image\n"};
  std::vector<std::string> seen(model.cameras.size());
  std::vector<int> count(model.cameras.size(), 0);
  for (size_t i = 0; i < model.points.size(); ++i) {
    const ScenePoint& point = model.points[i];
    const std::array<uint8_t, 3> colour =
        model.colours.empty() ? std::array<uint8_t, 3>{128, 128, 128} : model.colours[i];
    const std::string id = std::to_string(i + 1);
    text.points += id + number(point.position.x()) + number(point.position.y()) + number(point.position.z());
    for (const uint8_t channel : colour) text.points += number(channel);
    text.points += number(error_px(model, i));
    for (size_t j = 0; j < point.cameras.size(); ++j) {
      const size_t camera = static_cast<size_t>(point.cameras[j]);
      const Eigen::Vector2d& p = model.sightings[i][j];
      seen[camera] += number(p.x()) + number(p.y()) + number(static_cast<double>(i + 1));
      text.points += number(static_cast<double>(camera + 1)) + number(count[camera]++);
    }
    text.points += "\n";
  }
  for (size_t i = 0; i < model.cameras.size(); ++i)
    text.images += image_line(model.cameras[i], i, lens[i]) + (seen[i].empty() ? "" : seen[i].substr(1)) + "\n";
  return text;
}

}  // namespace ldp
