#include "core/base/memory/scratch_space.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <sys/mman.h>
#include <sys/statvfs.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <map>
#include <mutex>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "core/base/memory/large_arrays.h"
#include "core/base/memory/resident_bytes.h"

namespace ldp {
namespace {

constexpr uint64_t kStaysFree = 64 << 20;      // bytes of the disk
constexpr std::chrono::milliseconds kLook{4};  // between two looks at what the process holds
constexpr double kMostly = 0.75;               // of the budget: where so much is no arrays, letting go wins little

std::mutex& mutex() {
  static std::mutex one;
  return one;
}

// Under the mutex: the arrays that are mapped, the folder for new ones, empty where there is no scratch space, the
// bytes that the process may hold, and those of files that it held before there were such arrays.
std::map<void*, size_t>& arrays() {
  static std::map<void*, size_t> all;
  return all;
}
std::string& folder() {
  static std::string one;
  return one;
}
size_t& budget() {
  static size_t bytes = 0;
  return bytes;
}
size_t& of_other_files() {
  static size_t bytes = 0;
  return bytes;
}

class File {
 public:
  // Without a name from the beginning, or nearly so where the file system cannot: nothing stays when the process dies.
  explicit File(const std::string& in) : descriptor_(::open(in.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600)) {
    if (descriptor_ >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != ENOENT)) return;
    std::string name = in + "/.scratch-XXXXXX";
    descriptor_ = ::mkostemp(name.data(), O_CLOEXEC);
    if (descriptor_ >= 0) ::unlink(name.c_str());
  }
  ~File() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

bool is_memory(const std::string& folder) {
  struct statfs system;
  if (::statfs(folder.c_str(), &system) != 0) return false;
  const auto type = static_cast<uint32_t>(system.f_type);
  return type == TMPFS_MAGIC || type == RAMFS_MAGIC;
}

// At once: on a disk that fills up later a write to a mapping would kill the process. Some of the disk stays free for
// what is written meanwhile.
bool take_room(int file, size_t bytes) {
  struct statvfs disk;
  if (::fstatvfs(file, &disk) != 0) return false;
  const uint64_t free = uint64_t{disk.f_bavail} * disk.f_frsize;
  return free >= bytes + kStaysFree && ::fallocate(file, 0, 0, static_cast<off_t>(bytes)) == 0;
}

using Clock = std::chrono::steady_clock;

Clock::time_point& next_look() {
  static Clock::time_point time;
  return time;
}

// Under the mutex. Where little of what is held is arrays, not again and again: they would come and go without end.
// That is told from what is no array, not from what is left: another thread may touch arrays meanwhile.
void let_go_where_full() {
  if (Clock::now() < next_look()) return;
  const Resident held = resident();
  if (held.all <= budget()) return;
  for (const auto& [array, bytes] : arrays()) ::madvise(array, bytes, MADV_DONTNEED);
  const size_t no_array = held.all - held.of_files + of_other_files();
  if (static_cast<double>(no_array) > kMostly * static_cast<double>(budget())) next_look() = Clock::now() + kLook;
}

}  // namespace

// Looks at what the process holds, and lets go.
struct ScratchSpace::Keeper {
  std::mutex waiting;
  std::condition_variable woken;
  bool over = false;
  std::thread thread;

  Keeper() {
    try {
      thread = std::thread([this] { run(); });
    } catch (const std::system_error&) {
      // No room for one more thread: parallel_for looks between its items.
    }
  }
  ~Keeper() {
    {
      const std::lock_guard lock(waiting);
      over = true;
    }
    woken.notify_one();
    if (thread.joinable()) thread.join();
  }

  void run() {
    std::unique_lock lock(waiting);
    while (!woken.wait_for(lock, kLook, [this] { return over; })) {
      const std::lock_guard holding(mutex());
      let_go_where_full();
    }
  }
};

void let_go_if_full() {
  const std::lock_guard lock(mutex());
  if (!folder().empty()) let_go_where_full();
}

ScratchSpace::ScratchSpace(const std::string& in, size_t resident_bytes) {
  if (File(in).descriptor() < 0)
    throw std::runtime_error(in + ": cannot make a file for scratch space: " + std::strerror(errno));
  if (is_memory(in)) throw std::runtime_error(in + ": no scratch space, files there are in memory too");
  auto keeper = std::make_unique<Keeper>();
  {
    const std::lock_guard lock(mutex());
    if (!folder().empty()) throw std::logic_error("there is a scratch space already");
    folder() = in;
    budget() = resident_bytes;
    if (arrays().empty()) of_other_files() = resident().of_files;
    keeper_ = std::move(keeper);
  }
  forget_kept_arrays();
}

ScratchSpace::~ScratchSpace() {
  keeper_.reset();
  {
    const std::lock_guard lock(mutex());
    folder().clear();
  }
  forget_kept_arrays();
}

size_t ScratchSpace::bytes() const {
  const std::lock_guard lock(mutex());
  size_t sum = 0;
  for (const auto& [array, bytes] : arrays()) sum += bytes;
  return sum;
}

void* map_scratch(size_t bytes) {
  std::string in;
  {
    const std::lock_guard lock(mutex());
    if (folder().empty()) return nullptr;
    let_go_where_full();
    in = folder();
  }
  const File file(in);
  if (file.descriptor() < 0 || !take_room(file.descriptor(), bytes)) return nullptr;
  void* array = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file.descriptor(), 0);
  if (array == MAP_FAILED) return nullptr;
  const std::lock_guard lock(mutex());
  arrays().emplace(array, bytes);
  return array;
}

bool is_where_new_ones_are(void* array) noexcept {
  const std::lock_guard lock(mutex());
  return arrays().contains(array) != folder().empty();
}

bool unmap_scratch(void* array) noexcept {
  const std::lock_guard lock(mutex());
  const auto found = arrays().find(array);
  if (found == arrays().end()) return false;
  ::munmap(array, found->second);
  arrays().erase(found);
  return true;
}

}  // namespace ldp
