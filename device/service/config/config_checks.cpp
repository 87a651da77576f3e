#include "device/service/config/config_checks.h"

#include <unistd.h>

#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "core/pipeline/effort.h"
#include "device/backends/open.h"
#include "drivers/interface/url.h"

namespace ldp {
namespace {

bool can_be_held(const std::string& button) { return !button.starts_with("keyboard:"); }

bool is_directory_at(const std::string& path) {
  std::error_code error;
  return std::filesystem::is_directory(path, error);
}

}  // namespace

void check_output_folder(const std::string& folder) {
  std::error_code error;
  if (folder.empty()) throw std::runtime_error("is empty: give the folder of the captures and panoramas");
  if (std::filesystem::exists(folder, error) && !std::filesystem::is_directory(folder, error))
    throw std::runtime_error("'" + folder + "' is no folder: give one, or remove that");
}

void check_camera_is_there(const std::string& camera) {
  check_camera(camera);
  const Url url(camera);
  if (url.scheme() == "folder" && !is_directory_at(url.path()))
    throw std::runtime_error("'" + url.text() + "': there is no folder '" + url.path() + "': check its name");
}

void check_button_is_there(const std::string& button) {
  check_button(button);
  const Url url(button);
  std::error_code error;
  if (url.scheme() == "script" && (is_directory_at(url.path()) || !std::filesystem::exists(url.path(), error)))
    throw std::runtime_error("'" + url.text() + "': there is no file '" + url.path() + "': check its name");
}

void check_build_program(const std::string& program) {
  std::error_code error;
  if (program.empty()) return;
  if (!std::filesystem::exists(program, error))
    throw std::runtime_error("there is no '" + program +
                             "': give the whole path of ldp, or nothing for the one beside ldpd");
  if (std::filesystem::is_directory(program, error) || ::access(program.c_str(), X_OK) != 0)
    throw std::runtime_error("'" + program + "' cannot be run: give the whole path of ldp, or make it executable");
}

void check_effort(const std::string& name) {
  if (!effort_named(name)) throw std::runtime_error("expected \"fast\", \"standard\" or \"best\"");
}

std::string complaint_of(TextCheck check, const std::string& text) {
  try {
    if (check != nullptr) check(text);
    return {};
  } catch (const std::exception& error) {
    return error.what();
  }
}

ButtonMode mode_of(const Config& config) {
  return config.mode.value_or(can_be_held(config.button) ? ButtonMode::hold : ButtonMode::toggle);
}

std::string wrong_mode(const Config& config) {
  if (config.mode != ButtonMode::hold || can_be_held(config.button)) return {};
  return "a terminal does not tell when a key is let go: keyboard: needs the mode toggle";
}

}  // namespace ldp
