#include "core/panorama/file/records.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/base/markup_text.h"

namespace ldp::file {
namespace {

constexpr int kMaxCameras = 4096;
constexpr int kMaxEntries = 4096;
constexpr int kMaxText = 65535;
constexpr int kMaxExposureNodes = 256;  // along a side
constexpr int kMaxImageWidth = 1 << 16;
constexpr uint8_t kWraps = 1, kClosed = 2;
constexpr double kRotationTolerance = 1e-6;

void put(ByteWriter& out, const Eigen::Vector3d& v) {
  for (Eigen::Index i = 0; i < 3; ++i) out.f64(v(i));
}

void put(ByteWriter& out, const Eigen::Matrix3d& m) {
  for (Eigen::Index r = 0; r < 3; ++r)
    for (Eigen::Index c = 0; c < 3; ++c) out.f64(m(r, c));
}

void put(ByteWriter& out, const std::string& text) {
  if (text.size() > kMaxText) throw std::logic_error("a text of an .ldp file has at most 65535 bytes");
  out.u16(static_cast<uint16_t>(text.size()));
  out.append(std::string_view(text));
}

Eigen::Vector3d vector_from(ByteReader& in, const char* field) {
  Eigen::Vector3d v;
  for (Eigen::Index i = 0; i < 3; ++i) v(i) = in.finite(field);
  return v;
}

Eigen::Matrix3d rotation_from(ByteReader& in, const char* field) {
  Eigen::Matrix3d m;
  for (Eigen::Index r = 0; r < 3; ++r)
    for (Eigen::Index c = 0; c < 3; ++c) m(r, c) = in.finite(field);
  const double skew = (m.transpose() * m - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (skew > kRotationTolerance || m.col(0).cross(m.col(1)).dot(m.col(2)) < 0)
    in.place().refuse(field, "a rotation", "another matrix");
  return m;
}

double at_least(ByteReader& in, const char* field, double least) {
  const double value = in.finite(field);
  if (value < least) in.place().refuse(field, "at least " + std::to_string(least), std::to_string(value));
  return value;
}

double positive(ByteReader& in, const char* field) {
  const double value = in.finite(field);
  if (!(value > 0)) in.place().refuse(field, "a positive number", std::to_string(value));
  return value;
}

Arc read_arc(ByteReader& in) {
  Arc arc;
  arc.centre = vector_from(in, "arc centre");
  arc.world_from_arc = rotation_from(in, "arc axes");
  arc.radius = at_least(in, "arc radius", 0);
  arc.theta_begin = in.finite("theta_begin");
  arc.theta_end = in.finite("theta_end");
  if (arc.theta_end < arc.theta_begin)
    in.place().refuse("theta_end", "at least theta_begin", std::to_string(arc.theta_end));
  return arc;
}

void read_sampling(ByteReader& in, PanoramaGrid& grid) {
  grid.theta_left = in.finite("theta_left");
  grid.theta_pitch = positive(in, "theta_pitch");
  grid.v_top = in.finite("v_top");
  grid.v_pitch = positive(in, "v_pitch");
  grid.w_far = at_least(in, "w_far", 0);
  grid.w_near = at_least(in, "w_near", grid.w_far);
  const double turn = grid.theta_pitch * grid.width;
  if (grid.wraps && std::abs(turn - 2 * std::numbers::pi) > 1e-6)
    in.place().refuse("theta_pitch x width of a panorama that wraps", "a full turn, 6.283185", std::to_string(turn));
}

void check_pixels(const ByteReader& in, const PanoramaGrid& grid, const LdpReadLimits& limits) {
  const int64_t pixels = int64_t{grid.width} * grid.height;
  const int64_t most = std::min(kMaxLdpPixels, limits.max_pixels);
  if (pixels > most) in.place().refuse("width x height", "at most " + std::to_string(most), std::to_string(pixels));
}

void put(ByteWriter& out, const Intrinsics& k) {
  out.u32(static_cast<uint32_t>(k.width));
  out.u32(static_cast<uint32_t>(k.height));
  for (const double value : {k.fx, k.fy, k.cx, k.cy, k.k1, k.k2, k.p1, k.p2}) out.f64(value);
}

Intrinsics intrinsics_from(ByteReader& in) {
  Intrinsics k;
  k.width = in.whole("width of a camera's image", 1, kMaxImageWidth);
  k.height = in.whole("height of a camera's image", 1, kMaxImageWidth);
  k.fx = positive(in, "fx");
  k.fy = positive(in, "fy");
  k.cx = in.finite("cx");
  k.cy = in.finite("cy");
  k.k1 = in.finite("k1");
  k.k2 = in.finite("k2");
  k.p1 = in.finite("p1");
  k.p2 = in.finite("p2");
  return k;
}

// Entries must come in ascending order of their keys, so that a map has one form.
template <typename Value>
void insert_next(std::map<std::string, Value>& map, std::string key, Value value, const Place& place) {
  if (!map.empty() && key <= map.rbegin()->first)
    place.refuse("order of keys", "ascending", "'" + key + "' out of order");
  map.emplace_hint(map.end(), std::move(key), std::move(value));
}

template <typename Value, typename Put>
std::vector<uint8_t> write_map(const std::map<std::string, Value>& map, Put put_value) {
  if (map.size() > kMaxEntries) throw std::logic_error("an .ldp file has at most 4096 entries of a kind");
  ByteWriter out;
  out.u32(static_cast<uint32_t>(map.size()));
  for (const auto& [key, value] : map) {
    put(out, key);
    put_value(out, value);
  }
  return std::move(out.bytes);
}

template <typename Value, typename Get>
std::map<std::string, Value> read_map(ByteReader& in, Get get_value) {
  std::map<std::string, Value> map;
  const int count = in.whole("number of entries", 0, kMaxEntries);
  for (int i = 0; i < count; ++i) {
    std::string key = in.text(in.u16());
    insert_next(map, std::move(key), get_value(in), in.place());
  }
  in.expect_end();
  return map;
}

}  // namespace

int strip_count(const PanoramaGrid& grid, int strip_px) { return (grid.width + strip_px - 1) / strip_px; }

std::vector<uint8_t> write_head(const Head& head) {
  const PanoramaGrid& grid = head.grid;
  ByteWriter out;
  out.u32(static_cast<uint32_t>(grid.width));
  out.u32(static_cast<uint32_t>(grid.height));
  out.u8(static_cast<uint8_t>(head.layers));
  out.u8(static_cast<uint8_t>(grid.rays));
  out.u8(static_cast<uint8_t>((grid.wraps ? kWraps : 0) | (grid.arc.closed ? kClosed : 0)));
  out.u8(0);
  put(out, grid.arc.centre);
  put(out, grid.arc.world_from_arc);
  for (const double value :
       {grid.arc.radius, grid.arc.theta_begin, grid.arc.theta_end, grid.theta_left, grid.theta_pitch, grid.v_top,
        grid.v_pitch, grid.w_far, grid.w_near, head.limits.inner_radius, head.limits.outer_radius, head.limits.height})
    out.f64(value);
  return std::move(out.bytes);
}

Head read_head(ByteReader in, const LdpReadLimits& limits) {
  Head head;
  PanoramaGrid& grid = head.grid;
  grid.width = in.whole("width", 1, kMaxLdpWidth);
  grid.height = in.whole("height", 1, kMaxLdpHeight);
  check_pixels(in, grid, limits);
  head.layers = in.choice("number of layers", kMaxLdpLayers);
  if (head.layers < 1) in.place().refuse("number of layers", "1 to 8", "0");
  grid.rays = static_cast<Rays>(in.choice("kind of rays", 1));
  const uint8_t flags = in.choice("flags", kWraps | kClosed);
  grid.wraps = (flags & kWraps) != 0;
  in.choice("reserved byte", 0);
  grid.arc = read_arc(in);
  grid.arc.closed = (flags & kClosed) != 0;
  read_sampling(in, grid);
  head.limits.inner_radius = at_least(in, "inner viewing radius", 0);
  head.limits.outer_radius = at_least(in, "outer viewing radius", 0);
  head.limits.height = at_least(in, "viewing height", 0);
  in.expect_end();
  return head;
}

void check_work(const Head& head, uint64_t file_bytes, const Place& place) {
  const uint64_t most = kEasyLdpPixels + kMaxLdpPixelsPerByte * file_bytes;
  const auto pixels = static_cast<uint64_t>(int64_t{head.grid.width} * head.grid.height * head.layers);
  if (pixels > most)
    place.refuse("width x height x layers",
                 "at most " + std::to_string(most) + " in " + std::to_string(file_bytes) + " bytes",
                 std::to_string(pixels));
}

std::vector<uint8_t> write_layer_record(const LayerRecord& record) {
  ByteWriter out;
  out.u32(static_cast<uint32_t>(record.summary.block_px));
  out.u32(static_cast<uint32_t>(record.summary.strip_px));
  out.u64(record.summary.present_pixels);
  out.u8(record.range.low);
  out.u8(record.range.high);
  out.u8(record.summary.has_alpha);
  out.u8(0);
  return std::move(out.bytes);
}

LayerRecord read_layer_record(ByteReader in, const PanoramaGrid& grid) {
  LayerRecord record;
  LdpLayerSummary& layer = record.summary;
  layer.block_px = in.whole("block size", 0, kMaxLdpBlock);
  layer.strip_px = in.whole("strip width", 16, kMaxLdpWidth);
  if (layer.strip_px % 16 != 0 || (layer.block_px > 0 && layer.strip_px % layer.block_px != 0))
    in.place().refuse("strip width", "a multiple of 16 and of the block size", std::to_string(layer.strip_px));
  if (layer.strip_px > kMaxLdpStrip)
    in.place().refuse("strip width", "at most " + std::to_string(kMaxLdpStrip), std::to_string(layer.strip_px));
  layer.present_pixels = in.u64();
  const auto pixels = static_cast<uint64_t>(int64_t{grid.width} * grid.height);
  if (layer.present_pixels > pixels)
    in.place().refuse("number of present pixels", "at most " + std::to_string(pixels),
                      std::to_string(layer.present_pixels));
  record.range.low = in.u8();
  record.range.high = in.u8();
  if (record.range.low > record.range.high || (layer.block_px > 0 && record.range.high > 0))
    in.place().refuse("range", layer.block_px > 0 ? "0 and 0 with block ranges" : "low <= high",
                      std::to_string(record.range.low) + " and " + std::to_string(record.range.high));
  layer.has_alpha = in.choice("alpha", 1) == 1;
  in.choice("reserved byte", 0);
  in.expect_end();
  return record;
}

std::vector<uint8_t> write_cameras(const std::vector<Camera>& cameras) {
  if (cameras.size() > kMaxCameras) throw std::logic_error("an .ldp file has at most 4096 cameras");
  ByteWriter out;
  out.u32(static_cast<uint32_t>(cameras.size()));
  for (const Camera& camera : cameras) {
    put(out, utf8(camera.name));
    put(out, camera.intrinsics);
    put(out, camera.pose.world_from_camera);
    put(out, camera.pose.centre);
  }
  return std::move(out.bytes);
}

std::vector<Camera> read_cameras(ByteReader in) {
  std::vector<Camera> cameras;
  const int count = in.whole("number of cameras", 0, kMaxCameras);
  for (int i = 0; i < count; ++i) {
    Camera camera;
    camera.name = in.text(in.u16());
    camera.intrinsics = intrinsics_from(in);
    camera.pose.world_from_camera = rotation_from(in, "rotation of a camera");
    camera.pose.centre = vector_from(in, "centre of a camera");
    cameras.push_back(std::move(camera));
  }
  in.expect_end();
  return cameras;
}

std::vector<uint8_t> write_quality(const std::map<std::string, double>& quality) {
  return write_map(quality, [](ByteWriter& out, double value) { out.f64(value); });
}

std::map<std::string, double> read_quality(ByteReader in) {
  return read_map<double>(in, [](ByteReader& from) { return from.f64(); });
}

std::vector<uint8_t> write_metadata(const std::map<std::string, std::string>& metadata) {
  return write_map(metadata, [](ByteWriter& out, const std::string& value) { put(out, utf8(value)); });
}

std::map<std::string, std::string> read_metadata(ByteReader in) {
  return read_map<std::string>(in, [](ByteReader& from) { return from.text(from.u16()); });
}

std::vector<uint8_t> write_exposure(const DisplayExposure& exposure) {
  ByteWriter out;
  for (size_t i = 1; i < ResponseCurve::kKnots; ++i) out.u32(exposure.response.light[i]);
  out.u32(static_cast<uint32_t>(exposure.factors.nodes.width));
  out.u32(static_cast<uint32_t>(exposure.factors.nodes.height));
  for (const auto& node : exposure.factors.nodes.samples)
    for (const uint16_t factor : node) out.u16(factor);
  return std::move(out.bytes);
}

DisplayExposure read_exposure(ByteReader in, const PanoramaGrid& grid) {
  DisplayExposure exposure;
  auto& light = exposure.response.light;
  for (size_t i = 1; i < light.size(); ++i) {
    light[i] = in.u32();
    if (light[i] <= light[i - 1]) in.place().refuse("the response", "rising light", std::to_string(light[i]));
  }
  const int columns = in.whole("columns of the exposure", 1, kMaxExposureNodes);
  const int rows = in.whole("rows of the exposure", 1, kMaxExposureNodes);
  exposure.factors.wraps = grid.wraps;
  exposure.factors.nodes = {columns, rows};
  for (auto& node : exposure.factors.nodes.samples)
    for (uint16_t& factor : node) {
      factor = in.u16();
      if (factor == 0) in.place().refuse("a factor of the exposure", "1 to 65535", "0");
    }
  in.expect_end();
  return exposure;
}

}  // namespace ldp::file
