// How far the representation and the renderer carry: builds a panorama from a scene whose true depths are known (layout
// of a rendered scene: transforms.json, frames_depth/*.npy, novel.json, novel/*.png), renders the scene's novel views
// and prints their PSNR (holes as mid-grey) for several depth codes and numbers of layers, holes open and filled, and
// the milliseconds that preparing the panorama and drawing one view take on one thread. S: pixels per pixel of the
// photos.
//
//   perfect_panorama SCENE [--out DIR] [--scale S]
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <nlohmann/json.hpp>

#include "disparity.h"
#include "images.h"
#include "panorama.h"
#include "render.h"

namespace fs = std::filesystem;
using namespace ldp;

namespace {

struct Frame {
  Camera camera;
  RgbImage colour;
  Plane<float> z;
};

float float_from_half(uint16_t h) {
  const int exponent = h >> 10 & 31, mantissa = h & 1023;
  const float sign = (h & 0x8000) != 0 ? -1.0F : 1.0F;
  if (exponent == 31) return mantissa != 0 ? NAN : sign * INFINITY;
  if (exponent == 0) return sign * std::ldexp(static_cast<float>(mantissa), -24);
  return sign * std::ldexp(static_cast<float>(mantissa + 1024), exponent - 25);
}

Plane<float> read_npy(const fs::path& file) {
  const std::vector<uint8_t> bytes = read_file(file);
  const size_t header = static_cast<size_t>(bytes.at(8)) + static_cast<size_t>(bytes.at(9)) * 256;
  const std::string text(bytes.begin() + 10, bytes.begin() + 10 + static_cast<std::ptrdiff_t>(header));
  int height = 0, width = 0;
  const size_t shape = text.find("'shape': (");
  if (shape == std::string::npos || std::sscanf(text.c_str() + shape, "'shape': (%d, %d)", &height, &width) != 2)
    throw std::runtime_error(file.string() + ": not a two-dimensional array");
  const bool half = text.find("<f2") != std::string::npos;
  Plane<float> plane(width, height);
  const uint8_t* data = bytes.data() + 10 + header;
  for (size_t i = 0; i < plane.samples.size(); ++i) {
    if (half) {
      uint16_t h;
      std::memcpy(&h, data + 2 * i, 2);
      plane.samples[i] = float_from_half(h);
    } else {
      std::memcpy(&plane.samples[i], data + 4 * i, 4);
    }
  }
  return plane;
}

std::vector<Camera> read_cameras(const fs::path& file) {
  std::ifstream in(file);
  const auto json = nlohmann::json::parse(in);
  Intrinsics k;
  k.width = json.at("w"), k.height = json.at("h");
  k.fx = json.at("fl_x"), k.fy = json.at("fl_y"), k.cx = json.at("cx"), k.cy = json.at("cy");
  k.k1 = json.value("k1", 0.0), k.k2 = json.value("k2", 0.0), k.p1 = json.value("p1", 0.0),
  k.p2 = json.value("p2", 0.0);
  std::vector<Camera> cameras;
  for (const auto& frame : json.at("frames")) {
    Camera camera{frame.at("file_path"), k, {}};
    const auto& m = frame.at("transform_matrix");
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column)
        camera.pose.world_from_camera(row, column) =
            m[static_cast<size_t>(row)][static_cast<size_t>(column)].get<double>() * (column == 0 ? 1 : -1);
      camera.pose.centre(row) = m[static_cast<size_t>(row)][3];
    }
    cameras.push_back(camera);
  }
  return cameras;
}

std::vector<Frame> read_frames(const fs::path& scene) {
  std::vector<Frame> frames;
  for (const Camera& camera : read_cameras(scene / "transforms.json")) {
    fs::path depth = scene / "frames_depth" / fs::path(camera.name).stem();
    Frame frame{camera, read_image(scene / camera.name), {}};
    if (fs::exists(depth.replace_extension(".npy")))
      frame.z = read_npy(depth);
    else
      frame.z = decode_pfm(read_file(depth.replace_extension(".pfm")), depth.string());
    frames.push_back(std::move(frame));
  }
  return frames;
}

