// ldp scene: a synthetic capture with truth.

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/markup_text.h"
#include "core/captures/json_text.h"
#include "core/geometry/degrees.h"
#include "device/tool/commands.h"
#include "device/tool/number_within.h"
#include "device/tool/output.h"
#include "device/tool/process/progress_bar.h"
#include "sim/scene/scenes.h"
#include "sim/scene_capture.h"

namespace ldp {
namespace {

constexpr double kShade = 0.15;  // of half of the scene, where exposure is automatic

struct SceneCommand {
  SceneCaptureOptions scene;
  std::string output, size = "800x600";
  double arc_deg = 180, fov_deg = 58, jitter_deg = 1.2, heading_deg = 0;
  std::optional<double> shade;
  bool no_novel = false, list = false;
  std::vector<const CLI::Option*> of_around;  // that have no effect without it
};

int list_scenes(bool json) {
  if (json)
    std::printf("%s\n", json_text(nlohmann::ordered_json{{"scenes", scene_names()}}).c_str());
  else
    for (const std::string& name : scene_names()) std::printf("%s\n", name.c_str());
  return kDone;
}

void print_summary(const SceneCommand& command, bool as_json) {
  const SceneCaptureOptions& scene = command.scene;
  if (!as_json) {
    std::printf("%s: %d photos of %s with cameras and depths%s\n", printable(command.output).c_str(), scene.path.frames,
                scene.scene.c_str(), scene.novel_views ? ", and novel views" : "");
    return;
  }
  const std::filesystem::path folder = command.output;
  nlohmann::ordered_json json{{"capture", command.output},
                              {"scene", scene.scene},
                              {"frames", scene.path.frames},
                              {"cameras", (folder / "transforms.json").string()},
                              {"depths", (folder / "frames_depth").string()},
                              {"novel_views", nullptr},
                              {"around", nullptr}};
  if (scene.around.width > 0) json["around"] = (folder / "around").string();
  if (scene.novel_views) json["novel_views"] = (folder / "novel.json").string();
  std::printf("%s\n", json_text(json).c_str());
}

int run(SceneCommand command, const Session& session) {
  if (command.list) return list_scenes(session.json);
  if (command.scene.scene.empty()) throw BadInput("no scene is named: give one of those that --list shows");
  make_scene(command.scene.scene, command.scene.seed);  // an unknown name is refused before anything else
  if (command.output.empty()) throw BadInput("no output folder is named: add -o DIR");
  if (command.scene.around.width == 0)
    for (const CLI::Option* const option : command.of_around)
      if (option->count() > 0)
        throw BadInput(option->get_name() + ": only --around shows it: add that, or leave it out");
  if (command.scene.around.width % 2 != 0)
    throw BadInput("--around " + std::to_string(command.scene.around.width) + ": give an even number");
  command.scene.around.heading_rad = command.heading_deg * kRadiansPerDegree;
  parse_size(command.size, command.scene.path.width, command.scene.path.height);
  command.scene.path.arc_rad = command.arc_deg * kRadiansPerDegree;
  command.scene.path.fov_rad = command.fov_deg * kRadiansPerDegree;
  command.scene.path.angle_jitter_rad = command.jitter_deg * kRadiansPerDegree;
  command.scene.path.seed = command.scene.seed;
  command.scene.novel_views = !command.no_novel;
  command.scene.shade = command.shade.value_or(command.scene.meters ? kShade : 1);
  OutputFolder folder(command.output, OutputFolder::Existing::refuse);
  std::optional<ProgressBar> bar(session.progress_fd);
  folder.fill([&] { write_scene_capture(command.scene, folder.path(), start_job(session, *bar)); });
  folder.keep();
  bar.reset();
  print_summary(command, session.json);
  return kDone;
}

}  // namespace

void add_scene(Program& program) {
  auto command = std::make_shared<SceneCommand>();
  command->scene.scene.clear();
  CLI::App& app = add_command(program, "scene", "Render a synthetic capture with true cameras, depths and novel views",
                              [command](const Session& session) { return run(*command, session); });
  SweepPath& path = command->scene.path;
  app.add_option("NAME", command->scene.scene, "Which scene");
  app.add_option("-o,--output", command->output, "Folder to make");
  app.add_flag("--list", command->list, "Print the names of the scenes");
  app.add_option("--frames", path.frames, "Photos in the sweep")->check(whole_within(1, 1000))->capture_default_str();
  app.add_option("--arc", command->arc_deg, "Angle of the sweep, degrees")
      ->check(number_within(0.0, 360.0))
      ->capture_default_str();
  app.add_option("--radius", path.radius, "Length of the arm, metres")
      ->check(number_within(0.0, 1.2))
      ->capture_default_str();
  app.add_option("--fov", command->fov_deg, "Horizontal field of view, degrees")
      ->check(number_within(5.0, 150.0))
      ->capture_default_str();
  app.add_option("--size", command->size, "Size of the photos, WIDTHxHEIGHT")->capture_default_str();
  app.add_option("--k1", path.k1, "Radial distortion of the lens")
      ->check(number_within(-0.3, 0.3))
      ->capture_default_str();
  app.add_option("--jitter-position", path.position_jitter, "Unsteadiness of the hand, metres")
      ->check(number_within(0.0, 0.2))
      ->capture_default_str();
  app.add_option("--jitter-angle", command->jitter_deg, "Unsteadiness of the hand, degrees")
      ->check(number_within(0.0, 20.0))
      ->capture_default_str();
  app.add_option("--exposure-drift", command->scene.exposure_drift, "Largest relative change of exposure")
      ->check(number_within(0.0, 0.9))
      ->capture_default_str();
  app.add_option_function<std::string>(
         "--exposure", [command](const std::string& name) { command->scene.meters = name == "auto"; },
         "fixed, or auto: each picture is well exposed by itself, novel ones too, and half of the scene lies in shade")
      ->check(CLI::IsMember({"fixed", "auto"}))
      ->default_str("fixed");
  app.add_option("--shade", command->shade,
                 "Share of the light that the left half has [0.15 with --exposure auto, or 1]")
      ->check(number_within(0.01, 1.0));
  app.add_option("--noise", command->scene.noise, "Sensor noise, deviation in levels of 255")
      ->check(number_within(0.0, 50.0))
      ->capture_default_str();
  app.add_option("--blur", command->scene.blur_px, "Longest motion blur, pixels")
      ->check(number_within(0.0, 100.0))
      ->capture_default_str();
  app.add_option("--moving", command->scene.moving_share, "Share of figures and leaves that move")
      ->check(number_within(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--crowd", command->scene.crowd,
                 "People walk by: about the share that they hide of the photo that has most of them; novel views are "
                 "without them")
      ->check(number_within(0.0, 0.5))
      ->capture_default_str();
  app.add_option("--seed", command->scene.seed, "Of the scene, the hand and the noise")
      ->check(whole_within(uint32_t{0}, std::numeric_limits<uint32_t>::max()))
      ->capture_default_str();
  app.add_option("--around", command->scene.around.width,
                 "Also what is seen all around from the arc's centre, so many pixels a turn (an even number): by one "
                 "eye with distances, and by two (around/)")
      ->check(whole_within(64, 16384));
  const CLI::Option* const heading =
      app.add_option("--heading", command->heading_deg,
                     "Where the middle of it looks, degrees to the right of the sweep's middle")
          ->check(number_within(-360.0, 360.0))
          ->capture_default_str();
  const CLI::Option* const eyes =
      app.add_option("--eyes", command->scene.around.eyes, "Distance of the two eyes, metres")
          ->check(number_within(0.0, 1.0))
          ->capture_default_str();
  command->of_around = {heading, eyes};
  app.add_flag("--no-novel", command->no_novel, "Leave the novel views out");
}

}  // namespace ldp
