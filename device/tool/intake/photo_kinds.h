// What a file is, among those that a sweep may come in, or that may be taken for one.
#pragma once

#include <cstdint>
#include <filesystem>

namespace ldp {

enum class FileKind : uint8_t { photo, heif, raw, zip, panorama, other };

// By its first bytes. Throws BadInput when there is no such file or it cannot be read.
FileKind kind_of_content(const std::filesystem::path& file);

// By its ending: photo, heif, raw or other.
FileKind kind_of_name(const std::filesystem::path& file);

}  // namespace ldp