// The circle through camera centres whose axis is the mean of their up vectors.
Arc fit_arc(const std::vector<Frame>& frames) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero(), mean = Eigen::Vector3d::Zero();
  for (const Frame& f : frames) up -= f.camera.pose.world_from_camera.col(1), mean += f.camera.pose.centre;
  mean /= static_cast<double>(frames.size());
  up.normalize();
  Arc arc;
  const Eigen::Vector3d side = (std::abs(up.x()) < 0.9 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY());
  arc.world_from_arc.col(0) = (side - side.dot(up) * up).normalized();
  arc.world_from_arc.col(1) = up.cross(arc.world_from_arc.col(0));
  arc.world_from_arc.col(2) = up;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Frame& f : frames) {
    const Eigen::Vector3d p = arc.world_from_arc.transpose() * (f.camera.pose.centre - mean);
    const Eigen::Vector3d row(2 * p.x(), 2 * p.y(), 1);
    normal += row * row.transpose();
    right += row * (p.x() * p.x() + p.y() * p.y());
  }
  const Eigen::Vector3d solution = normal.inverse() * right;
  arc.centre = mean + arc.world_from_arc.col(0) * solution.x() + arc.world_from_arc.col(1) * solution.y();
  arc.radius = std::sqrt(solution.z() + solution.x() * solution.x() + solution.y() * solution.y());
  double previous = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    const Eigen::Vector3d p = arc.world_from_arc.transpose() * (frames[i].camera.pose.centre - arc.centre);
    double theta = std::atan2(p.y(), p.x());
    if (i > 0) theta = previous + std::remainder(theta - previous, 2 * std::numbers::pi);
    arc.theta_begin = i == 0 ? theta : std::min(arc.theta_begin, theta);
    arc.theta_end = i == 0 ? theta : std::max(arc.theta_end, theta);
    previous = theta;
  }
  return arc;
}

PanoramaGrid make_grid(const std::vector<Frame>& frames, double scale) {
  PanoramaGrid grid;
  grid.arc = fit_arc(frames);
  const Intrinsics& k = frames[0].camera.intrinsics;
  grid.theta_pitch = grid.v_pitch = 1 / (k.fx * scale);
  const double half_view = std::atan(k.width / 2.0 / k.fx), turn = 2 * std::numbers::pi;
  grid.theta_left = grid.arc.theta_end + half_view;
  const double span = std::min(turn, grid.theta_left - grid.arc.theta_begin + half_view);
  grid.wraps = span >= turn;
  grid.width = static_cast<int>(span / grid.theta_pitch);
  if (grid.wraps) grid.theta_pitch = turn / grid.width;
  grid.height = static_cast<int>(1.1 * k.height / k.fx / grid.v_pitch);
  grid.v_top = 0.5 * grid.height * grid.v_pitch;
  double w_near = 0;
  for (const Frame& f : frames)
    for (int y = 0; y < f.z.height; y += 3)
      for (int x = 0; x < f.z.width; x += 3) {
        const Eigen::Vector3d ray = unproject(k, {x + 0.5, y + 0.5});
        const PanoramaPosition p = locate(
            grid, f.camera.pose.centre + f.camera.pose.world_from_camera * ray * static_cast<double>(f.z.at(x, y)));
        if (std::isfinite(p.inverse_depth) && std::isfinite(f.z.at(x, y))) w_near = std::max(w_near, p.inverse_depth);
      }
  grid.w_near = std::min(w_near, 4.0);
  return grid;
}

// A sample of a surface: what a frame saw near a ray of the panorama.
struct Sample {
  float w;
  uint16_t frame, x, y;
  float off_axis;  // how far the frame's camera is from the ray, as an angle in columns
};

// Where in the panorama a frame's pixel is; y outside or behind the ray origins: x = -1.
struct Place {
  int x = -1, y = 0;
  float w = 0;
};
Place place(const PanoramaGrid& grid, const Frame& frame, double x_px, double y_px, float z) {
  const Eigen::Vector3d ray = frame.camera.pose.world_from_camera * unproject(frame.camera.intrinsics, {x_px, y_px});
  const double far = 1e5;
  const PanoramaPosition p = locate(grid, frame.camera.pose.centre + ray * std::min(far, static_cast<double>(z)));
  Place out;
  if (p.inverse_depth <= 0 || p.inverse_depth > grid.w_near) return out;
  const int x = static_cast<int>(p.x_px), y = static_cast<int>(std::floor(p.y_px));
  if (x >= grid.width || y < 0 || y >= grid.height) return out;
  return {x, y, p.inverse_depth < 2 / far ? 0 : static_cast<float>(p.inverse_depth)};
}

