#include "device/tool/intake/unpacked_folder.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string_view>
#include <system_error>
#include <vector>

#include "device/tool/process/interrupt.h"
#include "device/tool/session.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPrefix = ".ldp-unpacked-";
constexpr const char* kLock = ".lock";

fs::path temporary_files() {
  std::error_code error;
  const fs::path folder = fs::temp_directory_path(error);
  return error ? fs::path("/tmp") : folder;
}

// As far as it can be read.
std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> all;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error); !error && entry != fs::directory_iterator(); entry.increment(error))
    all.push_back(entry->path());
  return all;
}

// The lock last: of a removal that is cut short the rest can still be told as abandoned.
void remove_folder(const fs::path& folder) {
  std::error_code ignored;
  for (const fs::path& entry : entries_of(folder))
    if (entry.filename() != kLock) fs::remove_all(entry, ignored);
  fs::remove(folder / kLock, ignored);
  fs::remove(folder, ignored);
}

void remove_if_abandoned(const fs::path& folder) {
  struct stat status {};
  if (::lstat(folder.c_str(), &status) != 0 || !S_ISDIR(status.st_mode) || status.st_uid != ::geteuid()) return;
  const UniqueFd lock(::open((folder / kLock).c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW));
  if (!lock.is_open())
    ::rmdir(folder.c_str());  // without a lock as yet it is empty: whoever is making it makes another
  else if (::flock(lock.get(), LOCK_EX | LOCK_NB) == 0)
    remove_folder(folder);
}

enum class Locking : uint8_t { done, taken, failed };  // taken: for one that was left; failed: errno says why

Locking lock_new(const fs::path& folder, UniqueFd& lock) {
  const fs::path file = folder / kLock;
  lock = UniqueFd(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
  if (!lock.is_open()) return errno == ENOENT ? Locking::taken : Locking::failed;
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return Locking::taken;
  return ::access(file.c_str(), F_OK) == 0 ? Locking::done : Locking::taken;
}

// Empty where none can be made: errno says why.
fs::path new_folder(const fs::path& inside, UniqueFd& lock) {
  for (;;) {
    std::string name = (inside / (std::string(kPrefix) + "XXXXXX")).string();
    if (::mkdtemp(name.data()) == nullptr) return {};
    const Locking locking = lock_new(name, lock);
    if (locking == Locking::done) return name;
    const int why = errno;
    if (locking == Locking::failed) ::rmdir(name.c_str());
    errno = why;
    if (locking == Locking::failed) return {};
  }
}

}  // namespace

UnpackedFolder::UnpackedFolder(const fs::path& inside, const std::string& of) {
  std::string refusals;
  int why = 0;
  std::vector<fs::path> places = {temporary_files()};
  if (!inside.empty()) places.insert(places.begin(), inside);
  for (const fs::path& place : places) {
    path_ = new_folder(place, lock_);
    if (!path_.empty()) break;
    why = errno;
    refusals += (refusals.empty() ? "" : " nor in ") + place.string() + " (" + std::strerror(why) + ")";
  }
  if (path_.empty()) {
    const std::string text = of + ": cannot be unpacked, no folder can be made in " + refusals +
                             ": set TMPDIR to a folder with room that you may write to";
    if (is_machine_fault({why, std::generic_category()})) throw MachineFault(text);
    throw BadInput(text);
  }
  temporary_ = std::make_unique<Temporary>(path_);
}

UnpackedFolder::~UnpackedFolder() { remove_folder(path_); }

void UnpackedFolder::put(const std::string& name, std::span<const uint8_t> bytes) const {
  errno = 0;
  std::ofstream out(path_ / name, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out)
    throw std::system_error(errno, std::generic_category(),
                            path_.parent_path().string() + ": " + name + " cannot be unpacked into it");
}

void remove_abandoned_folders(const fs::path& inside) {
  for (const fs::path& entry : entries_of(inside.empty() ? temporary_files() : inside))
    if (entry.filename().string().starts_with(kPrefix)) remove_if_abandoned(entry);
}

}  // namespace ldp
