// A folder for what an archive or a film holds, gone with this object and when the program is cut off.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace ldp {

class Temporary;

class UnpackedFolder {
 public:
  // A new one, hidden, in that folder; empty = where the system keeps temporary files. Throws std::system_error.
  explicit UnpackedFolder(const std::filesystem::path& inside);
  ~UnpackedFolder();
  UnpackedFolder(const UnpackedFolder&) = delete;
  UnpackedFolder& operator=(const UnpackedFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  void put(const std::string& name, std::span<const uint8_t> bytes) const;  // throws std::system_error

 private:
  std::filesystem::path path_;
  std::unique_ptr<Temporary> temporary_;
};

}  // namespace ldp
