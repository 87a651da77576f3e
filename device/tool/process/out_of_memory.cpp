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

bool memory_ended() {
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
  if (otherwise == nullptr) otherwise = std::set_terminate(end);
}

}  // namespace ldp
