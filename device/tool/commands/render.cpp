// ldp render: views of an .ldp file.

#include "core/view/render.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>
#include <set>
#include <tuple>
#include <type_traits>
#include <utility>

#include "core/base/files.h"
#include "core/base/markup_text.h"
#include "core/captures/folder_frames.h"
#include "core/captures/transforms.h"
#include "core/panorama/even_exposure.h"
#include "core/photos/images.h"
#include "core/view/camera_path.h"
#include "core/view/framing.h"
#include "device/tool/build_setup.h"
#include "device/tool/commands.h"
#include "device/tool/commands/film.h"
#include "device/tool/exr/exr_view.h"
#include "device/tool/number_within.h"
#include "device/tool/output.h"
#include "device/tool/own_output.h"
#include "device/tool/panorama_input.h"
#include "device/tool/process/progress_bar.h"
#include "device/tool/switches.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;

struct RenderCommand {
  PanoramaInput input;
  std::string cameras, path, output, size;
  int frames = 90;
  double fov_deg = 0;
  RenderOptions options;
  std::optional<Fill> fill;       // as given
  bool pfm = false, exr = false;  // also written of each view
  bool even = false;
};

std::vector<Camera> cameras_of(const RenderCommand& command, const LayeredPanorama& panorama, const Renderer& renderer,
                               const Job& job) {
  if (!command.cameras.empty()) return read_transforms(command.cameras);
  CameraPathOptions path;
  path.kind = camera_path_from_name(command.path);
  path.frames = command.frames;
  path.view_rad = command.fov_deg * std::numbers::pi / 180;
  if (!command.size.empty()) parse_size(command.size, path.width, path.height);
  return camera_path(panorama, framed_inside(panorama, renderer, path, job));
}

void check_stems(const std::vector<Camera>& cameras, const std::string& file) {
  std::set<std::string> stems;
  for (const Camera& camera : cameras) {
    const std::string stem = fs::path(camera.name).stem().string();
    if (stem.empty()) throw BadInput(file + ": a frame has no file_path: name every frame, its view is named after it");
    if (!stems.insert(stem).second) {
      std::string refusal = file;
      refusal.append(": two frames are called ").append(stem);
      throw BadInput(refusal.append(": their views would overwrite each other"));
    }
  }
}

bool is_a_view(const fs::path& png) { return fs::is_regular_file(png) && png_software(read_file(png)) == kRendered; }

// Depths tell nothing of their origin: they are of this program where the view beside them is.
void keep_photos(const RenderCommand& command, const std::vector<Camera>& cameras) {
  for (const Camera& camera : cameras) {
    const fs::path stem = fs::path(command.output) / fs::path(camera.name).stem();
    fs::path view = stem, pfm = stem, exr = stem;
    view += ".png", pfm += ".pfm", exr += ".exr";
    for (const auto& [file, wanted] : {std::pair(view, true), {pfm, command.pfm}, {exr, command.exr}})
      if (wanted && fs::exists(file) && !is_a_view(view))
        throw BadInput(file.string() + ": is there already and is no view: name another folder");
  }
}

// Of a capture a next build would take the views for its photos, and for all of them where these lie in `frames`. A
// picture or two are none.
void refuse_folder_of_photos(const RenderCommand& command) {
  const fs::path output = command.output;
  for (const fs::path& folder : {output, output / "frames"}) {
    if (!fs::is_directory(folder)) continue;
    int photos = 0;
    for (const fs::path& picture : list_photos(folder)) {
      if (is_a_view(picture) || ++photos < kFewestPhotos) continue;
      throw BadInput(command.output + ": holds photos, among them " + picture.lexically_relative(output).string() +
                     ", and views there would be taken for photos of that sweep: name another folder");
    }
  }
}

// Depths of other views of the same names would pass for those of the new ones.
void refuse_stale_depths(const RenderCommand& command, const std::vector<Camera>& cameras) {
  for (const Camera& camera : cameras)
    for (const auto& [ending, option, wanted] :
         {std::tuple(".pfm", "--depth", command.pfm), {".exr", "--exr", command.exr}}) {
      fs::path left = fs::path(command.output) / fs::path(camera.name).stem();
      left += ending;
      if (!wanted && fs::exists(left))
        throw BadInput(left.string() + ": is left from earlier views and would not fit the new ones: render with " +
                       option + " again, remove it, or name another folder");
    }
}

