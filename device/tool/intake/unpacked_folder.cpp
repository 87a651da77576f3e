#include "device/tool/intake/unpacked_folder.h"

#include <stdlib.h>

#include <cerrno>
#include <fstream>
#include <system_error>

#include "device/tool/process/interrupt.h"

namespace ldp {

namespace fs = std::filesystem;

UnpackedFolder::UnpackedFolder(const fs::path& inside) {
  const fs::path folder = inside.empty() ? fs::temp_directory_path() : inside;
  std::string name = (folder / ".ldp-unpacked-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr)
    throw std::system_error(errno, std::generic_category(), folder.string() + ": making a folder in it");
  path_ = name;
  temporary_ = std::make_unique<Temporary>(path_);
}

UnpackedFolder::~UnpackedFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

void UnpackedFolder::put(const std::string& name, std::span<const uint8_t> bytes) const {
  const fs::path file = path_ / name;
  errno = 0;
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw std::system_error(errno, std::generic_category(), file.string() + ": cannot be written");
}

}  // namespace ldp
