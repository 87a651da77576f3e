// ldp serve: the panoramas of a folder in a browser.

#include <fcntl.h>

#include <cstdio>
#include <fstream>
#include <memory>
#include <string>

#include "core/base/markup_text.h"
#include "device/backends/open.h"
#include "device/gallery/cut_files.h"
#include "device/gallery/gallery.h"
#include "device/gallery/http/server.h"
#include "device/tool/commands.h"
#include "device/tool/memory_size.h"
#include "device/tool/output.h"

namespace ldp {
namespace {

struct ServeCommand {
  std::string folder, listen = "127.0.0.1:8080", status, token_file;
  uint64_t memory_bytes = 0;
};

// One line, of a pipe too; what stands behind it is none of it.
std::string token_in(const std::string& file) {
  if (file.empty()) return {};
  check_input(file);
  std::ifstream stream(file);
  std::string token;
  if (!std::getline(stream, token) || token.size() < gallery::kShortestToken)
    throw BadInput("--token-file " + file + ": its first line is to be a token of at least " +
                   std::to_string(gallery::kShortestToken) + " characters");
  return token;
}

gallery::Folder open_folder(const std::string& folder) {
  try {
    return gallery::Folder(folder);
  } catch (const std::system_error& error) {
    throw BadInput(error.what() + std::string(": give the folder of the panoramas"));
  }
}

// An address that can never be one is refused; a network that is not there yet is waited for.
gallery::LiveFeed::Open opener_of(const std::string& status) {
  if (status.empty()) return {};
  check_status(status);
  return [status] { return open_status_listener(status); };
}

int run(const ServeCommand& command, const Session& session) {
  const gallery::Folder folder = open_folder(command.folder);
  gallery::GalleryOptions options{token_in(command.token_file), {}};
  if (command.memory_bytes > 0) options.conversions.memory_bytes = command.memory_bytes;
  UniqueFd listening = gallery::inherited_socket();
  if (!listening.is_open()) listening = gallery::listen_on(command.listen);
  gallery::LiveFeed feed(opener_of(command.status));
  Job job;
  job.threads = session.thread_count();
  job.stop = session.stop;
  gallery::read_cut_files_as_zeros();
  gallery::Gallery gallery(folder, feed, options, job);
  const auto say_where = [&] {
    std::printf("%s shows %s\n", gallery::address_of(listening.get()).c_str(), printable(command.folder).c_str());
    std::fflush(stdout);
  };
  gallery::serve(listening.get(),
                 {[&](const gallery::Asked& asked) { return gallery.answer(asked); },
                  [&](UniqueFd follower) { feed.add(std::move(follower)); }, say_where},
                 session.stop);
  return kDone;
}

}  // namespace

void add_serve(Program& program) {
  auto command = std::make_shared<ServeCommand>();
  CLI::App& app = add_command(program, "serve", "A gallery of the panoramas of a folder, for browsers",
                              [command](const Session& session) { return run(*command, session); });
  app.add_option("FOLDER", command->folder, "Holds .ldp files, as the capture service's folder does")->required();
  app.add_option("--listen", command->listen,
                 "HOST:PORT; :8080 for every address of this machine. Not looked at when systemd hands over a socket")
      ->capture_default_str();
  app.add_option("--status", command->status,
                 "A device's LCM address, such as lcm:udpm://239.255.76.67:7667?ttl=0, for the live display; left out: "
                 "none");
  app.add_option("--token-file", command->token_file,
                 "Its first line lets who knows it start, stop, cancel and delete; left out: nothing can be changed");
  app.add_option("--memory", command->memory_bytes, "That converting a panorama to .jpg or .glb may take; 0 = 512M")
      ->transform(memory_size("512M"))
      ->default_str("0");
}

}  // namespace ldp
