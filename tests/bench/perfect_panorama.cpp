// How far the representation and the renderer carry: builds a panorama from true surfaces, renders the scene's novel
// views and prints their PSNR (holes as mid-grey) for several depth codes and numbers of layers, holes open and filled,
// and the milliseconds that preparing the panorama and drawing one view take on one thread.
//
// SCENE is a rendered capture (transforms.json, frames_depth/*.npy, novel.json, novel/*.png, novel_depth/*.npy). What
// `ldp scene` made is traced: labels and colours are the scene's own, and outlines have their true share of a pixel as
// alpha. Of other captures, and with --photos, surfaces are those of the photographs with their true depths, so that
// colours at outlines are mixtures. S: pixels per pixel of the photos.
//
//   perfect_panorama SCENE [--photos] [--out DIR] [--scale S]
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

#include "core/arc/arc.h"
#include "core/base/files.h"
#include "core/geometry/disparity.h"
#include "core/panorama/panorama.h"
#include "core/photos/images.h"
#include "core/view/render.h"
#include "tests/bench/true_surfaces.h"

namespace fs = std::filesystem;
using namespace ldp;

namespace {

PanoramaGrid make_grid(const std::vector<TrueView>& frames, double scale) {
  PanoramaGrid grid;
  std::vector<Camera> cameras;
  for (const TrueView& f : frames) cameras.push_back(f.camera);
  grid.arc = fit_arc(cameras).arc;
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
  for (const TrueView& f : frames)
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

// The surfaces of each ray as layers; rays that no frame saw stay empty in all of them.
LayeredPanorama make_panorama(const PanoramaGrid& grid, const std::vector<TrueSurfaces>& surfaces, int block_px) {
  LayeredPanorama panorama;
  panorama.grid = grid;
  for (size_t k = 0; k < kTrueLayers; ++k) {
    Layer layer;
    DisparityMap disparity(grid.width, grid.height, kNoDisparity);
    layer.coverage = Plane<uint8_t>(grid.width, grid.height);
    layer.alpha = Plane<uint8_t>(grid.width, grid.height);
    layer.colour = RgbImage(grid.width, grid.height);
    for (size_t i = 0; i < surfaces.size(); ++i) {
      const TrueSurface& s = surfaces[i][k];
      if (s.w < 0) continue;
      const double d = (s.w - grid.w_far) / (grid.w_near - grid.w_far) * kDisparitySteps;
      disparity.samples[i] = static_cast<uint16_t>(std::clamp(d + 0.5, 0.0, static_cast<double>(kDisparitySteps)));
      layer.coverage.samples[i] = 1;
      layer.alpha.samples[i] = s.alpha;
      layer.colour.samples[i] = s.colour;
    }
    layer.depth = encode_depth(disparity, block_px);
    panorama.layers.push_back(std::move(layer));
  }
  return panorama;
}

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

void measure(const std::string& name, const LayeredPanorama& panorama, const std::vector<TrueView>& truths,
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
    const double value = psnr(view, truths[i].colour, false);
    all += value;
    if (i < 4) on_arc += value;
    covered += psnr(view, truths[i].colour, true);
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

std::vector<TrueSurfaces> find_surfaces(const PanoramaGrid& grid, const std::optional<Scene>& scene,
                                        std::vector<TrueView> photos, const std::vector<TrueView>& truths) {
  if (!scene) return surfaces_of_photos(grid, photos);
  photos.insert(photos.end(), truths.begin(), truths.end());
  Job job;
  job.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  return surfaces_of_scene(grid, *scene, photos, job);
}

int run(int argc, char** argv) {
  if (argc < 2) throw std::runtime_error("usage: perfect_panorama SCENE [--photos] [--out DIR] [--scale S]");
  fs::path out;
  double scale = 1;
  bool from_photos = false;
  for (int i = 2; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--photos") from_photos = true;
    if (option == "--out" && i + 1 < argc) out = argv[++i];
    if (option == "--scale" && i + 1 < argc) scale = std::stod(argv[++i]);
  }
  const fs::path folder = argv[1];
  const std::vector<TrueView> photos = read_true_views(folder, "transforms.json", "frames");
  const std::vector<TrueView> truths = read_true_views(folder, "novel.json", "novel");
  const PanoramaGrid grid = make_grid(photos, scale);
  const std::optional<Scene> scene = from_photos ? std::nullopt : described_scene(folder);
  std::printf("%s, grid %dx%d radius %.3f w_near %.3f\n", scene ? "traced" : "from photos", grid.width, grid.height,
              grid.arc.radius, grid.w_near);
  const std::vector<TrueSurfaces> surfaces = find_surfaces(grid, scene, photos, truths);
  std::printf("%-34s %6s %6s %6s %6s   %5s %6s\n", "variant", "all", "on arc", "cover", "holes", "prep", "ms");
  for (const int block : {0, 8, 16, 32})
    for (const int layers : {1, 2, 3, 4}) {
      if (block != 8 && layers != 3) continue;
      RenderOptions options;
      options.layers = layers;
      measure("block " + std::to_string(block) + " layers " + std::to_string(layers),
              make_panorama(grid, surfaces, block), truths, options, out);
    }
  RenderOptions filled;
  filled.fill = Fill::background;
  for (const int layers : {1, 3}) {
    filled.layers = layers;
    measure("block 8 layers " + std::to_string(layers) + " filled", make_panorama(grid, surfaces, 8), truths, filled,
            out);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) try { return run(argc, argv); } catch (const std::exception& error) {
  std::fprintf(stderr, "perfect_panorama: %s\n", error.what());
  return 2;
}
