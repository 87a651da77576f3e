// A folder in memory for readers that take files: one for the process, gone with it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace ldp {

class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = "/dev/shm/ldp-fuzz.XXXXXX";
    if (mkdtemp(name.data()) == nullptr) std::abort();
    folder_ = name;
  }
  ~ScratchFolder() { std::filesystem::remove_all(folder_); }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return folder_; }
  std::filesystem::path store(const std::string& name, const uint8_t* data, size_t size) const {
    std::ofstream(folder_ / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
    return folder_ / name;
  }

 private:
  std::filesystem::path folder_;
};

}  // namespace ldp