// The depth at which ray (x, y) meets the surface that `frame` sees near inverse depth w; negative if it does not.
float refine(const PanoramaGrid& grid, const Frame& frame, int x, int y, float w, Eigen::Vector2d& at_px) {
  const double theta = grid.theta(x + 0.5), v = grid.v(y + 0.5);
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d q = grid.direction(theta, v) + w * (grid.origin(theta) - frame.camera.pose.centre);
    const Eigen::Vector3d c = frame.camera.pose.world_from_camera.transpose() * q;
    if (c.z() <= 1e-6) return -1;
    at_px = project(frame.camera.intrinsics, c);
    const int px = static_cast<int>(std::floor(at_px.x())), py = static_cast<int>(std::floor(at_px.y()));
    if (!frame.z.contains(px, py)) return -1;
    const float z = frame.z.at(px, py);
    const Eigen::Vector3d p = frame.camera.pose.centre +
                              frame.camera.pose.world_from_camera * (c / c.z()) * std::min(1e5, static_cast<double>(z));
    const double depth = 1 / locate(grid, p).inverse_depth;
    if (depth <= 0) return -1;
    const float next = depth > 5e4 ? 0 : static_cast<float>(1 / depth);
    const float change = std::abs(next - w);
    w = next;
    if (change < 1e-5F) return w;
    if (i == 3 && change > 0.01F * w + 1e-3F) return -1;
  }
  return w;
}

// Catmull-Rom weights of the samples at -1, 0, 1, 2 for position f in [0, 1).
std::array<double, 4> cubic_weights(double f) {
  return {((-0.5 * f + 1) * f - 0.5) * f, (1.5 * f - 2.5) * f * f + 1, ((-1.5 * f + 2) * f + 0.5) * f,
          (0.5 * f - 0.5) * f * f};
}

Rgb sample(const RgbImage& image, double x_px, double y_px) {
  const double x = x_px - 0.5, y = y_px - 0.5;
  const int xi = static_cast<int>(std::floor(x)), yi = static_cast<int>(std::floor(y));
  const auto wx = cubic_weights(x - xi), wy = cubic_weights(y - yi);
  double r = 0, g = 0, b = 0;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) {
      const Rgb c = image.at(std::clamp(xi - 1 + i, 0, image.width - 1), std::clamp(yi - 1 + j, 0, image.height - 1));
      const double w = wx[static_cast<size_t>(i)] * wy[static_cast<size_t>(j)];
      r += w * c.r, g += w * c.g, b += w * c.b;
    }
  const auto byte = [](double value) { return static_cast<uint8_t>(std::clamp(value + 0.5, 0.0, 255.0)); };
  return {byte(r), byte(g), byte(b)};
}

struct Surface {
  float w = -1;
  Rgb colour;
};
constexpr int kMaxLayers = 4;
using Surfaces = std::array<Surface, kMaxLayers>;  // along one ray, front to back

bool separate(float a, float b) { return std::abs(a - b) > 0.03F * std::max(a, b) + 0.004F; }

// Is the frame's depth all of one surface around the pixel (so that its colour is no mixture)?
bool clean(const Frame& frame, const Eigen::Vector2d& at_px) {
  const int px = static_cast<int>(std::floor(at_px.x())), py = static_cast<int>(std::floor(at_px.y()));
  const float z = frame.z.at(px, py);
  for (int y = std::max(0, py - 1); y <= std::min(frame.z.height - 1, py + 1); ++y)
    for (int x = std::max(0, px - 1); x <= std::min(frame.z.width - 1, px + 1); ++x)
      if (separate(1 / z, 1 / frame.z.at(x, y))) return false;
  return true;
}

struct Scene {
  std::vector<Frame> frames;
  PanoramaGrid grid;
  std::vector<Surfaces> surfaces;  // per panorama pixel
};

