#include "core/captures/transforms.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <stdexcept>

#include "core/base/files.h"
#include "core/base/markup_text.h"
#include "core/captures/camera_bounds.h"
#include "core/captures/json_fields.h"
#include "core/captures/json_text.h"
#include "core/captures/opengl_pose.h"
#include "core/photos/images.h"

namespace ldp {
namespace {

using Json = nlohmann::ordered_json;

// One frame's fields with the file's as fall-back, and the words to refuse either.
class FrameFields {
 public:
  FrameFields(const Json& file, const Json& frame, std::string where)
      : file_(file), frame_(frame), where_(std::move(where)) {}

  [[noreturn]] void refuse(const std::string& what) const { throw std::runtime_error(where_ + ": " + what); }

  bool has(const char* key) const { return frame_.contains(key) || file_.contains(key); }

  double number(const char* key) const {
    if (!has(key)) refuse(std::string(key) + " is missing");
    const std::optional<double> value = number_field(holder(key), key);
    if (!value) refuse(std::string(key) + " is not a number");
    return *value;
  }
  double number(const char* key, double otherwise) const { return has(key) ? number(key) : otherwise; }

  double positive(const char* key) const {
    const double value = number(key);
    if (!(value > 0)) refuse(std::string(key) + " must be positive");
    return value;
  }

  int side(const char* key) const {
    const double value = number(key);
    if (value != std::floor(value) || value < 1 || value > kMaxImageSide)
      refuse(std::string(key) + " must be a whole number of pixels from 1 to " + std::to_string(kMaxImageSide));
    return static_cast<int>(value);
  }

  std::string text(const char* key, const std::string& otherwise) const {
    return text_field(holder(key), key).value_or(otherwise);
  }

 private:
  const Json& holder(const char* key) const { return frame_.contains(key) ? frame_ : file_; }

