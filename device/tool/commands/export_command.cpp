// ldp export: an .ldp file in a form that other programs open.

#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "core/base/files.h"
#include "core/export/export.h"
#include "core/photos/images.h"
#include "device/tool/commands.h"
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
};

// Measured: the pictures and the viewer take up to 5 bytes a pixel, a mesh 45 for each point of it.
constexpr BytesBeside kExporting{.per_pixel = 5, .per_present_pixel = 64, .always = 16 << 20};

std::string size_text(size_t bytes) {
  char text[32];
  const double kilobytes = static_cast<double>(bytes) / 1e3;
  std::snprintf(text, sizeof text, kilobytes < 1000 ? "%.1f kB" : "%.1f MB",
                kilobytes < 1000 ? kilobytes : kilobytes / 1e3);
  return text;
}

int run(const ExportCommand& command, const Session& session) {
  try {
    check_export_name(command.output);
  } catch (const std::runtime_error& error) {
    throw BadInput(error.what());
  }
  check_output_file(command.output, exported_kind(command.output));
  std::optional<ProgressBar> bar(session.progress_fd);
  const Job job = start_job(session, *bar);
  check_input_file(command.input.file);
  const MappedFile mapped(command.input.file);
  const LayeredPanorama panorama = decode_panorama(command.input, mapped.bytes(), kExporting, job);
  const std::vector<uint8_t> exported = export_as(command.output, panorama, mapped.bytes(), command.options, job);
  job.check();
  write_output(command.output, exported);
  bar.reset();
  if (!session.json) std::printf("%s: %s\n", command.output.c_str(), size_text(exported.size()).c_str());
  return kDone;
}

}  // namespace

void add_export(Program& program) {
  auto command = std::make_shared<ExportCommand>();
  CLI::App& app = add_command(program, "export", "A flat panorama, a mesh, a viewer or the cameras, by extension",
                              [command](const Session& session) { return run(*command, session); });
  add_panorama_input(app, command->input);
  app.add_option("-o,--output", command->output,
                 ".jpg or .png: flat panorama; .glb: textured mesh; .html: viewer; .json: cameras as transforms.json")
      ->required();
  app.add_flag("--plain", command->options.plain, "A .glb for readers of bare glTF: several times as large");
  app.add_option("--quality", command->options.quality, "Of JPEG images")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
}

}  // namespace ldp
