// The folder that a gallery shows, and the only way to what is in it: names are looked up from the folder's own
// descriptor, one part at a time. Whatever stands in a request, nothing outside the folder, no link and nothing but a
// plain file is ever opened.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/interface/unique_fd.h"

namespace ldp::gallery {

// Changes with every replacement of a file.
struct FileVersion {
  uint64_t bytes = 0, inode = 0;
  int64_t changed_ns = 0;  // UTC
  friend bool operator==(const FileVersion&, const FileVersion&) = default;
};

// For ETag headers, with its quotes.
std::string etag_of(const FileVersion& version);

struct OpenFile {
  UniqueFd fd;
  FileVersion version;
};

// "room.ldp": one part of a path, not hidden, without control characters.
bool is_panorama_name(std::string_view name);
bool is_sweep_name(std::string_view name);  // "sweep_000012", as the capture service numbers them
bool is_frame_name(std::string_view name);  // "frame_000.jpg"

class Folder {
 public:
  explicit Folder(const std::filesystem::path& folder);  // throws std::system_error if it cannot be read

  // Of plain files, in no order. Throws std::system_error.
  std::vector<std::string> panoramas() const;

  // None: there is no such plain file, or the name is none. Throws std::system_error where the system has no room to
  // open it, or cannot read its disk.
  std::optional<OpenFile> open_panorama(const std::string& name) const;
  std::optional<OpenFile> open_frame(const std::string& sweep, const std::string& frame) const;

  // A panorama and, where it is one of the capture service's, its sweep: otherwise the service would build it again.
  // False if there is none. Throws std::runtime_error, all of it still shown, if it cannot be removed or the sweep
  // holds a folder, which nothing of the service's is.
  bool remove_panorama(const std::string& name) const;

 private:
  UniqueFd fd_;
};

}  // namespace ldp::gallery
