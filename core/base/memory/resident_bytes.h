// What the process holds of the machine's memory.
#pragma once

#include <cstddef>

namespace ldp {

// Bytes of the process that are in memory now; 0 where the system does not tell.
size_t resident_bytes();

}  // namespace ldp
