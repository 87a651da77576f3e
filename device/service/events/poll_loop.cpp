#include "device/service/events/poll_loop.h"

#include <poll.h>

#include <algorithm>
#include <cerrno>

#include "drivers/interface/clocks.h"
#include "drivers/interface/errors.h"

namespace ldp {

void wait_and_serve(const std::function<Watches()>& watches, int64_t deadline_ns) {
  const Watches watched = watches();
  std::vector<pollfd> entries;
  for (const Watch& watch : watched) entries.push_back({watch.fd, POLLIN, 0});
  const int64_t wait_ns = std::max<int64_t>(deadline_ns - monotonic_now_ns(), 0);
  const int timeout_ms = static_cast<int>(std::min<int64_t>(wait_ns / 1'000'000 + 1, 60'000));
  const int ready = ::poll(entries.data(), entries.size(), wait_ns == 0 ? 0 : timeout_ms);
  if (ready < 0 && errno != EINTR) throw_errno("cannot wait for events");
  const auto unchanged = [&] { return std::ranges::equal(watches(), watched, {}, &Watch::fd, &Watch::fd); };
  for (size_t i = 0; ready > 0 && i < entries.size(); ++i) {
    if (entries[i].revents == 0) continue;
    watched[i].serve();
    if (!unchanged()) break;
  }
}

}  // namespace ldp
