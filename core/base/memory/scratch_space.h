// Room on disk for large arrays, for jobs that are larger than the memory they may take.
//
// While a ScratchSpace exists, large arrays (large_arrays.h: the samples of planes) are mapped from files without names
// in its folder. Whenever the process holds more than its budget, all of them are let go from resident memory (at most
// every 4 ms where most of the budget is no array); what is touched again comes back from the page cache, or from
// disk where the kernel needed the room. Values are the same with and without. Where the disk is nearly full, or cannot
// promise room, arrays live in memory as ever.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

namespace ldp {

// One at a time in a process.
class ScratchSpace {
 public:
  // Throws std::runtime_error where no file can be made in the folder or files there are memory themselves,
  // std::logic_error for a second one. Arrays that outlive it stay readable, and are no longer let go.
  ScratchSpace(const std::string& folder, size_t resident_bytes);
  ~ScratchSpace();
  ScratchSpace(const ScratchSpace&) = delete;
  ScratchSpace& operator=(const ScratchSpace&) = delete;

  size_t bytes() const;  // of the arrays that live in it now

 private:
  struct Keeper;
  std::unique_ptr<Keeper> keeper_;
};

// What ScratchSpace does every few milliseconds, at once: where much is touched in less, and letting go wins enough.
void let_go_if_full();

// nullptr where there is no scratch space, or no room in it.
void* map_scratch(size_t bytes);
// Whether the array was mapped, and is gone now.
bool unmap_scratch(void* array) noexcept;
// Mapped where there is a scratch space, in memory where there is none.
bool is_where_new_ones_are(void* array) noexcept;

}  // namespace ldp
