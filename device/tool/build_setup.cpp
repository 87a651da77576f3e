#include "device/tool/build_setup.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "core/captures/colmap_model.h"
#include "core/captures/field_of_view.h"
#include "device/tool/memory_size.h"
#include "device/tool/number_within.h"
#include "device/tool/output.h"
#include "device/tool/session.h"
#include "device/tool/switches.h"

namespace ldp {
namespace {

// Half-way to the picture's corners the lens must map one direction to one place: what is nonsense there is no lens.
void check_lenses(const std::vector<Camera>& cameras, const std::string& file) {
  for (const Camera& camera : cameras) {
    const Intrinsics& k = camera.intrinsics;
    for (const double x : {0.25, 0.75})
      for (const double y : {0.25, 0.75}) {
        const Eigen::Vector2d at(x * k.width, y * k.height);
        if (!((project(k, unproject(k, at)) - at).norm() < 1))
          throw BadInput(file + ": frame " + camera.name +
                         ": its lens bends the picture beyond measure: check k1, k2, p1 and p2");
      }
  }
}

// The horizontal one of turned photos, of that of the photos as they are stored.
double turned_fov(double fov_rad, int turn_deg, ImageSize turned) {
  if (turn_deg % 180 == 0) return fov_rad;
  return 2 * std::atan(std::tan(fov_rad / 2) * turned.width / turned.height);
}

FolderFramesOptions frames_options(const BuildSetup& setup) {
  FolderFramesOptions options;
  options.max_pixels = std::llround(setup.megapixels * 1e6);
  constexpr std::array kOrientations = {1, 6, 3, 8};
  options.orientation = kOrientations[static_cast<size_t>(setup.turn_deg / 90)];
  options.trimmed = setup.trimmed;
  return options;
}

// Of a COLMAP model the files that there are.
void check_cameras(const std::string& cameras) {
  std::error_code unknown;
  if (cameras.empty()) return;
  if (!std::filesystem::is_directory(cameras, unknown)) return check_input_file(cameras);
  for (const char* const name : {"cameras.bin", "images.bin", "cameras.txt", "images.txt"}) {
    const std::filesystem::path file = std::filesystem::path(cameras) / name;
    if (std::filesystem::exists(file)) check_input_file(file);
  }
}

Intake take_in(const BuildSetup& setup, const Job& job) {
  check_names(setup);
  IntakeOptions options{setup.scratch, frames_options(setup).max_pixels, std::nullopt};
  if (setup.fov_deg > 0 && setup.turn_deg % 180 == 0) options.fov_rad = setup.fov_deg * std::numbers::pi / 180;
  return {setup.captures, options, job};
}

// A folder without photos says what it has instead.
FolderFrames frames_of(const Intake& intake, const BuildSetup& setup) {
  return open_photos(setup, intake.photos().empty() ? photos_of_capture(setup.capture()) : intake.photos());
}

}  // namespace

void check_names(const BuildSetup& setup) {
  std::string together;
  for (const std::string& name : setup.captures) {
    if (name.empty()) throw BadInput("the name of a capture is empty: give a folder of photos");
    together += (together.empty() ? "" : " ") + name;
  }
  std::error_code unknown;
  if (setup.captures.size() > 1 && !std::filesystem::exists(setup.captures.front(), unknown) &&
      std::filesystem::exists(together, unknown))
    throw BadInput(together + ": is one name, with spaces: write " + in_shell({together}));
}

std::string BuildSetup::capture() const {
  return captures.size() == 1 ? captures.front()
                              : captures.front() + " and " + std::to_string(captures.size() - 1) + " more";
}

void add_capture_options(CLI::App& command, BuildSetup& setup) {
  command
      .add_option("CAPTURE", setup.captures,
                  "Folder of photos, taken in name order; or the photos themselves, @LIST of their names, a .zip "
                  "archive of them, or a film (needs ffmpeg)")
      ->required();
  command.add_option("--cameras", setup.cameras,
                     "Known cameras (transforms.json, or the folder of a COLMAP model); without they are estimated");
  command.add_option("--fov", setup.fov_deg, "Horizontal field of view of the photos, degrees, as a start")
      ->check(number_within(kLeastFov_deg, kMostFov_deg));
  command.add_option("--arm-length", setup.arm_length, "Length of the arm, metres: sets the scale of estimated poses")
      ->check(number_within(0.05, 100.0));
  command.add_option("--megapixels", setup.megapixels, "Larger photos are scaled down to this size")
      ->check(number_within(0.01, 200.0))
      ->capture_default_str();
  command
      .add_option("--turn", setup.turn_deg,
                  "Photos of a camera mounted on its side: degrees clockwise that make them upright; --cameras, "
                  "--fov and the cameras that are written are of the turned photos")
      ->check(CLI::IsMember({0, 90, 180, 270}))
      ->capture_default_str();
  command.add_option("--seed", setup.build.poses.seed, "Seed of every random choice")
      ->check(whole_within(0U, std::numeric_limits<unsigned>::max()))
      ->capture_default_str();
}

void add_build_options(CLI::App& command, BuildSetup& setup) {
  BuildOptions& build = setup.build;
  command.add_option("--layers", build.layers, "Layers at most")->check(whole_within(1, 8))->capture_default_str();
  command.add_option("--labels", build.labels, "Depth labels of the graph cut")
      ->check(whole_within(2, 16))
      ->capture_default_str();
  command
      .add_option_function<std::string>(
          "--effort", [&build](const std::string& name) { build.effort = *effort_named(name); },
          "How much work: fast, a coarser panorama, for weak boards; best, a finer one, where time does not matter")
      ->check(CLI::IsMember(effort_names()))
      ->default_str("standard");
  command
      .add_option("--iterations", build.iterations,
                  "Rounds; from the second on with visibility, and the photos choose between the last two; without as "
                  "many as the effort asks for")
      ->check(whole_within(1, 4));
  command
      .add_option_function<std::string>(
          "--rays",
          [&build](const std::string& name) { build.rays = name == "central" ? Rays::central : Rays::pushbroom; },
          "Directions of the panorama's rays: outward from the arc, or all from its centre")
      ->check(CLI::IsMember({"pushbroom", "central"}))
      ->default_str("pushbroom");
  command.add_option("--block", build.block_px, "Pixels per side of a block of depth codes; 0 = one range for all")
      ->check(whole_within(0, 256))
      ->capture_default_str();
  command.add_option("--near", build.near_depth, "Nearest depth, in the capture's unit; 0 = from the photos")
      ->check(number_within(0.0, 1e9));
  command.add_option("--far", build.far_depth, "Farthest depth; 0 = from the photos")->check(number_within(0.0, 1e9));
  command
      .add_option(
          "--quality", setup.colour_quality,
          "Of colour, 1 to 100, layers behind 20 less; 101 = lossless [90 to 95, by how well the panorama explains "
          "its photos]")
      ->check(whole_within(1, 101));
  command
      .add_option(
          "--memory", build.memory_bytes,
          "Memory to work in, such as 128M (20 photos of 800x600 need 52M), if need be by a coarser panorama; 0 = "
          "full detail, large arrays beyond 128M in files without names beside the output")
      ->transform(memory_size("full detail"))
      ->default_str("0");
}

FolderFrames open_photos(const BuildSetup& setup, std::vector<PhotoFile> photos) {
  return {std::move(photos), setup.capture(), frames_options(setup)};
}

PosesOptions poses_options(const BuildSetup& setup, const CaptureNotes& notes, const FolderFrames& frames) {
  PosesOptions options = setup.build.poses;
  if (setup.arm_length > 0)
    options.arm_length = setup.arm_length;
  else if (notes.arm_length)
    options.arm_length = *notes.arm_length;
  if (setup.fov_deg > 0)
    options.fov_rad = setup.fov_deg * std::numbers::pi / 180;
  else if (notes.fov_rad)
    options.fov_rad = turned_fov(*notes.fov_rad, setup.turn_deg, frames.stored_size());
  return options;
}

PreparedBuild prepare(const BuildSetup& setup, const Job& job) {
  check_cameras(setup.cameras);
  Intake intake = take_in(setup, job);
  FolderFrames frames = frames_of(intake, setup);
  CaptureNotes notes = read_capture_notes(intake.folder(), intake.archive());
  PreparedBuild prepared{std::move(intake), std::move(frames), std::move(notes), setup.build};
  const int photos = prepared.frames.size();
  if (photos < kFewestPhotos) {
    throw Impossible(setup.capture() + ": " + (photos == 1 ? "one photo" : std::to_string(photos) + " photos") +
                     " only: a panorama needs at least " + std::to_string(kFewestPhotos) + " of one sweep");
  }
  BuildOptions& options = prepared.options;
  if (options.near_depth > 0 && options.far_depth > 0 && options.near_depth >= options.far_depth) {
    throw BadInput("--near " + std::to_string(options.near_depth) + ": is not nearer than --far " +
                   std::to_string(options.far_depth));
  }
  options.poses = poses_options(setup, prepared.notes, prepared.frames);
  if (!setup.cameras.empty()) {
    options.cameras = prepared.frames.fit(read_cameras(setup.cameras));
    check_lenses(options.cameras, setup.cameras);
    if (options.cameras.size() < size_t{kFewestPhotos}) {
      throw BadInput(setup.cameras + ": only " + std::to_string(options.cameras.size()) +
                     " of its cameras are named like photos of " + setup.capture() +
                     " of the size that most have, at least " + std::to_string(kFewestPhotos) +
                     " are needed: check that file_path holds the photos' names");
    }
  }
  return prepared;
}

void keep_out_of_capture(const std::string& folder, const std::string& option, const PreparedBuild& prepared) {
  std::set<std::filesystem::path> places{prepared.intake.folder()};
  for (const PhotoFile& photo : prepared.frames.files()) {
    const std::filesystem::path place = std::filesystem::absolute(photo.path).parent_path();
    places.insert(place);
    if (place.filename() == "frames") places.insert(place.parent_path());  // of a capture, whose own photos go first
  }
  for (const std::filesystem::path& place : places) {
    std::error_code one_is_missing;
    if (std::filesystem::equivalent(folder, place, one_is_missing))
      throw BadInput(option + " " + folder +
                     ": is the folder of the photos, and pictures there would be taken for more of them: name another");
  }
}

nlohmann::ordered_json options_json(const BuildSetup& setup, const BuildOptions& used) {
  nlohmann::ordered_json json;
  json["capture"] = setup.capture();
  json["cameras"] = setup.cameras;
  json["layers"] = used.layers;
  json["labels"] = used.labels;
  json["effort"] = options_of(used.effort).name;
  json["iterations"] = iterations_of(used);
  json["rays"] = used.rays == Rays::pushbroom ? "pushbroom" : "central";
  json["block_px"] = used.block_px;
  json["near_depth"] = used.near_depth;
  json["far_depth"] = used.far_depth;
  json["memory_bytes"] = used.memory_bytes;
  // Known only once it is built, where it is not told.
  json["colour_quality"] = setup.colour_quality ? nlohmann::ordered_json(*setup.colour_quality) : nullptr;
  json["megapixels"] = setup.megapixels;
  json["turn_degrees"] = setup.turn_deg;
  json["fov_degrees"] =
      used.poses.fov_rad ? nlohmann::ordered_json(*used.poses.fov_rad * 180 / std::numbers::pi) : nullptr;
  json["arm_length"] = used.poses.arm_length;
  json["seed"] = used.poses.seed;
  json["debug_directory"] = used.debug_directory;
  return json;
}

}  // namespace ldp
