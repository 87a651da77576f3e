#include "device/library/doors.h"

#include <cstdio>
#include <new>
#include <system_error>

#include "core/panorama/file/ldp_file.h"

namespace ldp::library {
namespace {

ldp_status tell(ldp_error* error, ldp_status status, const char* attempted, const char* found) {
  if (error != nullptr) {
    error->status = status;
    std::snprintf(error->message, sizeof error->message, "%s: %s", attempted, found);
  }
  return status;
}

// In the exception's handler.
ldp_status told(ldp_error* error, const char* attempted) {
  try {
    throw;
  } catch (const Refusal& refusal) {
    return tell(error, refusal.status, attempted, refusal.what());
  } catch (const Cancelled&) {
    return tell(error, LDP_STOPPED, attempted, "stopped");
  } catch (const LdpError& damage) {
    return tell(error, LDP_DAMAGED, attempted, damage.what());
  } catch (const std::bad_alloc&) {
    return tell(error, LDP_OUT_OF_MEMORY, attempted, "not enough memory");
  } catch (const std::length_error&) {
    return tell(error, LDP_OUT_OF_MEMORY, attempted, "not enough memory");
  } catch (const std::system_error& refusal) {
    return tell(error, LDP_NOT_READABLE, attempted, refusal.what());
  } catch (const std::runtime_error& refusal) {
    return tell(error, LDP_BAD_ARGUMENT, attempted, refusal.what());
  } catch (const std::exception& fault) {
    return tell(error, LDP_INTERNAL, attempted, fault.what());
  } catch (...) {
    return tell(error, LDP_INTERNAL, attempted, "an unknown fault");
  }
}

}  // namespace

ldp_status guarded(const std::function<std::string()>& attempted, ldp_error* error, const std::function<void()>& body) {
  std::string words;
  try {
    words = attempted();
    body();
    return LDP_OK;
  } catch (...) {
    return told(error, words.c_str());
  }
}

ldp_status guarded(const char* attempted, ldp_error* error, const std::function<void()>& body) {
  try {
    body();
    return LDP_OK;
  } catch (...) {
    return told(error, attempted);
  }
}

void check_index(const char* what, int index, size_t count) {
  if (index < 0 || static_cast<size_t>(index) >= count)
    throw Refusal(LDP_BAD_ARGUMENT,
                  "there is no " + std::string(what) + " " + std::to_string(index) + " of " + std::to_string(count));
}

Job job_of(int threads, const ldp_stop* stop) {
  if (threads < 0 || threads > 256)
    throw Refusal(LDP_BAD_ARGUMENT, "threads is " + std::to_string(threads) + ", expected 0 to 256");
  Job job;
  job.threads = std::max(1, threads);
  if (stop != nullptr) job.stop = stop->source.get_token();
  return job;
}

}  // namespace ldp::library

using namespace ldp::library;

const char* ldp_version() { return LDP_VERSION; }

ldp_stop* ldp_stop_new() {
  try {
    return new ldp_stop;
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

void ldp_stop_request(ldp_stop* stop) {
  if (stop != nullptr) stop->source.request_stop();
}

void ldp_stop_free(ldp_stop* stop) { delete stop; }
