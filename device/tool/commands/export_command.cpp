// ldp export: an .ldp file in a form that other programs open.

#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/files.h"
#include "core/base/markup_text.h"
#include "core/captures/json_text.h"
#include "core/export/export.h"
#include "core/photos/images.h"
#include "device/tool/commands.h"
#include "device/tool/number_within.h"
#include "device/tool/output.h"
#include "device/tool/own_output.h"
#include "device/tool/panorama_input.h"
#include "device/tool/process/progress_bar.h"

namespace ldp {
namespace {

struct ExportCommand {
  PanoramaInput input;
  std::string output;
  ExportOptions options;
  std::string kind;
  std::vector<double> at;
  Viewer viewer;
  const CLI::Option *eyes = nullptr, *plain = nullptr, *quality = nullptr;  // whether they were given
};

// Measured: the viewer and layered images take up to 5 bytes a pixel, a mesh 45 for each point of it.
constexpr BytesBeside kExporting{.per_pixel = 5, .per_present_pixel = 64, .always = 16 << 20};

// A flat panorama, whose holes are filled: 34 bytes a pixel, of a full turn a quarter more pixels.
constexpr BytesBeside kFlattening{.per_pixel_once = 43, .always = 16 << 20};

// A picture from a place takes what rendering takes, and its own bands.
constexpr BytesBeside kSeeing{
    .per_pixel = kMeshBytesPerPixel + 24, .per_present_pixel = kMeshBytesPerPresentPixel, .always = kMeshBytesAlways};

std::string size_text(size_t bytes) {
  char text[32];
  const double kilobytes = static_cast<double>(bytes) / 1e3;
  std::snprintf(text, sizeof text, kilobytes < 1000 ? "%.1f kB" : "%.1f MB",
                kilobytes < 1000 ? kilobytes : kilobytes / 1e3);
  return text;
}

Viewer viewer_of(const ExportCommand& command) {
  Viewer viewer = command.viewer;
  if (!command.at.empty()) viewer.at = {command.at[0], command.at[1], command.at[2]};
  return viewer;
}

Kind kind_of(const std::string& name) {
  if (name == "stereo") return Kind::stereo;
  return name == "depth" ? Kind::depth : Kind::panorama;
}

// From a place, instead of as it was swept.
bool is_seen(const ExportCommand& command) { return !command.kind.empty() || !command.at.empty(); }

bool names_a_folder(const std::string& output) {
  return output.ends_with('/') || std::filesystem::is_directory(output);
}

const BytesBeside& bytes_beside(const ExportCommand& command) {
  if (is_seen(command)) return kSeeing;
  const bool is_flat = !names_a_folder(command.output) && exported_kind(command.output) == OutputKind::picture;
  return is_flat ? kFlattening : kExporting;
}

size_t write_layers(const ExportCommand& command, const LayeredPanorama& panorama, const Job& job) {
  OutputFolder folder(command.output, OutputFolder::Existing::refuse);
  size_t bytes = 0;
  for (const ExportedFile& file : export_layers(panorama, job)) {
    folder.fill([&] { write_file(folder.path() / file.name, file.bytes); });
    bytes += file.bytes.size();
  }
  job.check();
  folder.keep();
  return bytes;
}

// What would have no effect is a slip.
void check_used(const ExportCommand& command) {
  const std::string ending = names_a_folder(command.output) ? "" : extension_of(command.output);
  const auto given = [](const CLI::Option* option) { return option != nullptr && option->count() > 0; };
  const bool has_jpeg = ending == ".jpg" || ending == ".jpeg" || ending == ".glb";
  if (given(command.eyes) && command.kind != "stereo")
    throw BadInput("--eyes: only --kind stereo has two: add that, or leave --eyes out");
  if (given(command.plain) && ending != ".glb")
    throw BadInput("--plain: " + command.output + " is no .glb, which alone can be: leave --plain out");
  if (given(command.quality) && !has_jpeg)
    throw BadInput("--quality: " + command.output + " is no .jpg or .glb, which alone lose any: leave --quality out");
}

void check_output(const ExportCommand& command) {
  if (is_seen(command) && (names_a_folder(command.output) || exported_kind(command.output) != OutputKind::picture))
    throw BadInput(command.output + ": what is seen from a place is a picture: .jpg or .png");
  if (command.output.empty()) throw BadInput("the name of an output is empty: give the name of a file");
  if (names_a_folder(command.output)) {
    const OutputFolder refused_before_the_file_is_read(command.output, OutputFolder::Existing::refuse);
    return;
  }
  try {
    check_export_name(command.output);
  } catch (const std::runtime_error& error) {
    throw BadInput(error.what());
  }
  check_output_file(command.output, exported_kind(command.output));
}

size_t write_exported(const ExportCommand& command, LayeredPanorama&& panorama, const MappedFile& mapped,
                      const Job& job) {
  if (names_a_folder(command.output)) return write_layers(command, panorama, job);
  const Kind kind = kind_of(command.kind);
  const std::vector<uint8_t> exported =
      is_seen(command)
          ? export_seen(command.output, std::move(panorama), kind, viewer_of(command), command.options, job)
          : export_as(command.output, panorama, mapped.bytes(), command.options, job);
  job.check();
  write_output(command.output, exported);
  return exported.size();
}

void warn_of_places_far_off(const ExportCommand& command, const ViewingLimits& limits) {
  const bool placed = !command.at.empty(), stereo = command.kind == "stereo";
  if (!placed && !stereo) return;
  const double around = placed ? std::hypot(command.at[0], command.at[1]) : 0, up = placed ? command.at[2] : 0;
  const bool place_is_far = limits.are_far_from(around, up);
  if (!place_is_far && !(stereo && limits.are_far_from(around + command.viewer.eyes / 2, up))) return;
  std::fprintf(stderr,
               "ldp export: %s far from where views hold, %.3g around the axis and %.3g up and down: the picture is "
               "mostly invented\n",
               place_is_far ? "--at is" : "--eyes are", limits.outer_radius, limits.height);
}

void warn_of_no_depth(const ExportCommand& command, const PanoramaGrid& grid) {
  const bool points = !is_seen(command) && !names_a_folder(command.output) && extension_of(command.output) == ".ply";
  if (grid.w_near > 0 || (!points && command.kind != "depth")) return;
  std::fprintf(stderr, "ldp export: the photos show no parallax, all of it is at infinity: %s\n",
               points ? "there are no points" : "the depths tell nothing");
}

int run(const ExportCommand& command, const Session& session) {
  check_output(command);
  check_used(command);
  std::optional<ProgressBar> bar(session.progress_fd);
  const Job job = start_job(session, *bar);
  check_input_file(command.input.file);
  const MappedFile mapped(command.input.file);
  LayeredPanorama panorama = decode_panorama(command.input, mapped.bytes(), bytes_beside(command), job);
  const ViewingLimits limits = panorama.limits;
  const PanoramaGrid grid = panorama.grid;
  const size_t bytes = write_exported(command, std::move(panorama), mapped, job);
  bar.reset();
  warn_of_places_far_off(command, limits);
  warn_of_no_depth(command, grid);
  if (session.json)
    std::printf("%s\n", json_text(nlohmann::ordered_json{{"file", command.output}, {"bytes", bytes}}).c_str());
  else
    std::printf("%s: %s\n", printable(command.output).c_str(), size_text(bytes).c_str());
  return kDone;
}

}  // namespace

void add_export(Program& program) {
  auto command = std::make_shared<ExportCommand>();
  CLI::App& app = add_command(program, "export",
                              "A flat panorama, a mesh, points, a viewer, the cameras or layered images, by extension",
                              [command](const Session& session) { return run(*command, session); });
  add_panorama_input(app, command->input);
  app.add_option("-o,--output", command->output,
                 ".jpg or .png: flat panorama; .glb: textured mesh; .ply: points; .html: viewer; .json: cameras as "
                 "transforms.json; a folder (DIR/): layered images")
      ->required();
  app.add_option(
         "--kind", command->kind,
         "Of a .jpg or .png: panorama, all that one eye sees from a place; stereo, what two eyes see that turn "
         "with the head, the left one's sphere above the right one's; depth, a panorama with its depth inside as "
         "photo programs know it (GDepth), as .png its depth alone, 16 bits. Left out: the panorama as it was swept, "
         "what no photo shows filled from around it")
      ->check(CLI::IsMember({"panorama", "stereo", "depth"}));
  app.add_option("--at", command->at,
                 "X,Y,Z: the place, from the turn's axis: towards the sweep's middle, to its left, up; in the unit of "
                 "the capture, metres unless cameras were given")
      ->delimiter(',')
      ->expected(3)
      ->check(number_within(-1e6, 1e6));
  command->eyes = app.add_option("--eyes", command->viewer.eyes, "Of --kind stereo: their distance, in the same unit")
                      ->check(number_within(0, 1e6))
                      ->capture_default_str();
  command->plain =
      app.add_flag("--plain", command->options.plain, "A .glb for readers of bare glTF: several times as large");
  command->quality =
      app.add_option("--quality", command->options.quality, "Of the JPEG or WebP images in a .jpg or .glb")
          ->check(whole_within(1, 100))
          ->capture_default_str();
}

}  // namespace ldp
