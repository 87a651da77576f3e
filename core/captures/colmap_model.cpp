#include "core/captures/colmap_model.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>

#include "core/base/exact_math.h"
#include "core/base/files.h"
#include "core/captures/camera_bounds.h"
#include "core/captures/transforms.h"
#include "core/photos/images.h"

namespace ldp {
namespace {

struct LensModel {
  const char* name;
  size_t parameters;
};

// By COLMAP's numbers of them.
constexpr std::array<LensModel, 5> kModels = {
    {{"SIMPLE_PINHOLE", 3}, {"PINHOLE", 4}, {"SIMPLE_RADIAL", 4}, {"RADIAL", 5}, {"OPENCV", 8}}};

using Lenses = std::map<int64_t, Intrinsics>;

[[noreturn]] void refuse(const std::string& where, const std::string& what) {
  throw std::runtime_error(where + ": " + what);
}

Intrinsics lens_of(size_t model, int64_t width, int64_t height, const std::vector<double>& p,
                   const std::string& where) {
  if (width < 1 || height < 1 || width > kMaxImageSide || height > kMaxImageSide)
    refuse(where, "sides must be 1 to " + std::to_string(kMaxImageSide) + " pixels");
  if (!std::all_of(p.begin(), p.end(), [](double value) { return std::isfinite(value); }))
    refuse(where, "parameters must be finite numbers");
  Intrinsics k;
  k.width = static_cast<int>(width), k.height = static_cast<int>(height);
  const bool two_focals = model == 1 || model == 4;
  const size_t next = two_focals ? 2 : 1;
  k.fx = p[0], k.fy = two_focals ? p[1] : p[0];
  k.cx = p[next], k.cy = p[next + 1];
  if (model == 2 || model == 3) k.k1 = p[3];
  if (model == 3) k.k2 = p[4];
  if (model == 4) k.k1 = p[4], k.k2 = p[5], k.p1 = p[6], k.p2 = p[7];
  if (!(k.fx > 0) || !(k.fy > 0)) refuse(where, "focal lengths must be positive");
  if (!has_usual_lengths(k))
    refuse(where, "focal lengths and principal point must be at most 4096 times its longer side");
  if (!has_usual_distortion(k)) refuse(where, "distortion must be at most 1e6");
  return k;
}

// Of camera from world: unit quaternion (w, x, y, z) and translation.
Pose pose_of(const std::array<double, 7>& v, const std::string& where) {
  const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3]);
  if (!(std::abs(length - 1) < 1e-3)) refuse(where, "its rotation is no unit quaternion");
  const double w = v[0] / length, x = v[1] / length, y = v[2] / length, z = v[3] / length;
  Pose pose;
  pose.world_from_camera << 1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y),  //
      2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x),                        //
      2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y);
  const Eigen::Vector3d t(v[4], v[5], v[6]);
  if (!t.allFinite()) refuse(where, "its translation must be finite numbers");
  if (!is_near_enough(t)) refuse(where, "its translation must be at most 1e9");
  pose.centre = -exact_product(pose.world_from_camera, t);
  return pose;
}

Camera camera_of(const Lenses& lenses, int64_t lens, const std::string& path, const std::array<double, 7>& pose,
                 const std::string& where) {
  const std::string name = path.substr(path.find_last_of("/\\") + 1);
  if (name.empty()) refuse(where, "has no name");
  const auto found = lenses.find(lens);
  if (found == lenses.end()) refuse(where, "there is no camera " + std::to_string(lens));
  return {name, found->second, pose_of(pose, where)};
}

std::vector<Camera> in_order(std::vector<Camera> cameras) {
  std::sort(cameras.begin(), cameras.end(), [](const Camera& a, const Camera& b) { return a.name < b.name; });
  const auto twice = std::adjacent_find(cameras.begin(), cameras.end(),
                                        [](const Camera& a, const Camera& b) { return a.name == b.name; });
  if (twice != cameras.end()) refuse("images", "two are called " + twice->name);
  return cameras;
}

// Words and numbers of one line.
class Line {
 public:
  Line(std::string_view text, std::string where) : left_(text), where_(std::move(where)) {}

  const std::string& where() const { return where_; }
  std::string_view word() {
    skip_spaces();
    const std::string_view found = left_.substr(0, left_.find_first_of(" \t\r"));
    if (found.empty()) refuse(where_, "ends early");
    left_.remove_prefix(found.size());
    return found;
  }
  std::string_view rest() {
    skip_spaces();
    return left_.substr(0, left_.find_last_not_of(" \t\r") + 1);
  }
  template <typename Number>
  Number number() {
    const std::string_view text = word();
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
      refuse(where_, std::string(text.substr(0, 40)).append(" is not a number"));
    return value;
  }

 private:
  void skip_spaces() { left_.remove_prefix(std::min(left_.find_first_not_of(" \t\r"), left_.size())); }

  std::string_view left_;
  std::string where_;
};

// Without comments. Lines of images.txt come in pairs of which the second may be empty.
std::vector<Line> lines_of(std::string_view text, const std::string& file, bool keep_empty) {
  std::vector<Line> lines;
  for (size_t number = 1; !text.empty(); ++number) {
    const size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const bool empty = line.find_first_not_of(" \t\r") == std::string_view::npos;
    if (!line.starts_with('#') && (keep_empty || !empty))
      lines.emplace_back(line, file + " line " + std::to_string(number));
  }
  return lines;
}

[[noreturn]] void refuse_model(const std::string& model, const std::string& where) {
  refuse(where, "camera model " + model + " is not supported: undistort the photos first (colmap image_undistorter)");
}