std::vector<std::vector<Sample>> gather(const Scene& scene) {
  std::vector<std::vector<Sample>> samples(static_cast<size_t>(scene.grid.width) *
                                           static_cast<size_t>(scene.grid.height));
  for (size_t f = 0; f < scene.frames.size(); ++f) {
    const Frame& frame = scene.frames[f];
    const Eigen::Vector3d local =
        scene.grid.arc.world_from_arc.transpose() * (frame.camera.pose.centre - scene.grid.arc.centre);
    const double angle = std::atan2(local.y(), local.x());
    for (int y = 0; y < frame.z.height; ++y)
      for (int x = 0; x < frame.z.width; ++x) {
        const Place p = place(scene.grid, frame, x + 0.5, y + 0.5, frame.z.at(x, y));
        if (p.x < 0) continue;
        const double off = std::abs(std::remainder(scene.grid.theta(p.x + 0.5) - angle, 2 * std::numbers::pi));
        samples[static_cast<size_t>(p.y) * static_cast<size_t>(scene.grid.width) + static_cast<size_t>(p.x)].push_back(
            {p.w, static_cast<uint16_t>(f), static_cast<uint16_t>(x), static_cast<uint16_t>(y),
             static_cast<float>(off)});
      }
  }
  return samples;
}

// The surface of one cluster of samples: exact depth and colour from the frame nearest to the ray that agrees, one
// whose colour is no mixture if there is one.
Surface resolve(const Scene& scene, int x, int y, std::vector<Sample> cluster) {
  std::sort(cluster.begin(), cluster.end(), [](const Sample& a, const Sample& b) { return a.off_axis < b.off_axis; });
  Surface best;
  for (const Sample& s : cluster) {
    Eigen::Vector2d at;
    const Frame& frame = scene.frames[s.frame];
    const float w = refine(scene.grid, frame, x, y, s.w, at);
    if (w < 0 || separate(w, s.w)) continue;
    const bool good = clean(frame, at);
    if (best.w < 0 || good) best = {w, sample(frame.colour, at.x(), at.y())};
    if (good) break;
  }
  return best;
}

void find_surfaces(Scene& scene) {
  const auto samples = gather(scene);
  scene.surfaces.resize(samples.size());
  for (int y = 0; y < scene.grid.height; ++y)
    for (int x = 0; x < scene.grid.width; ++x) {
      const size_t i = static_cast<size_t>(y) * static_cast<size_t>(scene.grid.width) + static_cast<size_t>(x);
      std::vector<Sample> sorted;
      // A ray's surfaces are seen through the pixels around it as well: samples fall between the rays.
      for (int ny = std::max(0, y - 1); ny <= std::min(scene.grid.height - 1, y + 1); ++ny)
        for (int nx = std::max(0, x - 1); nx <= std::min(scene.grid.width - 1, x + 1); ++nx)
          for (const Sample& s :
               samples[static_cast<size_t>(ny) * static_cast<size_t>(scene.grid.width) + static_cast<size_t>(nx)])
            sorted.push_back(s);
      std::sort(sorted.begin(), sorted.end(), [](const Sample& a, const Sample& b) { return a.w > b.w; });
      int found = 0;
      for (size_t begin = 0; begin < sorted.size() && found < kMaxLayers;) {
        size_t end = begin + 1;
        while (end < sorted.size() && !separate(sorted[end - 1].w, sorted[end].w)) ++end;
        const Surface surface = resolve(
            scene, x, y,
            {sorted.begin() + static_cast<std::ptrdiff_t>(begin), sorted.begin() + static_cast<std::ptrdiff_t>(end)});
        if (surface.w >= 0) scene.surfaces[i][static_cast<size_t>(found++)] = surface;
        begin = end;
      }
    }
}

// The surfaces of each ray as layers; rays that no frame saw stay empty in all of them.
LayeredPanorama make_panorama(const Scene& scene, int block_px) {
  LayeredPanorama panorama;
  panorama.grid = scene.grid;
  for (int k = 0; k < kMaxLayers; ++k) {
    Layer layer;
    DisparityMap disparity(scene.grid.width, scene.grid.height, kNoDisparity);
    layer.coverage = Plane<uint8_t>(scene.grid.width, scene.grid.height);
    layer.colour = RgbImage(scene.grid.width, scene.grid.height);
    for (size_t i = 0; i < scene.surfaces.size(); ++i) {
      const Surface& s = scene.surfaces[i][static_cast<size_t>(k)];
      if (s.w < 0) continue;
      const double d = (s.w - scene.grid.w_far) / (scene.grid.w_near - scene.grid.w_far) * kDisparitySteps;
      disparity.samples[i] = static_cast<uint16_t>(std::clamp(d + 0.5, 0.0, static_cast<double>(kDisparitySteps)));
      layer.coverage.samples[i] = 1;
      layer.colour.samples[i] = s.colour;
    }
    layer.depth = encode_depth(disparity, block_px);
    panorama.layers.push_back(std::move(layer));
  }
  return panorama;
}