constexpr BytesBeside kRendering{
    .per_pixel = kMeshBytesPerPixel, .per_present_pixel = kMeshBytesPerPresentPixel, .always = kMeshBytesAlways};

constexpr double kBlind = 0.01;  // share of a view that shows something, below which its camera sees nothing

struct Rendered {
  double holes = 0, invented = 0;
  int views = 0, blind = 0;
};

void add(const View& view, Rendered& totals) {
  size_t holes = 0;
  for (const uint8_t alpha : view.alpha.samples) holes += alpha < 128 ? 1 : 0;
  const double share = static_cast<double>(holes) / static_cast<double>(view.alpha.samples.size());
  totals.holes += share;
  totals.invented += view.invented_share;
  totals.blind += 1 - share - view.invented_share < kBlind ? 1 : 0;
  ++totals.views;
}

void add(const Rendered& some, Rendered& totals) {
  totals.holes += some.holes;
  totals.invented += some.invented;
  totals.blind += some.blind;
  totals.views += some.views;
}

// A path's views are numbered: those that a longer one left would pass for the end of this one.
void refuse_longer_path(const RenderCommand& command) {
  const fs::path next = fs::path(command.output) / path_view_name(command.frames);
  for (const char* ending : {".png", ".pfm", ".exr"}) {
    fs::path left = next;
    left += ending;
    if (fs::exists(left))
      throw BadInput(left.string() + ": is left from a longer path: remove the views there, or name another folder");
  }
}

uint64_t bytes_of_view(const RenderCommand& command, const Intrinsics& lens) {
  return (kBytesOfView + (command.exr ? kBytesOfExr : 0)) * static_cast<uint64_t>(lens.width) *
         static_cast<uint64_t>(lens.height);
}

// How many views are drawn and coded at the same time: as threads allow, while they are small.
int views_at_once(const RenderCommand& command, const std::vector<Camera>& cameras, const Job& job) {
  constexpr uint64_t kEasyBytes = 256 << 20;
  uint64_t largest = 1;
  for (const Camera& camera : cameras) largest = std::max(largest, bytes_of_view(command, camera.intrinsics));
  return std::clamp(static_cast<int>(std::min<uint64_t>(kEasyBytes / largest, cameras.size())), 1,
                    std::max(1, job.threads));
}

// Draws views, some at the same time, and uses them one after another, in the order of their cameras.
template <typename Draw, typename Use>
void for_each_view(const RenderCommand& command, const std::vector<Camera>& cameras, const Job& job, Draw draw,
                   Use use) {
  const int at_once = views_at_once(command, cameras, job), count = static_cast<int>(cameras.size());
  Job of_one = job;
  of_one.threads = std::max(1, job.threads / at_once);
  of_one.progress = {};  // is told of views
  for (int first = 0; first < count; first += at_once) {
    job.report("rendering", first / static_cast<double>(count));
    std::vector<std::invoke_result_t<Draw, const Camera&, const Job&>> drawn(
        static_cast<size_t>(std::min(at_once, count - first)));
    parallel_for(job, static_cast<int>(drawn.size()),
                 [&](int i) { drawn[static_cast<size_t>(i)] = draw(cameras[static_cast<size_t>(first + i)], of_one); });
    for (size_t i = 0; i < drawn.size(); ++i) use(cameras[static_cast<size_t>(first) + i], drawn[i]);
  }
  job.check();
}

// A view's files by their endings.
struct Pictures {
  std::vector<uint8_t> png, pfm, exr;
  Rendered totals;
};

Pictures draw_pictures(const RenderCommand& command, const Renderer& renderer, const Camera& camera, const Job& job) {
  const View view = renderer.render(camera, command.options, job);
  Pictures pictures;
  pictures.png = encode_png(view.colour, view.alpha, kRendered);
  if (command.pfm) pictures.pfm = encode_pfm(view.depth);
  if (command.exr) pictures.exr = encode_exr(view);
  add(view, pictures.totals);
  return pictures;
}

