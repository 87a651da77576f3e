// errno as an exception that says what was attempted on what.
#pragma once

#include <cerrno>
#include <string>
#include <system_error>

namespace ldp {

[[noreturn]] inline void throw_errno(const std::string& attempted, int error = errno) {
  throw std::system_error(error, std::generic_category(), attempted);
}

}  // namespace ldp
