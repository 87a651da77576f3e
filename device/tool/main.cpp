// ldp: sweeps, panoramas and views from the command line.

#include <fcntl.h>
#include <malloc.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <new>
#include <system_error>

#include "core/base/markup_text.h"
#include "device/tool/commands.h"
#include "device/tool/number_within.h"
#include "device/tool/process/interrupt.h"
#include "device/tool/process/out_of_memory.h"
#include "device/tool/process/progress_bar.h"
#include "device/tool/switches.h"
#include "drivers/interface/standard_streams.h"

namespace ldp {
namespace {

// None of that name: nullptr.
const CLI::App* command_of(const CLI::App& app, const std::string& name) {
  const auto named = app.get_subcommands([&](const CLI::App* command) { return command->get_name() == name; });
  return named.empty() ? nullptr : named.front();
}

std::string name_of(const Program& program) {
  return program.command.empty() ? program.name : program.name + " " + program.command;
}

// `ldp`, which ldp-device is called where that took over.
std::string own_name(int argc, char** argv) {
  const std::string called = argc > 0 ? std::filesystem::path(argv[0]).filename().string() : std::string();
  return called == "ldp-device" ? called : "ldp";
}

std::string line_from(const Program& program, const std::string& message) {
  std::string line = name_of(program) + ": " + message;
  for (char& c : line) c = c == '\n' ? ' ' : c;
  return printable(line);
}

std::string open_descriptor(const std::string& text) {
  int descriptor = -1;
  const bool open = CLI::detail::lexical_cast(text, descriptor) && ::fcntl(descriptor, F_GETFD) >= 0;
  return open ? std::string() : "Value " + text + " is no open file descriptor";
}

int complain(const Program& program, const std::string& message, int status) {
  std::fprintf(stderr, "%s\n", line_from(program, message).c_str());
  return status;
}

// By what the command can be told.
std::string out_of_memory(const Program& program) {
  const CLI::App* const command = command_of(program.app, program.command);
  const auto takes = [&](const char* option) {
    return command != nullptr && command->get_option_no_throw(option) != nullptr;
  };
  std::string remedy = takes("--size") ? "make smaller pictures (--size)" : "free some";
  if (takes("--megapixels")) remedy = "use fewer photos, or smaller ones (--megapixels)";
  if (takes("--memory")) remedy += ", or a coarser panorama (--memory)";
  if (program.session.threads > 1) remedy += ", or fewer --threads";
  return "not enough memory: " + remedy;
}

// The parser asks for what is missing before it tells of what it does not know, a misspelt option among it.
std::string complaint_of(const CLI::ParseError& error, const CLI::App& app) {
  if (error.get_name() != "RequiredError") return error.what();
  for (const std::string& word : app.remaining(true))
    if (word.starts_with('-') && word != "--") return CLI::ExtrasError({word}).what();
  return error.what();
}

int parse(Program& program, int argc, char** argv) {
  const std::string first = argc > 1 ? argv[1] : "-";
  if (!first.starts_with('-') && command_of(program.app, first) == nullptr)
    return complain(program, "there is no command '" + first + "': see " + program.name + " --help", kBadInput);
  try {
    program.app.parse(argc, argv);
  } catch (const CLI::Success& request) {  // help or version
    return program.app.exit(request);
  } catch (const CLI::ParseError& error) {
    if (command_of(program.app, first) != nullptr) program.command = first;
    return complain(program, complaint_of(error, program.app) + ": see " + name_of(program) + " --help", kBadInput);
  }
  return kDone;
}

// One line, one status: see session.h. What a file holds that cannot be read comes as runtime_error.
Failure failure_of(const Program& program, const std::exception_ptr& cause) {
  try {
    std::rethrow_exception(cause);
  } catch (const BadInput& error) {
    return {kBadInput, error.what()};
  } catch (const Impossible& error) {
    return {kCannotBeDone, with_switches(error.what())};
  } catch (const std::bad_alloc&) {
    return {kTryAgain, out_of_memory(program)};
  } catch (const MachineFault& error) {
    return {kTryAgain, with_remedy(error.what())};
  } catch (const std::filesystem::filesystem_error& error) {  // of looking at what was named
    if (is_machine_fault(error.code())) return {kTryAgain, with_remedy(words_of(error))};
    return {kBadInput, words_of(error) + ": check the name and its permissions"};
  } catch (const std::system_error& error) {
    return {is_machine_fault(error.code()) ? kTryAgain : kCannotBeDone, with_remedy(error.what())};
  } catch (const std::invalid_argument& error) {
    return {kBadInput, with_switches(error.what())};
  } catch (const std::runtime_error& error) {
    return {kBadInput, with_switches(error.what())};
  } catch (const std::exception& error) {
    return {kInternalError, std::string("internal error: ") + error.what() + ": please report it"};
  }
}

int run(const Program& program) {
  say_when_memory_ends(line_from(program, out_of_memory(program)));
  say_when_interrupted(name_of(program));
  try {
    return program.chosen();
  } catch (const Cancelled&) {
    std::fputs(take_interrupted_line().c_str(), stderr);
    return kInterrupted;
  } catch (...) {
    const Failure failure = failure_of(program, std::current_exception());
    complain(program, failure.text, failure.status);
    try {
      if (program.failed) program.failed(failure);
    } catch (const std::exception&) {  // the person knows already
    }
    return failure.status;
  }
}

// What was printed on a full disk is lost, and that is no success. A cause that is unknown by now was a moment's.
int with_all_printed(const Program& program, int status) {
  if (flush_standard_output() || status != kDone) return status;
  const int error = errno;
  const std::string why = error == 0 ? std::string() : std::string(": ") + std::strerror(error);
  const bool try_again = error == 0 || is_machine_fault({error, std::generic_category()});
  return complain(program, with_remedy("cannot write to standard output" + why), try_again ? kTryAgain : kCannotBeDone);
}

}  // namespace

CLI::App& add_command(Program& program, const std::string& name, const std::string& what,
                      const std::function<int(const Session&)>& run) {
  CLI::App& command = *program.app.add_subcommand(name, what);
  command.add_option("--threads", program.session.threads, "Threads to use; 0 = one per processor")
      ->check(whole_within(0, 256));
  command.add_flag("--json", program.session.json, "Print machine-readable output");
  command
      .add_option(
          "--progress-fd", program.session.progress_fd,
          "Write lines FRACTION STAGE to this file descriptor, that a parent opened; a stage 'so far: ...' is what is "
          "wrong with a sweep")
      ->check(open_descriptor);
  command.callback([&program, name, run] {
    program.command = name;
    program.chosen = [&program, run] { return run(program.session); };
  });
  return command;
}

// Planes come and go with the stages. Each in a mapping of its own goes back to the system when it is freed and not
// kept (large_arrays.h), so that the peak is that of one stage, not the sum of what fragments leave behind. What one
// thread frees another takes.
void return_freed_memory() {
#if defined(__GLIBC__)
  mallopt(M_MMAP_THRESHOLD, 1 << 18);
  mallopt(M_ARENA_MAX, 1);
#endif
}

}  // namespace ldp

