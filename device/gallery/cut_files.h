// Files of the gallery's folder may be cut short or written over while they are mapped (core/base/files.h): what is
// gone then reads as zeros, which no checksum takes for a panorama, instead of ending the program by SIGBUS.
#pragma once

namespace ldp::gallery {

// From now on, for the whole process. Throws std::system_error.
void read_cut_files_as_zeros();

}  // namespace ldp::gallery