size_t model_called(std::string_view name, const std::string& where) {
  for (size_t i = 0; i < kModels.size(); ++i)
    if (kModels[i].name == name) return i;
  refuse_model(std::string(name.substr(0, 40)), where);
}

Lenses parse_lenses(std::string_view text) {
  Lenses lenses;
  for (Line& line : lines_of(text, "cameras.txt", false)) {
    const auto id = line.number<int64_t>();
    const size_t model = model_called(line.word(), line.where());
    const auto width = line.number<int64_t>(), height = line.number<int64_t>();
    std::vector<double> parameters(kModels[model].parameters);
    for (double& value : parameters) value = line.number<double>();
    lenses[id] = lens_of(model, width, height, parameters, line.where());
  }
  return lenses;
}

// Little-endian numbers.
class Bytes {
 public:
  Bytes(std::span<const uint8_t> bytes, std::string file)
      : left_(bytes), whole_(bytes.size()), file_(std::move(file)) {}

  std::string where() const { return file_ + " at byte " + std::to_string(whole_ - left_.size()); }
  uint64_t whole(size_t bytes) {
    uint64_t value = 0;
    for (size_t i = 0; const uint8_t byte : take(bytes)) value |= uint64_t{byte} << (8 * i++);
    return value;
  }
  int64_t id() { return static_cast<int32_t>(whole(4)); }
  double number() { return std::bit_cast<double>(whole(8)); }
  std::string text() {
    const auto end = std::find(left_.begin(), left_.end(), uint8_t{0});
    if (end == left_.end()) refuse(where(), "a name does not end");
    const auto found = take(static_cast<size_t>(end - left_.begin()));
    take(1);
    return {found.begin(), found.end()};
  }
  // How many things follow, each of at least so many bytes.
  uint64_t count(size_t least_bytes) {
    const uint64_t found = whole(8);
    if (found > left_.size() / least_bytes) refuse(where(), "says that more follows than there is");
    return found;
  }
  std::span<const uint8_t> take(size_t count) {
    if (count > left_.size()) refuse(where(), "ends early");
    const auto part = left_.first(count);
    left_ = left_.subspan(count);
    return part;
  }

 private:
  std::span<const uint8_t> left_;
  size_t whole_;
  std::string file_;
};

Lenses parse_lenses(Bytes in) {
  Lenses lenses;
  for (uint64_t left = in.count(4 + 4 + 8 + 8 + 8); left > 0; --left) {
    const std::string where = in.where();
    const int64_t id = in.id(), model = in.id();
    if (model < 0 || static_cast<size_t>(model) >= kModels.size()) refuse_model(std::to_string(model), where);
    const auto width = static_cast<int64_t>(in.whole(8)), height = static_cast<int64_t>(in.whole(8));
    std::vector<double> parameters(kModels[static_cast<size_t>(model)].parameters);
    for (double& value : parameters) value = in.number();
    lenses[id] = lens_of(static_cast<size_t>(model), width, height, parameters, where);
  }
  return lenses;
}

}  // namespace

std::vector<Camera> parse_colmap_text(std::string_view cameras, std::string_view images) {
  const Lenses lenses = parse_lenses(cameras);
  std::vector<Camera> found;
  std::vector<Line> lines = lines_of(images, "images.txt", true);
  for (size_t i = 0; i < lines.size(); i += 2) {
    Line& line = lines[i];
    if (line.rest().empty()) break;  // empty lines after the last image
    line.number<int64_t>();          // its number is of no use here
    std::array<double, 7> pose{};
    for (double& value : pose) value = line.number<double>();
    const auto lens = line.number<int64_t>();
    found.push_back(camera_of(lenses, lens, std::string(line.rest()), pose, line.where()));
  }
  return in_order(std::move(found));
}

std::vector<Camera> parse_colmap_binary(std::span<const uint8_t> cameras, std::span<const uint8_t> images) {
  const Lenses lenses = parse_lenses(Bytes(cameras, "cameras.bin"));
  std::vector<Camera> found;
  Bytes in(images, "images.bin");
  constexpr size_t kSighting = 8 + 8 + 8;
  for (uint64_t left = in.count(4 + 7 * 8 + 4 + 1 + 8); left > 0; --left) {
    const std::string where = in.where();
    in.id();
    std::array<double, 7> pose{};
    for (double& value : pose) value = in.number();
    const int64_t lens = in.id();
    found.push_back(camera_of(lenses, lens, in.text(), pose, where));
    in.take(static_cast<size_t>(in.count(kSighting)) * kSighting);
  }
  return in_order(std::move(found));
}

std::vector<Camera> read_colmap(const std::filesystem::path& folder) {
  const auto text = [&](const char* name) {
    const std::vector<uint8_t> bytes = read_file(folder / name);
    return std::string(bytes.begin(), bytes.end());
  };
  const bool binary = std::filesystem::exists(folder / "images.bin");
  if (!binary && !std::filesystem::exists(folder / "images.txt"))
    refuse(folder.string(), "holds no COLMAP model (images.bin or images.txt): name the folder that does, as sparse/0");
  try {
    return binary ? parse_colmap_binary(read_file(folder / "cameras.bin"), read_file(folder / "images.bin"))
                  : parse_colmap_text(text("cameras.txt"), text("images.txt"));
  } catch (const std::system_error&) {
    throw;
  } catch (const std::runtime_error& error) {
    refuse(folder.string(), error.what());
  }
}

std::vector<Camera> read_cameras(const std::filesystem::path& path) {
  return std::filesystem::is_directory(path) ? read_colmap(path) : read_transforms(path);
}

}  // namespace ldp
