// ldp-card: what a person wrote into camera.toml becomes the configuration of the services on the card.
#include <poll.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>

#include "core/base/files.h"
#include "core/base/markup_text.h"
#include "device/backends/open.h"
#include "device/card/card_files.h"

namespace {

namespace fs = std::filesystem;

constexpr int kBadArguments = 2;
constexpr int kBadConfiguration = 78;  // EX_CONFIG

struct Arguments {
  std::string camera_toml, output, report;
  bool blink = false;
};

void declare(CLI::App& app, Arguments& arguments) {
  app.set_version_flag("--version", "ldp-card " LDP_VERSION);
  app.footer("Exit status: 0 done, 1 failed, 2 unusable arguments, 78 mistakes in the file, every one named.");
  app.add_option("FILE", arguments.camera_toml, "camera.toml; the defaults hold where it is missing")->required();
  const auto named = [](const std::string& name) { return name.empty() ? "the name is empty" : ""; };
  app.add_option("-o,--output", arguments.output,
                 "folder of the services' files, made where it is missing; without, the file is only checked")
      ->check(named);
  app.add_option("--report", arguments.report, "where mistakes are told to people")->check(named);
  app.add_flag("--blink", arguments.blink, "only blink the LED that the file names, as after a failure, for ever");
}

void complain(const std::exception& error, const char* remedy = "") {
  std::fprintf(stderr, "ldp-card: %s%s\n", ldp::printable(error.what()).c_str(), remedy);
}

ldp::CheckedCard read_card(const fs::path& file) {
  if (file.empty()) throw std::runtime_error("the name of the file is empty: give that of camera.toml");
  if (!fs::exists(file)) return {.there = false, .settings = {}, .mistakes = {}};
  std::ifstream in(file);
  in.peek();  // a folder fails here; an empty file is a good one
  if (!in.is_open() || in.bad()) throw std::runtime_error("cannot read " + file.string());
  std::ostringstream text;
  text << in.rdbuf();
  return ldp::parse_card(text.str());
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw std::runtime_error("cannot make the folder " + folder.string() + ": " + error.message());
}

void write_files(const ldp::CardSettings& settings, const fs::path& folder) {
  for (const ldp::CardFile& file : ldp::card_files(settings)) {
    const fs::path path = folder / file.path;
    make_folder(path.parent_path());
    if (file.secret)
      ldp::write_secret_file(path, file.text);
    else
      ldp::write_file(path, file.text);
  }
}

[[noreturn]] void blink(const ldp::CardSettings& settings) {
  const auto led = ldp::open_status(ldp::led_url(settings));
  ldp::Status failed;
  failed.phase = ldp::Phase::failed;
  failed.sweeps_left = 1;  // it is not the card that is full
  led->publish(failed);
  for (;;) {
    pollfd entry{led->fd(), POLLIN, 0};
    ::poll(&entry, 1, -1);
    led->read();
  }
}

// Mistakes are what a person has to know of, whether the card has room to tell them on or not: they decide the status.
void report(const fs::path& file, const ldp::CheckedCard& checked) {
  try {
    ldp::write_file(file, ldp::card_report(checked, LDP_VERSION));
  } catch (const std::exception& error) {
    if (checked.mistakes.empty()) throw;
    complain(error);
  }
}

int run(const Arguments& arguments) {
  const ldp::CheckedCard checked = read_card(arguments.camera_toml);
  if (arguments.blink) blink(checked.settings);
  const std::string shown = ldp::printable(arguments.camera_toml);
  for (const ldp::ConfigMistake& mistake : checked.mistakes)
    std::fprintf(stderr, "%s:%d: %s\n", shown.c_str(), mistake.line, ldp::printable(mistake.text).c_str());
  if (!checked.there) std::fprintf(stderr, "ldp-card: there is no %s: the defaults hold\n", shown.c_str());
  if (!arguments.report.empty()) report(arguments.report, checked);
  if (!checked.mistakes.empty()) return kBadConfiguration;
  if (!arguments.output.empty()) write_files(checked.settings, arguments.output);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Configures a camera from camera.toml on its card.", "ldp-card");
  Arguments arguments;
  declare(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    complain(error, ": see ldp-card --help");
    return kBadArguments;
  }
  try {
    return run(arguments);
  } catch (const std::exception& error) {
    complain(error);
    return 1;
  }
}