Rendered render_pictures(const RenderCommand& command, const Renderer& renderer, const std::vector<Camera>& cameras,
                         const Job& job) {
  OutputFolder folder(command.output, OutputFolder::Existing::merge);
  Rendered totals;
  const auto draw = [&](const Camera& camera, const Job& of_one) {
    return draw_pictures(command, renderer, camera, of_one);
  };
  for_each_view(command, cameras, job, draw, [&](const Camera& camera, const Pictures& pictures) {
    const std::string stem = fs::path(camera.name).stem().string();
    folder.fill([&] {
      write_file(folder.path() / (stem + ".png"), pictures.png);
      if (command.pfm) write_file(folder.path() / (stem + ".pfm"), pictures.pfm);
      if (command.exr) write_file(folder.path() / (stem + ".exr"), pictures.exr);
    });
    add(pictures.totals, totals);
  });
  folder.keep();
  return totals;
}

Rendered render_film(const RenderCommand& command, const Renderer& renderer, const std::vector<Camera>& cameras,
                     const Job& job) {
  Film film(command.output, cameras.front().intrinsics.width, cameras.front().intrinsics.height);
  Rendered totals;
  const auto draw = [&](const Camera& camera, const Job& of_one) {
    return renderer.render(camera, command.options, of_one);
  };
  for_each_view(command, cameras, job, draw, [&](const Camera&, const View& view) {
    film.add(view.colour);
    add(view, totals);
  });
  film.keep();
  return totals;
}

void check(const RenderCommand& command) {
  check_input_file(command.input.file);
  if (command.cameras.empty() == command.path.empty())
    throw BadInput("give either --cameras FILE or --path sway|walk|dolly");
  if (command.exr) check_exr_is_built();
  if (!command.cameras.empty()) check_input_file(command.cameras);
  if (names_a_film(command.output)) {
    if (command.options.depth)
      throw BadInput(std::string(command.pfm ? "--depth" : "--exr") + ": a film has no depth: give a folder to -o");
    return check_output_file(command.output, OutputKind::film);
  }
  { const OutputFolder refused_before_the_file_is_read(command.output, OutputFolder::Existing::merge); }
  if (!command.path.empty()) refuse_longer_path(command);
}

void check_view(const RenderCommand& command, const Camera& camera) {
  const Intrinsics& k = camera.intrinsics;
  check_memory(command.input, bytes_of_view(command, k),
               "the view " + camera.name + " of " + std::to_string(k.width) + "x" + std::to_string(k.height));
}

void check_film(const RenderCommand& command, const std::vector<Camera>& cameras) {
  const auto size = [](const Camera& camera) { return std::pair(camera.intrinsics.width, camera.intrinsics.height); };
  const auto text = [](const Camera& camera) {
    return camera.name + " of " + std::to_string(camera.intrinsics.width) + "x" +
           std::to_string(camera.intrinsics.height);
  };
  for (const Camera& camera : cameras)
    if (size(camera) != size(cameras.front()))
      throw BadInput(command.cameras + ": the views of a film are all of one size, here are " + text(cameras.front()) +
                     " and " + text(camera) + ": give a folder to -o, or cameras of one size");
}

bool is_far_off(const LayeredPanorama& panorama, const Camera& camera) {
  const Arc& arc = panorama.grid.arc;
  const Eigen::Vector3d in_arc = arc.world_from_arc.transpose() * (camera.pose.centre - arc.centre);
  return panorama.limits.are_far_from(std::hypot(in_arc.x(), in_arc.y()), in_arc.z());
}

// Most likely they are of another coordinate system, in which nothing stands where it should.
void warn_of_cameras(const RenderCommand& command, const LayeredPanorama& panorama, const std::vector<Camera>& cameras,
                     const Rendered& totals) {
  if (command.cameras.empty()) return;
  const auto far = static_cast<int>(std::count_if(cameras.begin(), cameras.end(),
                                                  [&](const Camera& camera) { return is_far_off(panorama, camera); }));
  if (totals.blind == 0 && far == 0) return;
  std::fprintf(
      stderr,
      "ldp render: %d of %d cameras %s: give cameras in the coordinates of those that this writes: ldp export %s -o "
      "cameras.json\n",
      std::max(totals.blind, far), totals.views,
      far > totals.blind ? "stand far from where views hold (ldp info)" : "see nothing of the panorama",
      printable(in_shell({command.input.file})).c_str());
}

