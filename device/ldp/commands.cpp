// The commands of ldp. Those that need drivers are in ldp-device beside it, which takes over.

#include "commands.h"

#include <unistd.h>

#include <csignal>
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

void add_commands(Program& program) {
  add_device_command(program, "capture", "One sweep of a camera into a capture folder");
  add_device_command(program, "watch", "Show what a device tells over LCM, or send it a command");
  add_scene(program);
}

}  // namespace ldp
