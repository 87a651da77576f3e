// Preloaded library: prints the peak of a program's heap, KiB, as it exits. An emulator's own memory is not in it.
#include <malloc.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);
extern void __libc_free(void*);

static atomic_size_t held, peak;

static void* took(void* block) {
  if (!block) return block;
  const size_t now = atomic_fetch_add(&held, malloc_usable_size(block)) + malloc_usable_size(block);
  size_t seen = atomic_load(&peak);
  while (now > seen && !atomic_compare_exchange_weak(&peak, &seen, now)) {
  }
  return block;
}
static void gave(void* block) {
  if (block) atomic_fetch_sub(&held, malloc_usable_size(block));
}

void* malloc(size_t size) { return took(__libc_malloc(size)); }
void* calloc(size_t count, size_t size) { return took(__libc_calloc(count, size)); }
void* memalign(size_t alignment, size_t size) { return took(__libc_memalign(alignment, size)); }
void* aligned_alloc(size_t alignment, size_t size) { return memalign(alignment, size); }
int posix_memalign(void** block, size_t alignment, size_t size) {
  *block = memalign(alignment, size);
  return *block ? 0 : 12;
}
void* realloc(void* block, size_t size) {
  gave(block);
  return took(__libc_realloc(block, size));
}
void free(void* block) {
  gave(block);
  __libc_free(block);
}

__attribute__((destructor)) static void print(void) {
  fprintf(stderr, "heap peak %zu KiB\n", atomic_load(&peak) / 1024);
}
