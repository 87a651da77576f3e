// What can be wrong with a value of a configuration.
#pragma once

#include <string>

#include "device/service/config/config.h"

namespace ldp {

// Throws what is wrong with the text of a value.
using TextCheck = void (*)(const std::string& text);

void check_output_folder(const std::string& folder);
void check_build_program(const std::string& program);
void check_effort(const std::string& name);
void check_camera_is_there(const std::string& camera);  // besides being one, as far as a file tells
void check_button_is_there(const std::string& button);

// What a check throws; empty = good. Without a check everything is.
std::string complaint_of(TextCheck check, const std::string& text);

// Empty = good. Only a mode that was given can be wrong.
std::string wrong_mode(const Config& config);

}  // namespace ldp
