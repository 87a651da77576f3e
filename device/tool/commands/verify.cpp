// ldp verify: is an .ldp file sound?

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/base/files.h"
#include "core/base/markup_text.h"
#include "core/captures/json_text.h"
#include "device/tool/commands.h"
#include "device/tool/output.h"
#include "device/tool/panorama_input.h"
#include "device/tool/process/progress_bar.h"

namespace ldp {
namespace {

int check_file(const PanoramaInput& input, const Session& session) {
  const std::string& file = input.file;
  check_input_file(file);
  std::optional<ProgressBar> bar(session.progress_fd);
  const MappedFile mapped(file);
  const std::vector<std::string> damages = verify_panorama(input, mapped.bytes(), start_job(session, *bar));
  bar.reset();
  if (session.json) {
    const nlohmann::ordered_json json{{"file", file}, {"sound", damages.empty()}, {"damages", damages}};
    std::printf("%s\n", json_text(json, 1).c_str());
  } else if (damages.empty()) {
    std::printf("%s: sound\n", printable(file).c_str());
  }
  for (const std::string& damage : damages)
    std::fprintf(stderr, "ldp verify: %s: %s\n", printable(file).c_str(),
                 printable(refusal_of(mapped.bytes(), damage)).c_str());
  return damages.empty() ? kDone : kCannotBeDone;
}

}  // namespace

void add_verify(Program& program) {
  auto input = std::make_shared<PanoramaInput>();
  CLI::App& app = add_command(program, "verify", "Check every checksum and bound of an .ldp file",
                              [input](const Session& session) { return check_file(*input, session); });
  add_panorama_input(app, *input);
}

}  // namespace ldp
