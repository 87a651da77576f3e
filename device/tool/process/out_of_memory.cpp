#include "device/tool/process/out_of_memory.h"

#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <exception>
#include <new>

#include "device/tool/process/interrupt.h"
#include "device/tool/session.h"

namespace ldp {
namespace {

constexpr size_t kReserve = 1 << 20;  // bytes that the last steps may take

std::string* said = nullptr;
std::atomic<void*> reserve;  // several threads may come to their end at once
std::terminate_handler otherwise = nullptr;
thread_local bool was_refused = false;

[[noreturn]] void refuse() {
  was_refused = true;
  throw std::bad_alloc();
}

// What a destructor lets go ends the program before anything has caught it: it cannot be looked at, but is on its way.
// It is taken for the end of memory in a thread that was ever refused some, which is wrong where that was mended and
// another exception comes to such an end.
bool memory_ended() {
  if (was_refused && std::uncaught_exceptions() > 0 && !std::current_exception()) return true;
  try {
    if (const std::exception_ptr cause = std::current_exception()) std::rethrow_exception(cause);
  } catch (const std::bad_alloc&) {
    return true;
  } catch (...) {
  }
  return false;
}

void end() {
  if (memory_ended()) {
    std::free(reserve.exchange(nullptr));
    cut_off(kTryAgain, *said);
  }
  otherwise();
}

}  // namespace

void say_when_memory_ends(const std::string& line) {
  static auto* const alive_for_ever = new std::string;  // other threads outlive main
  *alive_for_ever = line + "\n";
  said = alive_for_ever;
  if (reserve.load() == nullptr) reserve = std::malloc(kReserve);
  std::set_new_handler(refuse);
  if (otherwise == nullptr) otherwise = std::set_terminate(end);
}

}  // namespace ldp