  const Json& file_;
  const Json& frame_;
  std::string where_;
};

double focal(const FrameFields& fields, const char* length, const char* angle, int side) {
  if (fields.has(length)) return fields.positive(length);
  const double radians = fields.positive(angle);
  if (radians >= 3.14) fields.refuse(std::string(angle) + " must be less than pi");
  return side / (2 * std::tan(radians / 2));
}

void refuse_other_models(const FrameFields& fields) {
  for (const char* key : {"k3", "k4"})
    if (fields.number(key, 0) != 0) fields.refuse(std::string(key) + " is not supported: undistort the photos first");
  const std::string model = fields.text("camera_model", "OPENCV");
  for (const char* known : {"OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "PERSPECTIVE"})
    if (model == known) return;
  fields.refuse("camera_model " + model + " is not supported: pinhole cameras with k1 k2 p1 p2 are");
}

Intrinsics intrinsics_of(const FrameFields& fields) {
  refuse_other_models(fields);
  Intrinsics k;
  k.width = fields.side("w");
  k.height = fields.side("h");
  if (!fields.has("fl_x") && !fields.has("camera_angle_x")) fields.refuse("fl_x is missing (and so is camera_angle_x)");
  k.fx = focal(fields, "fl_x", "camera_angle_x", k.width);
  k.fy = fields.has("fl_y") || fields.has("camera_angle_y") ? focal(fields, "fl_y", "camera_angle_y", k.height) : k.fx;
  k.cx = fields.number("cx", k.width / 2.0);
  k.cy = fields.number("cy", k.height / 2.0);
  k.k1 = fields.number("k1", 0);
  k.k2 = fields.number("k2", 0);
  k.p1 = fields.number("p1", 0);
  k.p2 = fields.number("p2", 0);
  if (!has_usual_lengths(k)) fields.refuse("fl_x, fl_y, cx and cy must be at most 4096 times w or h");
  if (!has_usual_distortion(k)) fields.refuse("k1, k2, p1 and p2 must be at most 1e6");
  return k;
}

Eigen::Matrix4d matrix_of(const Json& frame, const FrameFields& fields) {
  const auto rows = frame.find("transform_matrix");
  if (rows == frame.end()) fields.refuse("transform_matrix is missing");
  if (!rows->is_array() || rows->size() < 3 || rows->size() > 4) fields.refuse("transform_matrix must have 4 rows");
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (size_t r = 0; r < rows->size(); ++r) {
    const Json& row = (*rows)[r];
    if (!row.is_array() || row.size() != 4) fields.refuse("transform_matrix must have 4 numbers in each row");
    for (size_t c = 0; c < 4; ++c) {
      if (!row[c].is_number()) fields.refuse("transform_matrix must hold numbers only");
      matrix(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) = row[c].get<double>();
    }
  }
  return matrix;
}

Pose pose_of(const Json& frame, const FrameFields& fields) {
  const Eigen::Matrix4d matrix = matrix_of(frame, fields);
  if (!matrix.allFinite()) fields.refuse("transform_matrix must hold finite numbers only");
  constexpr double kRounding = 1e-6;
  if ((matrix.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > kRounding)
    fields.refuse("transform_matrix must end with the row 0 0 0 1");
  if (!is_near_enough(matrix.topRightCorner<3, 1>()))
    fields.refuse("transform_matrix has its camera farther away than 1e9: check its position");
  const std::optional<Pose> pose = pose_of_opengl(matrix);
  if (!pose)
    fields.refuse(
        "transform_matrix is not a rotation and a position (its columns must be unit, orthogonal and right-handed)");
  return *pose;
}

std::string last_part(const std::string& path) {
  const size_t slash = path.find_last_of("/\\");
  return slash == std::string::npos ? path : path.substr(slash + 1);
}

std::string_view without_extension(std::string_view name) {
  const size_t dot = name.rfind('.');
  return dot == std::string_view::npos || dot == 0 ? name : name.substr(0, dot);
}

// At that byte, where a parser stopped in a word; empty where it stopped behind one, as in a text that was cut short.
std::string_view word_around(std::string_view text, size_t at) {
  const auto is_letter = [&](size_t i) {
    return i < text.size() && std::isalpha(static_cast<unsigned char>(text[i])) != 0;
  };
  if (!is_letter(at)) return {};
  size_t begin = at, end = at;
  while (begin > 0 && is_letter(begin - 1)) --begin;
  while (is_letter(end)) ++end;
  return text.substr(begin, end - begin);
}

// What Python writes for such numbers, and JSON has not.
bool is_no_finite_number(std::string_view word) {
  for (const std::string_view known : {"NaN", "nan", "Infinity", "inf"})
    if (word == known) return true;
  return false;
}

Camera camera_of(const Json& file, const Json& frame, const std::string& where) {
  if (!frame.is_object()) throw std::runtime_error(where + ": is not an object");
  const FrameFields fields(file, frame, where);
  const std::optional<std::string> path = text_field(frame, "file_path");
  if (!path) fields.refuse("file_path is missing");
  const std::string name = last_part(*path);
  if (name.empty() || name == "." || name == "..") fields.refuse("file_path names no file");
  if (name.find('\0') != std::string::npos) fields.refuse("file_path holds a NUL, which no name of a file can");
  const FrameFields named(file, frame, where + " (" + name + ")");
  return {name, intrinsics_of(named), pose_of(frame, named)};
}

bool same(const Intrinsics& a, const Intrinsics& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy &&
         a.k1 == b.k1 && a.k2 == b.k2 && a.p1 == b.p1 && a.p2 == b.p2;
}

void put(Json& json, const Intrinsics& k) {
  json["w"] = k.width;
  json["h"] = k.height;
  json["fl_x"] = k.fx;
  json["fl_y"] = k.fy;
  json["cx"] = k.cx;
  json["cy"] = k.cy;
  json["k1"] = k.k1;
  json["k2"] = k.k2;
  json["p1"] = k.p1;
  json["p2"] = k.p2;
}

Json rows_of(const Pose& pose) {
  const Eigen::Matrix4d matrix = opengl_matrix(pose);
  Json rows = Json::array();
  for (Eigen::Index r = 0; r < 3; ++r) rows.push_back({matrix(r, 0), matrix(r, 1), matrix(r, 2), matrix(r, 3)});
  rows.push_back({0, 0, 0, 1});
  return rows;
}

}  // namespace

std::vector<Camera> parse_transforms(std::string_view text, const std::string& name) {
  Json json;
  try {
    json = Json::parse(text);
  } catch (const Json::parse_error& error) {
    const std::string_view before = text.substr(0, std::min(error.byte > 0 ? error.byte - 1 : 0, text.size()));
    const std::string line = std::to_string(1 + std::count(before.begin(), before.end(), '\n'));
    const std::string word(word_around(text, before.size()));
    if (is_no_finite_number(word))
      throw std::runtime_error(name + ": " + word + " in line " + line + ": give finite numbers only");
    throw std::runtime_error(name + ": not valid JSON in line " + line + ": was it cut short or edited by hand?");
  } catch (const Json::exception&) {
    throw std::runtime_error(name + ": not valid JSON: a number in it is too large");
  }
  if (!json.is_object() || !json.contains("frames") || !json["frames"].is_array())
    throw std::runtime_error(name + ": no list \"frames\": is this a transforms.json?");
  std::vector<Camera> cameras;
  std::set<std::string> names;
  for (const Json& frame : json["frames"]) {
    const std::string where = name + ": frame " + std::to_string(cameras.size());
    cameras.push_back(camera_of(json, frame, where));
    if (!names.insert(cameras.back().name).second)
      throw std::runtime_error(where + ": a second frame named " + cameras.back().name);
  }
  return cameras;
}

std::vector<Camera> read_transforms(const std::filesystem::path& file) {
  const std::vector<uint8_t> bytes = read_file(file);
  return parse_transforms({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, file.string());
}

std::string transforms_json(std::span<const Camera> cameras) {
  const bool shared = !cameras.empty() && std::all_of(cameras.begin(), cameras.end(), [&](const Camera& camera) {
    return same(camera.intrinsics, cameras.front().intrinsics);
  });
  Json json;
  json["software"] = "ldp";
  json["camera_model"] = "OPENCV";
  if (shared) put(json, cameras.front().intrinsics);
  json["frames"] = Json::array();
  for (const Camera& camera : cameras) {
    Json frame;
    frame["file_path"] = utf8(camera.name);
    if (!shared) put(frame, camera.intrinsics);
    frame["transform_matrix"] = rows_of(camera.pose);
    json["frames"].push_back(std::move(frame));
  }
  return json_text(json, 1) + "\n";
}

void write_transforms(const std::filesystem::path& file, std::span<const Camera> cameras) {
  write_file(file, transforms_json(cameras));
}

const Camera* find_camera(std::span<const Camera> cameras, std::string_view photo_name) {
  const std::string as_text = utf8(photo_name);  // as it is written
  const auto is_named = [&](std::string_view name, auto part) {
    return part(name) == part(photo_name) || part(name) == part(as_text);
  };
  for (const Camera& camera : cameras)
    if (is_named(camera.name, [](std::string_view name) { return name; })) return &camera;
  for (const Camera& camera : cameras)
    if (is_named(camera.name, without_extension)) return &camera;
  return nullptr;
}

}  // namespace ldp
