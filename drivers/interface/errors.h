// errno as an exception that says what was attempted on what, and back.
#pragma once

#include <cerrno>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>

namespace ldp {

[[noreturn]] inline void throw_errno(const std::string& attempted, int error = errno) {
  throw std::system_error(error, std::generic_category(), attempted);
}

// What to do about it stands behind the system's words.
class AdvisedError : public std::system_error {
 public:
  AdvisedError(const std::string& attempted, int error, const std::string& advice)
      : std::system_error(error, std::generic_category(), attempted),
        text_(std::string(std::system_error::what()) + ": " + advice) {}
  const char* what() const noexcept override { return text_.what(); }

 private:
  std::runtime_error text_;  // unlike a string's, its copy cannot throw
};

// Of the system call that failed, or of memory that ended; none where it was neither.
inline std::error_code code_of(const std::exception& error) {
  if (const auto* const of_system = dynamic_cast<const std::system_error*>(&error)) return of_system->code();
  const bool is_memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
  return is_memory ? std::make_error_code(std::errc::not_enough_memory) : std::error_code();
}

}  // namespace ldp