struct Truth {
  Camera camera;
  RgbImage image;
};

double psnr(const View& view, const RgbImage& truth, bool covered_only) {
  double sum = 0, count = 0;
  for (size_t i = 0; i < truth.samples.size(); ++i) {
    const bool covered = view.alpha.samples[i] > 127;
    if (covered_only && !covered) continue;
    const Rgb c = covered ? view.colour.samples[i] : Rgb{127, 127, 127}, t = truth.samples[i];
    sum += (c.r - t.r) * (c.r - t.r) + (c.g - t.g) * (c.g - t.g) + (c.b - t.b) * (c.b - t.b);
    count += 3;
  }
  return 10 * std::log10(255 * 255 / std::max(sum / count, 1e-6));
}

double holes(const View& view) {
  const auto n =
      std::count_if(view.alpha.samples.begin(), view.alpha.samples.end(), [](uint8_t a) { return a <= 127; });
  return 100.0 * static_cast<double>(n) / static_cast<double>(view.alpha.samples.size());
}

void measure(const std::string& name, const LayeredPanorama& panorama, const std::vector<Truth>& truths,
             const RenderOptions& options, const fs::path& out) {
  const auto seconds = [] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  };
  const double start = seconds();
  const Renderer renderer(panorama);
  const double prepared = seconds();
  double drawing = 0, all = 0, on_arc = 0, covered = 0, hole = 0;
  std::string each;
  for (size_t i = 0; i < truths.size(); ++i) {
    const double before = seconds();
    const View view = renderer.render(truths[i].camera, options);
    drawing += seconds() - before;
    const double value = psnr(view, truths[i].image, false);
    all += value;
    if (i < 4) on_arc += value;
    covered += psnr(view, truths[i].image, true);
    hole += holes(view);
    char text[32];
    std::snprintf(text, sizeof text, " %.1f", value);
    each += text;
    if (out.empty()) continue;
    fs::create_directories(out / name);
    write_file(out / name / fs::path(truths[i].camera.name).filename(), encode_png(view.colour, view.alpha));
  }
  const double n = static_cast<double>(truths.size());
  std::printf("%-34s %6.2f %6.2f %6.2f %6.2f   %5.0f %6.1f  %s\n", name.c_str(), all / n, on_arc / 4, covered / n,
              hole / n, 1e3 * (prepared - start), 1e3 * drawing / n, each.c_str());
  std::fflush(stdout);
}

int run(int argc, char** argv) {
  if (argc < 2) throw std::runtime_error("usage: perfect_panorama SCENE [--out DIR] [--scale S]");
  fs::path out;
  double scale = 1;
  for (int i = 2; i + 1 < argc; i += 2) {
    if (std::string(argv[i]) == "--out") out = argv[i + 1];
    if (std::string(argv[i]) == "--scale") scale = std::stod(argv[i + 1]);
  }
  const fs::path folder = argv[1];
  Scene scene;
  scene.frames = read_frames(folder);
  scene.grid = make_grid(scene.frames, scale);
  std::printf("grid %dx%d radius %.3f w_near %.3f\n", scene.grid.width, scene.grid.height, scene.grid.arc.radius,
              scene.grid.w_near);
  find_surfaces(scene);
  std::vector<Truth> truths;
  for (const Camera& camera : read_cameras(folder / "novel.json"))
    truths.push_back({camera, read_image(folder / camera.name)});
  std::printf("%-34s %6s %6s %6s %6s   %5s %6s\n", "variant", "all", "on arc", "cover", "holes", "prep", "ms");
  for (const int block : {0, 8, 16, 32})
    for (const int layers : {1, 2, 3, 4}) {
      if (block != 8 && layers != 3) continue;
      RenderOptions options;
      options.layers = layers;
      measure("block " + std::to_string(block) + " layers " + std::to_string(layers), make_panorama(scene, block),
              truths, options, out);
    }
  RenderOptions filled;
  filled.fill = Fill::background;
  for (const int layers : {1, 3}) {
    filled.layers = layers;
    measure("block 8 layers " + std::to_string(layers) + " filled", make_panorama(scene, 8), truths, filled, out);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) try { return run(argc, argv); } catch (const std::exception& error) {
  std::fprintf(stderr, "perfect_panorama: %s\n", error.what());
  return 2;
}
