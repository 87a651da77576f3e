// The commands of `ldp`, one file each. Each function adds its command, options and help to the program; what the
// command does is run by main after the whole line was understood, through `chosen`.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "device/tool/session.h"

namespace ldp {

struct Failure {
  int status = kInternalError;
  std::string text;  // one line
};

struct Program {
  CLI::App app;
  std::string name;  // ldp or ldp-device
  Session session;
  std::string command;                         // name of the one chosen
  std::function<int()> chosen;                 // returns the exit status
  std::function<void(const Failure&)> failed;  // may be empty; is told after the person was, and may throw
};

// A command whose `run` is called with the session when it was chosen. Adds the options that all commands have.
CLI::App& add_command(Program& program, const std::string& name, const std::string& what,
                      const std::function<int(const Session&)>& run);

// All commands of this program: `ldp` itself, or `ldp-device`, which holds those that need camera and message libraries
// and is run by `ldp` so that building and rendering do without them.
void add_commands(Program& program);

void add_build(Program& program);
void add_render(Program& program);
void add_info(Program& program);
void add_verify(Program& program);
void add_export(Program& program);
void add_evaluate(Program& program);
void add_poses(Program& program);
void add_scene(Program& program);
void add_summary(Program& program);
void add_capture(Program& program);
void add_watch(Program& program);
void add_serve(Program& program);

// "800x600", sides from 16 to 8192; throws BadInput.
void parse_size(const std::string& text, int& width, int& height);

}  // namespace ldp
