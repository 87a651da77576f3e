// What every function of the C interface does at its door: no exception leaves, structs of other versions are
// understood.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <functional>
#include <stdexcept>
#include <stop_token>
#include <string>

#include "core/base/job.h"
#include "device/library/ldp.h"

struct ldp_stop {
  std::stop_source source;
};

namespace ldp::library {

// What a caller is told, with its status.
struct Refusal : std::runtime_error {
  Refusal(ldp_status given, const std::string& what) : std::runtime_error(what), status(given) {}
  ldp_status status;
};

// Runs body; what it throws becomes a status and, in *error where there is one, "ATTEMPTED: what was found".
ldp_status guarded(const std::function<std::string()>& attempted, ldp_error* error, const std::function<void()>& body);
ldp_status guarded(const char* attempted, ldp_error* error, const std::function<void()>& body);

template <typename T>
T& required(T* pointer, const char* name) {
  if (pointer == nullptr) throw Refusal(LDP_BAD_ARGUMENT, std::string(name) + " is a null pointer");
  return *pointer;
}

void check_index(const char* what, int index, size_t count);

Job job_of(int threads, const ldp_stop* stop);

// A caller's struct. Fields that only newer callers know must be zero.
template <typename Struct>
Struct taken(const Struct* given, const char* name) {
  const size_t bytes = required(given, name).struct_bytes;
  if (bytes < sizeof(Struct))
    throw Refusal(LDP_BAD_ARGUMENT, std::string(name) + "->struct_bytes is " + std::to_string(bytes) + ", expected " +
                                        std::to_string(sizeof(Struct)) + ": set it by LDP_INIT");
  const auto* const raw = reinterpret_cast<const unsigned char*>(given);
  if (std::any_of(raw + sizeof(Struct), raw + bytes, [](unsigned char byte) { return byte != 0; }))
    throw Refusal(LDP_BAD_ARGUMENT, std::string(name) + ": has fields that this version of the library does not know");
  return *given;
}

// The same of a result: its size stays the caller's.
template <typename Struct>
void give(Struct value, Struct& target) {
  value.struct_bytes = target.struct_bytes;
  std::memcpy(&target, &value, sizeof(Struct));
}

template <typename Struct>
void check_result(const Struct* target, const char* name) {
  if (required(target, name).struct_bytes < sizeof(Struct))
    throw Refusal(LDP_BAD_ARGUMENT, std::string(name) + "->struct_bytes is too small: set it by LDP_INIT");
}

}  // namespace ldp::library
