// A folder for what an archive or a film holds, gone with this object and when the program is cut off. What a program
// that was killed left is removed by the next one: while its program runs, a folder's file .lock is locked.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "drivers/interface/unique_fd.h"

namespace ldp {

class Temporary;

class UnpackedFolder {
 public:
  // A new one, hidden, in that folder or, where none can be made there, where the system keeps temporary files; empty =
  // there at once. of: what is unpacked, for errors. Throws BadInput, or MachineFault.
  UnpackedFolder(const std::filesystem::path& inside, const std::string& of);
  ~UnpackedFolder();
  UnpackedFolder(const UnpackedFolder&) = delete;
  UnpackedFolder& operator=(const UnpackedFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  void put(const std::string& name, std::span<const uint8_t> bytes) const;  // throws std::system_error

 private:
  std::filesystem::path path_;
  UniqueFd lock_;
  std::unique_ptr<Temporary> temporary_;
};

// Of this user, in that folder (empty as above), what programs left that are gone. A file system that knows no locks
// keeps everything.
void remove_abandoned_folders(const std::filesystem::path& inside);

}  // namespace ldp
