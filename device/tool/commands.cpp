// The commands of ldp. Those that need drivers are in ldp-device beside it, which takes over.

#include "device/tool/commands.h"

#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>
#include <vector>

namespace ldp {
namespace {

// Runs ldp-device with the same words; returns only if that fails.
[[noreturn]] void take_over(const std::string& name, const std::vector<std::string>& rest) {
  const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "ldp-device";
  std::vector<std::string> words{"ldp", name};
  words.insert(words.end(), rest.begin(), rest.end());
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  sigset_t none;
  sigemptyset(&none);
  ::pthread_sigmask(SIG_SETMASK, &none, nullptr);
  ::execv(program.c_str(), arguments.data());
  throw std::system_error(errno, std::generic_category(), name + " needs the program " + program.string());
}

void add_device_command(Program& program, const std::string& name, const std::string& what) {
  CLI::App& command = *program.app.add_subcommand(name, what);
  command.set_help_flag();  // ldp-device prints it
  command.prefix_command();
  command.callback([&program, &command, name] {
    program.command = name;
    program.chosen = [&command, name]() -> int { take_over(name, command.remaining()); };
  });
}

}  // namespace

void parse_size(const std::string& text, int& width, int& height) {
  char rest = 0;
  const int read = std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest);
  if (read != 2 || width < 16 || height < 16 || width > 8192 || height > 8192)
    throw BadInput("--size " + text + ": is not WIDTHxHEIGHT with sides from 16 to 8192, such as 800x600");
}

void add_commands(Program& program) {
  add_device_command(program, "capture", "One sweep of a camera into a capture folder");
  add_build(program);
  add_render(program);
  add_info(program);
  add_verify(program);
  add_export(program);
  add_evaluate(program);
  add_poses(program);
  add_scene(program);
  add_summary(program);
  add_device_command(program, "serve", "A gallery of the panoramas of a folder, for browsers");
  add_device_command(program, "watch", "Show what a device tells over LCM, or send it a command");
}

}  // namespace ldp
