// ldp summary: what became of many builds.

#include <cstdio>
#include <memory>
#include <string>

#include "core/base/markup_text.h"
#include "core/captures/json_text.h"
#include "device/tool/commands.h"
#include "device/tool/many/build_outcomes.h"
#include "device/tool/output.h"
#include "device/tool/own_output.h"

namespace ldp {
namespace {

struct SummaryCommand {
  std::string folder, page;
};

int run(const SummaryCommand& command, const Session& session) {
  if (!command.page.empty()) check_output_file(command.page, OutputKind::summary);
  const std::vector<BuildOutcome> outcomes = outcomes_in(command.folder);
  if (!command.page.empty()) write_text(command.page, summary_page(kSummaryTitle, outcomes));
  if (session.json)
    std::printf("%s\n", json_text(summary_json(outcomes), 1).c_str());
  else
    std::fputs(summary_table(outcomes).c_str(), stdout);
  if (outcomes.empty())
    std::fprintf(stderr, "ldp summary: %s: holds neither panoramas (.ldp) nor reports of builds\n",
                 printable(command.folder).c_str());
  return kDone;
}

}  // namespace

void add_summary(Program& program) {
  auto command = std::make_shared<SummaryCommand>();
  CLI::App& app = add_command(program, "summary", "What became of many builds: their verdicts, failures and cost",
                              [command](const Session& session) { return run(*command, session); });
  app.add_option("DIR", command->folder, "Folder of .ldp files and reports (build --report NAME.json beside NAME.ldp)")
      ->required();
  app.add_option("--html", command->page, "Write a page with thumbnails and verdicts, the worst first, to this file");
}

}  // namespace ldp
