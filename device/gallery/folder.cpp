#include "device/gallery/folder.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <system_error>

#include "device/capture/sweep_name.h"

namespace ldp::gallery {
namespace {

constexpr std::string_view kPanorama = ".ldp";
constexpr const char* kRecord = "capture.json";
constexpr size_t kLongestName = 255;

[[noreturn]] void fail(const std::string& what) { throw std::system_error(errno, std::generic_category(), what); }

bool is_plain_part(std::string_view name) {
  const auto is_bad = [](char c) { return c == '/' || static_cast<unsigned char>(c) < 0x20 || c == 0x7F; };
  return !name.empty() && name.size() <= kLongestName && name.front() != '.' &&
         std::none_of(name.begin(), name.end(), is_bad);
}

bool are_digits(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

// What is there all the same, and may be opened another time.
bool is_a_fault(int error) { return error == EMFILE || error == ENFILE || error == ENOMEM || error == EIO; }

// Without waiting: what is no plain file may be a pipe. Throws std::system_error for a fault.
std::optional<OpenFile> open_plain(int folder, const std::string& name) {
  UniqueFd fd(::openat(folder, name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  struct stat state {};
  if (!fd.is_open() && is_a_fault(errno)) fail(name + " cannot be read");
  if (!fd.is_open() || ::fstat(fd.get(), &state) != 0 || !S_ISREG(state.st_mode)) return std::nullopt;
  const int64_t changed_ns = int64_t{state.st_mtim.tv_sec} * 1'000'000'000 + state.st_mtim.tv_nsec;
  return OpenFile{std::move(fd),
                  {static_cast<uint64_t>(state.st_size), static_cast<uint64_t>(state.st_ino), changed_ns}};
}

UniqueFd open_folder(int parent, const std::string& name) {
  UniqueFd fd(::openat(parent, name.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  if (!fd.is_open() && is_a_fault(errno)) fail(name + " cannot be read");
  return fd;
}

// Names of what is in it. The descriptor stays open and is read from its beginning.
std::vector<std::string> names_in(int folder) {
  UniqueFd again = open_folder(folder, ".");
  DIR* const opened = again.is_open() ? ::fdopendir(again.get()) : nullptr;
  if (opened == nullptr) fail("the gallery's folder cannot be listed");
  again.release();
  const std::unique_ptr<DIR, int (*)(DIR*)> stream(opened, ::closedir);
  std::vector<std::string> names;
  errno = 0;
  while (const dirent* const entry = ::readdir(stream.get())) names.emplace_back(entry->d_name);
  if (errno != 0) fail("the gallery's folder cannot be listed");
  std::erase_if(names, [](const std::string& name) { return name == "." || name == ".."; });
  return names;
}

bool is_folder(int parent, const std::string& name) {
  struct stat state {};
  return ::fstatat(parent, name.c_str(), &state, AT_SYMLINK_NOFOLLOW) == 0 && S_ISDIR(state.st_mode);
}

void remove(int folder, const std::string& name, int flags = 0) {
  if (::unlinkat(folder, name.c_str(), flags) != 0) fail(name + " cannot be removed");
}

// So that a power cut does not bring back what was said to be gone. Where a file system knows no such thing, that is
// as good as it gets.
void flush(int folder) {
  if (::fsync(folder) != 0 && errno == EIO) fail("the gallery's folder cannot be flushed");
}

[[noreturn]] void refuse_folder(std::string sweep, const std::string& inside) {
  throw std::runtime_error(sweep.append(" holds a folder, ").append(inside).append(": move it away"));
}

// The capture service's own folder of a sweep: flat, with its record, which goes last: while it is there, what a fault
// has left can be asked for again. Any other one that holds anything is somebody's work.
void remove_sweep(int parent, const std::string& name) {
  const UniqueFd sweep = open_folder(parent, name);
  if (!sweep.is_open()) return;
  const std::vector<std::string> names = names_in(sweep.get());
  if (!names.empty() && !open_plain(sweep.get(), kRecord)) return;
  for (const std::string& inside : names)
    if (is_folder(sweep.get(), inside)) refuse_folder(name, inside);
  for (const std::string& inside : names)
    if (inside != kRecord) remove(sweep.get(), inside);
  flush(sweep.get());
  if (!names.empty()) remove(sweep.get(), kRecord);
  remove(parent, name, AT_REMOVEDIR);
  flush(parent);
}

}  // namespace

std::string etag_of(const FileVersion& version) {
  char text[64];
  std::snprintf(text, sizeof text, "\"%llx-%llx-%llx\"", static_cast<unsigned long long>(version.inode),
                static_cast<unsigned long long>(version.bytes), static_cast<unsigned long long>(version.changed_ns));
  return text;
}

bool is_panorama_name(std::string_view name) {
  return is_plain_part(name) && name.size() > kPanorama.size() && name.ends_with(kPanorama);
}

bool is_sweep_name(std::string_view name) { return number_of_sweep(name).has_value(); }

bool is_frame_name(std::string_view name) {
  constexpr std::string_view kFrame = "frame_", kJpeg = ".jpg";
  if (!name.starts_with(kFrame) || !name.ends_with(kJpeg) || name.size() > 16) return false;
  return are_digits(name.substr(kFrame.size(), name.size() - kFrame.size() - kJpeg.size()));
}

Folder::Folder(const std::filesystem::path& folder) : fd_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (!fd_.is_open()) fail("cannot open the folder " + folder.string());
}

std::vector<std::string> Folder::panoramas() const {
  std::vector<std::string> names = names_in(fd_.get());
  std::erase_if(names, [](const std::string& name) { return !is_panorama_name(name); });
  return names;
}

std::optional<OpenFile> Folder::open_panorama(const std::string& name) const {
  if (!is_panorama_name(name)) return std::nullopt;
  return open_plain(fd_.get(), name);
}

std::optional<OpenFile> Folder::open_frame(const std::string& sweep, const std::string& frame) const {
  if (!is_sweep_name(sweep) || !is_frame_name(frame)) return std::nullopt;
  const UniqueFd inner = open_folder(fd_.get(), sweep);
  return inner.is_open() ? open_plain(inner.get(), frame) : std::nullopt;
}

bool Folder::remove_panorama(const std::string& name) const {
  if (!open_panorama(name)) return false;
  const std::string sweep = name.substr(0, name.size() - kPanorama.size());
  if (is_sweep_name(sweep)) remove_sweep(fd_.get(), sweep);  // first: what is left if it fails is still shown
  remove(fd_.get(), name);
  flush(fd_.get());
  return true;
}

}  // namespace ldp::gallery
