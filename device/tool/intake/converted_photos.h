// HEIC and raw photos as JPEG files, by programs that read them where they are installed: heif-convert of libheif, and
// simple_dcraw of LibRaw, which takes out the preview that a camera puts beside its raw samples.
#pragma once

#include <vector>

#include "core/base/job.h"
#include "core/captures/folder_frames.h"
#include "device/tool/intake/unpacked_folder.h"

namespace ldp {

// The same photos in the same order, those of these kinds (photo_kinds.h, by name) replaced by JPEG files of the same
// names but for the ending, and called as they were. Throws BadInput naming a photo: of which two have one name, which
// could not be read, or which needs a program that is not there.
std::vector<PhotoFile> converted_photos(const std::vector<PhotoFile>& photos, const UnpackedFolder& to, const Job& job);

}  // namespace ldp
