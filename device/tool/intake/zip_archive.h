// The photos of a .zip archive, through libarchive where the program was built with it.
//
// Photos must lie in one folder of the archive, and keep their names but no folder's: nothing can be written outside
// the folder given. Hidden files, links, and whatever is no photo are passed over; a capture.json beside the photos, or
// in the folder above, comes along. Sizes are counted while unpacking, whatever the archive says of them.
#pragma once

#include <filesystem>

#include "core/base/job.h"
#include "device/tool/intake/unpacked_folder.h"

namespace ldp {

// Throws BadInput naming the archive: damaged, encrypted, without photos, photos of two folders, names that lead out
// of it, or more than intake_tuning.h allows.
void unpack_photos(const std::filesystem::path& archive, const UnpackedFolder& to, const Job& job);

}  // namespace ldp
