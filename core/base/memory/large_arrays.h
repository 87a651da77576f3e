// Arrays of 256 KiB or more, of which planes are made: where they come from, and that freed ones are used again.
//
// The kernel clears fresh pages one by one when they are first touched, and takes them back when they are freed: up to
// a sixth of a build's time, whose planes come and go with every photo and strip. While a RecycledArrays exists, freed
// arrays are therefore kept for those to come: at most kMostKept bytes, and none once the process would grow beyond
// what it was at its largest, as far as is known when a large array is asked for. Values do not depend on it. This,
// with the scratch space, is the state of the process that core has: allocation knows no caller.
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>

namespace ldp {

inline constexpr size_t kLargeArray_bytes = 1 << 18;

class RecycledArrays {
 public:
  RecycledArrays();
  ~RecycledArrays();  // the last one in the process lets go of what is kept
  RecycledArrays(const RecycledArrays&) = delete;
  RecycledArrays& operator=(const RecycledArrays&) = delete;

  static constexpr size_t kMostKept = 32 << 20;
  static size_t kept_bytes();
};

// Where arrays come from is about to be another place.
void forget_kept_arrays();

// Of a scratch space where there is one (scratch_space.h), otherwise of the heap; throws std::bad_alloc.
void* take_large_array(size_t bytes);
void give_back_large_array(void* array) noexcept;

template <typename T>
struct LargeArrays {
  using value_type = T;
  using is_always_equal = std::true_type;

  LargeArrays() = default;
  template <typename U>
  LargeArrays(const LargeArrays<U>&) noexcept {}  // as std::allocator converts

  T* allocate(size_t count) {
    static_assert(alignof(T) <= __STDCPP_DEFAULT_NEW_ALIGNMENT__);
    if (is_large(count)) return static_cast<T*>(take_large_array(count * sizeof(T)));
    return std::allocator<T>().allocate(count);
  }
  void deallocate(T* array, size_t count) noexcept {
    if (is_large(count)) return give_back_large_array(array);
    std::allocator<T>().deallocate(array, count);
  }
  friend bool operator==(const LargeArrays&, const LargeArrays&) { return true; }

 private:
  static constexpr size_t kMostCount = static_cast<size_t>(-1) / 2 / sizeof(T);
  static bool is_large(size_t count) { return count >= kLargeArray_bytes / sizeof(T) && count <= kMostCount; }
};

}  // namespace ldp
