// What a panorama keeps of edges and of things a few pixels wide: renders it from the novel views of a scene that
// `ldp scene` made and prints
//   - PSNR (holes as mid-grey) of all pixels, of those within 3 pixels of a true depth edge, and of the others;
//   - of both, the share of pixels whose depth is right within a quarter of a label, and within one;
//   - of wires, bars, twigs and blades, by their width: how many pixels of their length the true views show, the share
//     of it that stands, in all views and in the worst, and the longest break.
// Labels are 1/15 of a view's range of inverse depth (1st to 99th percentile); an edge is a step of more than one.
// With --true-views the true pictures stand for the renderings: what the measures say of perfect ones.
//
//   edge_bench SCENE FILE.ldp | edge_bench SCENE --true-views
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/base/files.h"
#include "core/panorama/file/ldp_file.h"
#include "core/view/render.h"
#include "tests/bench/edges/slender_things.h"
#include "tests/bench/true_surfaces.h"

namespace fs = std::filesystem;
using namespace ldp;

namespace {

constexpr int kEdgePx = 3;
constexpr double kLabelsOfRange = 15;

struct Sums {
  double squares = 0, pixels = 0, within_quarter = 0, within_one = 0;

  void add(const Sums& other) {
    squares += other.squares, pixels += other.pixels;
    within_quarter += other.within_quarter, within_one += other.within_one;
  }
  void print(const char* name) const {
    const double mean = squares / std::max(1.0, pixels);
    std::printf("%-16s %6.2f dB   depth within 1/4 label %5.1f %%, 1 label %5.1f %%   (%.1f Mpx)\n", name,
                10 * std::log10(255 * 255 / std::max(mean, 1e-6)), 100 * within_quarter / std::max(1.0, pixels),
                100 * within_one / std::max(1.0, pixels), pixels / 1e6);
  }
};

// Of z-depth (infinity: 0; none: negative).
Plane<float> inverse_depth(const Plane<float>& z) {
  Plane<float> w(z.width, z.height);
  std::transform(z.samples.begin(), z.samples.end(), w.samples.begin(), [](float depth) {
    if (std::isinf(depth)) return 0.0F;
    return depth > 0 ? 1 / depth : -1.0F;
  });
  return w;
}

float label_of(const Plane<float>& w) {
  std::vector<float> sorted(w.samples.begin(), w.samples.end());
  std::sort(sorted.begin(), sorted.end());
  const auto at = [&](size_t percent) { return sorted[percent * (sorted.size() - 1) / 100]; };
  return std::max(1e-6F, (at(99) - at(1)) / static_cast<float>(kLabelsOfRange));
}

bool near_edge(const Plane<float>& w, float label, int x, int y) {
  float low = w.at(x, y), high = low;
  for (int v = std::max(0, y - kEdgePx); v <= std::min(w.height - 1, y + kEdgePx); ++v)
    for (int u = std::max(0, x - kEdgePx); u <= std::min(w.width - 1, x + kEdgePx); ++u) {
      low = std::min(low, w.at(u, v));
      high = std::max(high, w.at(u, v));
    }
  return high - low > label;
}

double squared_error(const View& view, const RgbImage& truth, int x, int y) {
  const Rgb c = view.alpha.at(x, y) > 127 ? view.colour.at(x, y) : Rgb{127, 127, 127}, t = truth.at(x, y);
  const int r = c.r - t.r, g = c.g - t.g, b = c.b - t.b;
  return (r * r + g * g + b * b) / 3.0;
}

struct Measured {
  std::array<Sums, 2> of_place;  // away from edges, near them
  SlenderLengths slender;
};

Measured measure(const Scene& scene, const TrueView& truth, const View& view) {
  Measured measured;
  const Plane<float> w = inverse_depth(truth.z), shown = inverse_depth(view.depth);
  const float label = label_of(w);
  for (int y = 0; y < w.height; ++y)
    for (int x = 0; x < w.width; ++x) {
      Sums& sums = measured.of_place[near_edge(w, label, x, y) ? 1 : 0];
      const float wrong = shown.at(x, y) < 0 ? INFINITY : std::abs(shown.at(x, y) - w.at(x, y)) / label;
      sums.squares += squared_error(view, truth.colour, x, y);
      sums.pixels += 1;
      sums.within_quarter += wrong <= 0.25F ? 1 : 0;
      sums.within_one += wrong <= 1 ? 1 : 0;
    }
  measured.slender = slender_lengths(scene, truth, view);
  return measured;
}

double share(const SlenderLength& length) {
  return length.shown > 0 ? 100.0 * static_cast<double>(length.standing) / static_cast<double>(length.shown) : 100;
}

void print_slender(const std::vector<Measured>& views) {
  std::printf("width [px]    shown [px]   stands   worst view   longest break [px]\n");
  for (size_t k = 0; k < kSlenderClasses; ++k) {
    SlenderLength all;
    double worst = 100;
    for (const Measured& view : views) {
      all.add(view.slender[k]);
      worst = std::min(worst, share(view.slender[k]));
    }
    std::printf("%4.1f .. %3.1f   %10ld  %6.1f %%     %6.1f %%   %8ld\n", kSlenderWidths[k], kSlenderWidths[k + 1],
                all.shown, share(all), worst, all.longest_break);
  }
}

void print(const std::vector<Measured>& views) {
  std::array<Sums, 2> of_place;
  for (const Measured& view : views)
    for (size_t k = 0; k < 2; ++k) of_place[k].add(view.of_place[k]);
  Sums all = of_place[0];
  all.add(of_place[1]);
  all.print("all pixels");
  of_place[1].print("within 3 px of edges");
  of_place[0].print("elsewhere");
  print_slender(views);
}

View perfect_view(const TrueView& truth) {
  return {truth.colour, Plane<uint8_t>(truth.colour.width, truth.colour.height, 255), truth.z, 0};
}

// How each true view is rendered.
std::function<View(const TrueView&)> renderings_of(const std::string& what, const Job& job) {
  if (what == "--true-views") return perfect_view;
  const auto renderer = std::make_shared<Renderer>(decode_ldp(read_file(what), {}, job));
  return [renderer, job](const TrueView& truth) {
    RenderOptions options;
    options.depth = true;
    return renderer->render(truth.camera, options, job);
  };
}

int run(int argc, char** argv) {
  if (argc != 3) throw std::runtime_error("usage: edge_bench SCENE FILE.ldp | edge_bench SCENE --true-views");
  const fs::path folder = argv[1];
  const std::optional<Scene> scene = described_scene(folder);
  if (!scene) throw std::runtime_error(folder.string() + ": not a scene that `ldp scene` made");
  Job job;
  job.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const auto render = renderings_of(argv[2], job);
  std::vector<Measured> views;
  for (const TrueView& truth : read_true_views(folder, "novel.json", "novel"))
    views.push_back(measure(*scene, truth, render(truth)));
  print(views);
  return 0;
}

}  // namespace

int main(int argc, char** argv) try { return run(argc, argv); } catch (const std::exception& error) {
  std::fprintf(stderr, "edge_bench: %s\n", error.what());
  return 2;
}
