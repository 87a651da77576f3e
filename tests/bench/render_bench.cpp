// Views a second of an .ldp file on one thread, by path of the camera, when all of it is prepared; and what that and a
// first view from its middle take, on one thread and on all.
//
//   render_bench FILE.ldp [VIEWS] [WIDTH HEIGHT]     views per path (90) of WIDTH x HEIGHT pixels (800 600)
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>

#include "core/base/files.h"
#include "core/panorama/file/ldp_file.h"
#include "core/photos/images.h"
#include "core/view/camera_path.h"
#include "core/view/render.h"

namespace ldp {
namespace {

// Of processor time: one thread, whatever else the machine does.
double seconds(const std::function<void()>& action) {
  const std::clock_t begin = std::clock();
  action();
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

double wall_seconds(const std::function<void()>& action) {
  const auto begin = std::chrono::steady_clock::now();
  action();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// Tells apart views that differ anywhere: FNV-1a of colours and alpha.
uint64_t add_to_hash(const View& view, uint64_t hash) {
  const auto add = [&](uint8_t byte) { hash = (hash ^ byte) * 0x100000001B3U; };
  for (const Rgb c : view.colour.samples) add(c.r), add(c.g), add(c.b);
  for (const uint8_t a : view.alpha.samples) add(a);
  return hash;
}

void run(int argc, char** argv) {
  if (argc != 2 && argc != 3 && argc != 5)
    throw std::runtime_error("usage: render_bench FILE.ldp [VIEWS] [WIDTH HEIGHT]");
  CameraPathOptions path;
  if (argc > 2) path.frames = std::atoi(argv[2]);
  if (argc > 4) path.width = std::atoi(argv[3]), path.height = std::atoi(argv[4]);
  const LayeredPanorama panorama = decode_ldp(read_file(argv[1]));
  const Camera middle = camera_path(panorama, path)[static_cast<size_t>(path.frames / 2)];
  Job all;
  all.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const double first = seconds([&] { Renderer(panorama).render(middle, {}); }),
               first_wall = wall_seconds([&] { Renderer(panorama).render(middle, {}, all); });
  Renderer renderer(panorama);
  const double prepared = seconds([&] { renderer.prepare({}); });
  std::printf("a first view in %.2f s (%d threads: %.2f s), all prepared in %.2f s; views of %dx%d:\n", first,
              all.threads, first_wall, prepared, path.width, path.height);
  for (const CameraPath kind : {CameraPath::sway, CameraPath::walk, CameraPath::dolly}) {
    path.kind = kind;
    double drawn = 0;
    uint64_t hash = 0xCBF29CE484222325U;
    for (const Camera& camera : camera_path(panorama, path)) {
      View view;
      drawn += seconds([&] { view = renderer.render(camera, {}); });
      hash = add_to_hash(view, hash);
    }
    constexpr const char* kNames[] = {"sway", "walk", "dolly"};
    std::printf("%-6s %6.1f a second, %5.1f ms each, hash %016llx\n", kNames[static_cast<int>(kind)],
                path.frames / drawn, 1e3 * drawn / path.frames, static_cast<unsigned long long>(hash));
  }
}

}  // namespace
}  // namespace ldp

int main(int argc, char** argv) try { ldp::run(argc, argv); } catch (const std::exception& error) {
  std::fprintf(stderr, "render_bench: %s\n", error.what());
  return 2;
}
