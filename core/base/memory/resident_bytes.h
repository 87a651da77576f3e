// What the process holds of the machine's memory.
#pragma once

#include <cstddef>

namespace ldp {

// In bytes, now; 0 where the system does not tell.
struct Resident {
  size_t all = 0;
  size_t of_files = 0;  // mapped from files, and unchanged or shared: of programs, libraries, the scratch space
};
Resident resident();

inline size_t resident_bytes() { return resident().all; }

}  // namespace ldp