void print_summary(const RenderCommand& command, const Rendered& totals, bool json) {
  const double holes = 100 * totals.holes / totals.views, invented = 100 * totals.invented / totals.views;
  if (json) {
    std::printf("{\"views\": %d, \"holes_percent\": %.4f, \"invented_percent\": %.4f}\n", totals.views, holes,
                invented);
  } else {
    std::printf("%s: %d views, %.2f %% holes", printable(command.output).c_str(), totals.views, holes);
    std::printf(command.options.fill == Fill::background ? ", %.2f %% filled\n" : "\n", invented);
  }
}

int run(RenderCommand command, const Session& session) {
  command.options.depth = command.pfm || command.exr;
  const bool to_look_at = !command.path.empty() || names_a_film(command.output);
  command.options.fill = command.fill.value_or(to_look_at ? Fill::background : Fill::none);
  check(command);
  std::optional<ProgressBar> bar(session.progress_fd);
  const Job job = start_job(session, *bar);
  LayeredPanorama panorama = read_panorama(command.input, kRendering, job);
  if (command.even) even_out(panorama, job);
  const Renderer renderer(panorama);
  const std::vector<Camera> cameras = cameras_of(command, panorama, renderer, job);
  if (cameras.empty()) throw BadInput(command.cameras + ": has no frames: add the cameras to render");
  for (const Camera& camera : cameras) check_view(command, camera);
  check_stems(cameras, command.cameras);
  if (names_a_film(command.output)) {
    check_film(command, cameras);
  } else {
    keep_photos(command, cameras);
    refuse_stale_depths(command, cameras);
    refuse_folder_of_photos(command);
  }
  const Rendered totals = names_a_film(command.output) ? render_film(command, renderer, cameras, job)
                                                       : render_pictures(command, renderer, cameras, job);
  bar.reset();
  print_summary(command, totals, session.json);
  warn_of_cameras(command, panorama, cameras, totals);
  return kDone;
}

}  // namespace

void add_render(Program& program) {
  auto command = std::make_shared<RenderCommand>();
  CLI::App& app = add_command(program, "render", "Render views with parallax from an .ldp file",
                              [command](const Session& session) { return run(*command, session); });
  add_panorama_input(app, command->input);
  app.add_option("-o,--output", command->output, "Folder for the views, or a film (.mp4, .webm, .gif; needs ffmpeg)")
      ->required();
  app.add_option("--cameras", command->cameras, "The views to render (transforms.json)");
  app.add_option("--path", command->path, "Move through the panorama instead: sway, walk or dolly")
      ->check(CLI::IsMember({"sway", "walk", "dolly"}));
  app.add_option("--frames", command->frames, "Views along the path")
      ->check(whole_within(1, 100000))
      ->capture_default_str()
      ->excludes("--cameras");
  app.add_option("--size", command->size, "Size of views along the path, WIDTHxHEIGHT")->excludes("--cameras");
  app.add_option("--fov", command->fov_deg, "Horizontal field of view along the path, degrees; 0 = that of the photos")
      ->check(number_within(0.0, 150.0))
      ->excludes("--cameras");
  app.add_flag("--depth", command->pfm, "Also write z-depth, as .pfm");
  app.add_flag("--exr", command->exr, "Also write linear colour, alpha and z-depth together, as OpenEXR's .exr");
  app.add_option("--layers", command->options.layers, "Draw at most so many layers")
      ->check(whole_within(1, 8))
      ->capture_default_str();
  app.add_option_function<std::string>(
         "--fill",
         [command](const std::string& name) { command->fill = name == "none" ? Fill::none : Fill::background; },
         "Holes: none leaves them transparent, background continues what lies behind; default: background along a "
         "--path and in films, none for pictures of --cameras")
      ->check(CLI::IsMember({"none", "background"}));
  app.add_option_function<std::string>(
         "--exposure", [command](const std::string& name) { command->even = name == "even"; },
         "Brightness, of photos on automatic exposure: local is about that of the photos of each direction, even as if "
         "all had one exposure")
      ->check(CLI::IsMember({"local", "even"}))
      ->default_str("local");
}

}  // namespace ldp
