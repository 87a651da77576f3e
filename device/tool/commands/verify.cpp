// ldp verify: is an .ldp file sound?

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/base/files.h"
#include "core/panorama/file/ldp_file.h"
#include "device/tool/commands.h"
#include "device/tool/output.h"
#include "device/tool/process/progress_bar.h"

namespace ldp {
namespace {

int check_file(const std::string& file, const Session& session) {
  check_input_file(file);
  std::optional<ProgressBar> bar(session.progress_fd);
  const MappedFile mapped(file);
  const std::vector<std::string> damages = verify_ldp(mapped.bytes(), start_job(session, *bar));
  bar.reset();
  if (session.json) {
    const nlohmann::ordered_json json{{"file", file}, {"sound", damages.empty()}, {"damages", damages}};
    std::printf("%s\n", json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
  } else if (damages.empty()) {
    std::printf("%s: sound\n", file.c_str());
  }
  for (const std::string& damage : damages) std::fprintf(stderr, "ldp verify: %s: %s\n", file.c_str(), damage.c_str());
  return damages.empty() ? kDone : kCannotBeDone;
}

}  // namespace

void add_verify(Program& program) {
  auto file = std::make_shared<std::string>();
  CLI::App& app = add_command(program, "verify", "Check every checksum and bound of an .ldp file",
                              [file](const Session& session) { return check_file(*file, session); });
  app.add_option("FILE", *file, "The .ldp file")->required();
}

}  // namespace ldp
