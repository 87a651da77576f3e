#include "core/base/memory/large_arrays.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <new>
#include <vector>

#include "core/base/memory/resident_bytes.h"
#include "core/base/memory/scratch_space.h"

#if !defined(__has_feature)
#define __has_feature(name) 0
#endif
#if defined(__SANITIZE_ADDRESS__) || __has_feature(address_sanitizer)
#include <sanitizer/asan_interface.h>
#else
#define ASAN_POISON_MEMORY_REGION(at, bytes) static_cast<void>(0)
#define ASAN_UNPOISON_MEMORY_REGION(at, bytes) static_cast<void>(0)
#endif

namespace ldp {
namespace {

struct Array {
  void* at = nullptr;
  size_t bytes = 0;
};

// A kept array may be larger than what is asked for by one part in so many.
constexpr size_t kSpareParts = 4;

void free_array(const Array& array) {
  ASAN_UNPOISON_MEMORY_REGION(array.at, array.bytes);
  if (!unmap_scratch(array.at)) ::operator delete(array.at);
}

class Store {
 public:
  void* take(size_t bytes) {
    if (void* kept = take_kept(bytes)) return kept;
    void* fresh = map_scratch(bytes);
    if (fresh == nullptr) fresh = ::operator new(bytes, std::nothrow);
    if (fresh == nullptr) fresh = new_without_kept(bytes);
    try {
      const std::lock_guard lock(mutex_);
      lent_.emplace(fresh, bytes);
    } catch (...) {
      free_array({fresh, bytes});
      throw;
    }
    return fresh;
  }

  void give_back(void* at) noexcept {
    const std::lock_guard lock(mutex_);
    const auto found = lent_.find(at);
    const Array array{at, found->second};
    lent_.erase(found);
    if (!keep(array)) free_array(array);
  }

  void forget_kept() {
    const std::lock_guard lock(mutex_);
    shed(0);
  }

  void begin() {
    const std::lock_guard lock(mutex_);
    if (recyclers_++ == 0) most_resident_ = resident_bytes();
  }
  void end() {
    const std::lock_guard lock(mutex_);
    if (--recyclers_ == 0) shed(0);
  }
  size_t kept_bytes() {
    const std::lock_guard lock(mutex_);
    return kept_bytes_;
  }

 private:
  void* new_without_kept(size_t bytes) {
    forget_kept();
    return ::operator new(bytes);
  }

  // nullptr: none fits.
  void* take_kept(size_t bytes) {
    const std::lock_guard lock(mutex_);
    auto best = kept_.end();
    for (auto it = kept_.begin(); it != kept_.end(); ++it) {
      if (it->bytes < bytes || it->bytes > bytes + bytes / kSpareParts) continue;
      if (best == kept_.end() || it->bytes <= best->bytes) best = it;
    }
    if (best == kept_.end()) {
      make_room(bytes);
      return nullptr;
    }
    const Array array = *best;
    lent_.emplace(array.at, array.bytes);
    kept_.erase(best);
    kept_bytes_ -= array.bytes;
    ASAN_UNPOISON_MEMORY_REGION(array.at, bytes);
    return array.at;
  }

  bool keep(const Array& array) noexcept try {
    if (recyclers_ == 0 || array.bytes > RecycledArrays::kMostKept || !is_where_new_ones_are(array.at)) return false;
    kept_.push_back(array);
    kept_bytes_ += array.bytes;
    ASAN_POISON_MEMORY_REGION(array.at, array.bytes);
    shed(RecycledArrays::kMostKept);
    return true;
  } catch (const std::bad_alloc&) {
    return false;
  }

  // What is kept does not make the process larger than it was at its largest.
  void make_room(size_t bytes) {
    if (kept_.empty() && recyclers_ == 0) return;
    const size_t kept_before = kept_bytes_, wanted = resident_bytes() + bytes;
    if (wanted > most_resident_) shed(kept_bytes_ - std::min(kept_bytes_, wanted - most_resident_));
    most_resident_ = std::max(most_resident_, wanted - std::min(wanted, kept_before - kept_bytes_));
  }

  // The oldest first, until at most so many bytes are kept.
  void shed(size_t bytes) {
    auto it = kept_.begin();
    for (; it != kept_.end() && kept_bytes_ > bytes; ++it) {
      kept_bytes_ -= it->bytes;
      free_array(*it);
    }
    kept_.erase(kept_.begin(), it);
  }

  std::mutex mutex_;
  std::map<void*, size_t> lent_;  // their bytes
  std::vector<Array> kept_;       // the oldest first
  size_t kept_bytes_ = 0, most_resident_ = 0;
  int recyclers_ = 0;
};

// Never destroyed: planes that live as long as the process are given back after everything else.
Store& store() {
  static Store& one = *new Store;
  return one;
}

}  // namespace

RecycledArrays::RecycledArrays() { store().begin(); }
RecycledArrays::~RecycledArrays() { store().end(); }
size_t RecycledArrays::kept_bytes() { return store().kept_bytes(); }

void forget_kept_arrays() { store().forget_kept(); }

void* take_large_array(size_t bytes) { return store().take(bytes); }
void give_back_large_array(void* array) noexcept { store().give_back(array); }

}  // namespace ldp