int main(int argc, char** argv) try {
  ldp::keep_standard_streams();
  std::signal(SIGCHLD, SIG_DFL);  // a parent that ignored it left us so, and how a film's program ended would be lost
  std::signal(SIGXFSZ, SIG_IGN);  // what is beyond ulimit -f cannot be written, which is told
  ldp::return_freed_memory();
  ldp::Interrupt interrupt;
  ldp::Program program;
  program.name = ldp::own_name(argc, argv);
  program.app.description("Layered depth panoramas: from one arm's-length sweep of a camera to views with parallax");
  program.app.set_version_flag("--version", program.name + " " LDP_VERSION);
  program.app.require_subcommand(1);
  program.session.stop = interrupt.token();
  ldp::add_commands(program);
  program.app.footer(  // commands take over what is set before they are added
      "Exit status: 0 done, 1 the job cannot be done or 'verify' found damage, 2 unusable arguments or unreadable "
      "input (a damaged .ldp among it), 70 an internal error, 75 the machine is at fault, as by a full disk or too "
      "little memory: try again, 130 interrupted.");
  const int parsed = ldp::parse(program, argc, argv);
  const int status = ldp::with_all_printed(program, program.chosen ? ldp::run(program) : parsed);
  if (!interrupt.came()) return status;
  // The work was done by then. Programs that go on until Ctrl-C write nothing.
  if (ldp::is_anything_written()) std::fputs(ldp::take_interrupted_line().c_str(), stderr);
  return ldp::kInterrupted;
} catch (const std::exception& error) {  // before there is a command: no room for the thread that waits for Ctrl-C
  std::fprintf(stderr, "ldp: cannot start: %s\n", ldp::printable(error.what()).c_str());
  return ldp::kTryAgain;
}
