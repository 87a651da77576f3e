// ldpd: the capture service. Button pressed, arm turned, button released: a finished .ldp.
#include <CLI/CLI.hpp>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/markup_text.h"
#include "device/capture/log.h"
#include "device/service/capture_session.h"
#include "device/service/config/config.h"
#include "drivers/interface/standard_streams.h"

namespace {

constexpr int kBadConfiguration = 78;  // EX_CONFIG: systemd is told not to start again
constexpr int kBadArguments = 2;
constexpr int kTryAgain = 75;  // EX_TEMPFAIL
constexpr const char* kDefaultConfig = "/etc/ldpd.toml";

struct Arguments {
  std::optional<std::string> config_file, camera, button, output;
  std::string mode;
  std::vector<std::string> status;
  bool once = false, check_config = false, print_config = false;
};

void declare(CLI::App& app, Arguments& arguments) {
  app.set_version_flag("--version", "ldpd " LDP_VERSION);
  app.footer(
      "Exit status: 0 stopped or done, 1 no panorama was made or the service failed, 2 unusable arguments, 10 the "
      "button was held to switch off, 75 what was asked for could not be printed, 78 bad configuration.");
  app.add_option("--config", arguments.config_file,
                 std::string("configuration file; default ") + kDefaultConfig + " where it exists");
  app.add_option("--camera", arguments.camera, "libcamera:0, v4l2:/dev/video0, folder:DIR?fps=30, scene:NAME?fps=30");
  app.add_option("--button", arguments.button, "gpiod:name=LINE, gpiod:gpiochip0/17, script:FILE, keyboard:");
  app.add_option("--mode", arguments.mode,
                 "hold: while the button is held; toggle: press to begin, press to end; by default what the button can")
      ->check(CLI::IsMember({"hold", "toggle"}));
  app.add_option("--status", arguments.status,
                 "lcm:udpm://239.255.76.67:7667?ttl=0, led:name=LINE, console:; several allowed");
  app.add_option("-o,--output", arguments.output, "folder of the captures and panoramas");
  app.add_flag("--once", arguments.once, "one sweep and its build, then exit: 0 if a panorama was made, else 1");
  app.add_flag("--check-config", arguments.check_config,
               "name every mistake in the configuration with its line, and exit");
  app.add_flag("--print-config", arguments.print_config,
               "print the configuration as it holds, with comments, and exit");
}

// Mistakes in it go to standard error, one a line. False if there are any.
bool read_configuration(const Arguments& arguments, ldp::Config& config) {
  std::optional<std::string> file = arguments.config_file;
  if (!file && std::filesystem::exists(kDefaultConfig)) file = kDefaultConfig;
  if (file && file->empty()) {
    std::fputs("ldpd: the name of the configuration is empty: give the name of a file\n", stderr);
    return false;
  }
  bool good = true;
  if (file) {
    const ldp::CheckedConfig checked =
        ldp::read_config(*file, arguments.check_config ? ldp::Inputs::must_exist : ldp::Inputs::may_be_missing);
    for (const ldp::ConfigMistake& mistake : checked.mistakes) {
      const std::string line = mistake.line > 0 ? ":" + std::to_string(mistake.line) : "";
      std::fprintf(stderr, "%s\n", ldp::printable(*file + line + ": " + mistake.text).c_str());
    }
    config = checked.config;
    good = checked.mistakes.empty();
  }
  config.camera = arguments.camera.value_or(config.camera);
  config.button = arguments.button.value_or(config.button);
  config.output = arguments.output.value_or(config.output);
  if (!arguments.mode.empty()) config.mode = arguments.mode == "hold" ? ldp::ButtonMode::hold : ldp::ButtonMode::toggle;
  if (!arguments.status.empty()) config.status = arguments.status;
  return good;
}

// What was printed on a full disk is lost, and that is no success.
int with_all_printed(int status) {
  if (ldp::flush_standard_output() || status != 0) return status;
  std::fprintf(stderr, "ldpd: cannot write to standard output: %s\n", std::strerror(errno));
  return kTryAgain;
}

int serve(const Arguments& arguments) {
  ldp::Config config;
  if (!read_configuration(arguments, config)) return kBadConfiguration;
  const bool waits = !arguments.check_config && !arguments.once;
  const std::vector<ldp::ConfigMistake> wrong =
      ldp::wrong_values(config, waits ? ldp::Inputs::may_be_missing : ldp::Inputs::must_exist);
  for (const ldp::ConfigMistake& mistake : wrong)
    std::fprintf(stderr, "ldpd: --%s\n", ldp::printable(mistake.text).c_str());
  if (!wrong.empty()) return kBadArguments;
  if (arguments.print_config) std::fputs(ldp::config_text(config).c_str(), stdout);
  if (const int status = with_all_printed(0); status != 0) return status;
  if (arguments.print_config && !arguments.check_config) return 0;
  if (const auto program = ldp::program_of(config); !std::filesystem::exists(program)) {
    std::fprintf(stderr,
                 "ldpd: build.program: there is no %s: install ldp there, or name its path in the configuration\n",
                 ldp::printable(program.string()).c_str());
    return kBadConfiguration;
  }
  if (arguments.check_config) return 0;
  ldp::CaptureSession session(config, arguments.once ? ldp::Run::once : ldp::Run::service);
  return session.run();
}

}  // namespace

int main(int argc, char** argv) {
  ldp::keep_standard_streams();
  std::signal(SIGCHLD, SIG_DFL);  // a parent that ignored it left us so, and no build's end would be told
  std::signal(SIGXFSZ, SIG_IGN);  // what is beyond a limit on files cannot be written, which is told
  std::signal(SIGPIPE, SIG_IGN);  // who read our standard error may be gone
  CLI::App app("The capture service of the layered-depth-panorama camera: press, turn, release.", "ldpd");
  Arguments arguments;
  declare(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return with_all_printed(app.exit(error));
    std::fprintf(stderr, "ldpd: %s: see ldpd --help\n", ldp::printable(error.what()).c_str());
    return kBadArguments;
  }
  try {
    return serve(arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ldpd: %s\n", ldp::printable(error.what()).c_str());
    return 1;
  }
}
