#include "core/base/files.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <random>
#include <string>
#include <system_error>

namespace ldp {
namespace {

namespace fs = std::filesystem;

constexpr mode_t kAsUmaskSays = 0666, kOwnerAlone = 0600, kModes = 0777;

[[noreturn]] void fail(const std::string& attempted, const fs::path& file) {
  throw std::system_error(errno, std::generic_category(), attempted + " " + file.string());
}

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() { reset(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }
  bool valid() const { return fd_ >= 0; }
  int reset() {
    const int fd = fd_;
    fd_ = -1;
    return fd >= 0 ? ::close(fd) : 0;
  }

 private:
  int fd_;
};

size_t size_of(const Descriptor& descriptor, const fs::path& file) {
  struct stat status {};
  if (::fstat(descriptor.get(), &status) != 0) fail("cannot read", file);
  if (S_ISDIR(status.st_mode)) {
    errno = EISDIR;
    fail("cannot read", file);
  }
  return static_cast<size_t>(status.st_size);
}

// Signals may cut these short on network shares and FUSE.
int open_file(const fs::path& file, int flags, mode_t mode = 0) {
  int fd = -1;
  do {
    fd = ::open(file.c_str(), flags | O_CLOEXEC, mode);
  } while (fd < 0 && errno == EINTR);
  return fd;
}

int flush(const Descriptor& descriptor) {
  int result = 0;
  do {
    result = ::fsync(descriptor.get());
  } while (result != 0 && errno == EINTR);
  return result;
}

void write_all(const Descriptor& descriptor, std::span<const uint8_t> bytes, const fs::path& file) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor.get(), bytes.data(), std::min<size_t>(bytes.size(), 1 << 30));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("cannot write", file);
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
}

fs::path folder_of(const fs::path& file) { return file.has_parent_path() ? file.parent_path() : fs::path("."); }

// Who may do what with it. Where a file system knows no owners or modes, there are none to keep; and only root gives
// files away.
void keep_access(const Descriptor& of_new, const fs::path& replaced) {
  struct stat status {};
  if (::stat(replaced.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return;
  [[maybe_unused]] int kept = ::fchown(of_new.get(), status.st_uid, status.st_gid);
  kept = ::fchmod(of_new.get(), status.st_mode & kModes);
}

std::span<const uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

}  // namespace

bool flush_folder(const fs::path& folder) {
  const Descriptor descriptor(open_file(folder, O_RDONLY | O_DIRECTORY));
  if (!descriptor.valid() && errno == EACCES) return false;  // one that may be written to and not be listed
  if (!descriptor.valid()) fail("cannot open the folder", folder);
  if (flush(descriptor) == 0) return true;
  if (errno != EINVAL && errno != ENOTSUP && errno != ENOSYS) fail("cannot flush the folder", folder);
  return false;
}

std::vector<uint8_t> read_file(const fs::path& file) {
  const Descriptor descriptor(open_file(file, O_RDONLY));
  if (!descriptor.valid()) fail("cannot read", file);
  std::vector<uint8_t> bytes(size_of(descriptor, file) + 1);
  size_t filled = 0;
  for (;;) {  // to the end, whatever the size said: pipes and files of /proc say 0
    if (filled == bytes.size()) bytes.resize(filled + filled / 2 + 4096);
    const ssize_t got = ::read(descriptor.get(), bytes.data() + filled, bytes.size() - filled);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail("cannot read", file);
    if (got == 0) break;
    filled += static_cast<size_t>(got);
  }
  bytes.resize(filled);
  return bytes;
}

void write_file(const fs::path& file, std::span<const uint8_t> bytes) {
  std::error_code ignored;
  const fs::file_status status = fs::status(file, ignored);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    const Descriptor descriptor(open_file(file, O_WRONLY));
    if (!descriptor.valid()) fail("cannot write", file);
    return write_all(descriptor, bytes, file);
  }
  PartialFile partial(file);
  partial.write(bytes);
  partial.finish();
}

void write_file(const fs::path& file, std::string_view text) { write_file(file, bytes_of(text)); }

void write_secret_file(const fs::path& file, std::string_view text) {
  PartialFile partial(file);
  partial.write(bytes_of(text), true);
  partial.finish();
}

void move_file(const fs::path& from, const fs::path& to) {
  const Descriptor descriptor(open_file(from, O_RDONLY));
  if (!descriptor.valid()) fail("cannot read", from);
  keep_access(descriptor, to);
  if (flush(descriptor) != 0) fail("cannot flush", from);
  if (::rename(from.c_str(), to.c_str()) != 0) fail("cannot write", to);
  flush_folder(folder_of(to));
}

fs::path name_beside(const fs::path& target, std::string_view mark, std::string_view ending) {
  std::random_device random;
  const uint64_t number = uint64_t{random()} << 32 | random();
  std::string name = ".";
  name.append(target.filename().string()).append(mark).append(std::to_string(number)).append(ending);
  return target.parent_path() / name;
}

PartialFile::PartialFile(const fs::path& target) {
  std::error_code error;
  target_ = fs::exists(target, error) ? fs::canonical(target) : target;
  path_ = name_beside(target_, ".", ".tmp");
}

PartialFile::~PartialFile() {
  if (begun_) ::unlink(path_.c_str());
}

void PartialFile::write(std::span<const uint8_t> bytes, bool secret) {
  std::error_code error;
  const bool is_for_few = secret || fs::exists(target_, error);  // until it is for those that the old one is for
  const Descriptor descriptor(open_file(path_, O_WRONLY | O_CREAT | O_EXCL, is_for_few ? kOwnerAlone : kAsUmaskSays));
  if (!descriptor.valid()) fail("cannot write", target_);
  begun_ = true;
  if (!secret) keep_access(descriptor, target_);
  write_all(descriptor, bytes, target_);
  if (flush(descriptor) != 0) fail("cannot write", target_);
}

void PartialFile::finish() {
  if (::rename(path_.c_str(), target_.c_str()) != 0) fail("cannot write", target_);
  begun_ = false;
  flush_folder(folder_of(target_));
}

MappedFile::MappedFile(const fs::path& file) {
  const Descriptor descriptor(open_file(file, O_RDONLY));
  if (!descriptor.valid()) fail("cannot read", file);
  size_ = size_of(descriptor, file);
  if (size_ == 0) return;  // an empty mapping is an error to mmap, an empty file is not one to us
  void* mapping = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, descriptor.get(), 0);
  if (mapping == MAP_FAILED) fail("cannot read", file);
  data_ = static_cast<const uint8_t*>(mapping);
}

MappedFile::~MappedFile() {
  if (data_) ::munmap(const_cast<uint8_t*>(data_), size_);
}

}  // namespace ldp
