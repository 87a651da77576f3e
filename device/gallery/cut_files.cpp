#include "device/gallery/cut_files.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdint>
#include <system_error>

namespace ldp::gallery {
namespace {

// Asked for beforehand: not every call is allowed in the handler of a signal. mmap is a plain system call.
uintptr_t page_bytes = 0;

// A page of zeros in place of the one that the file no longer has; the instruction is then begun again.
void replace_page(int signal, siginfo_t* info, void*) {
  const int kept = errno;
  const uintptr_t address = reinterpret_cast<uintptr_t>(info->si_addr);
  void* const page = reinterpret_cast<void*>(address - address % page_bytes);  // NOLINT(performance-no-int-to-ptr)
  const bool is_beyond_a_file = info->si_code == BUS_ADRERR;
  const int flags = MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED;
  if (!is_beyond_a_file || ::mmap(page, page_bytes, PROT_READ, flags, -1, 0) == MAP_FAILED)
    ::signal(signal, SIG_DFL);  // begun again, it ends the program
  errno = kept;
}

}  // namespace

void read_cut_files_as_zeros() {
  page_bytes = static_cast<uintptr_t>(::sysconf(_SC_PAGESIZE));
  struct sigaction action {};
  action.sa_sigaction = replace_page;
  action.sa_flags = SA_SIGINFO;
  if (::sigaction(SIGBUS, &action, nullptr) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot handle SIGBUS");
}

}  // namespace ldp::gallery
