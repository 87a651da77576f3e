#include "device/service/events/last_frames.h"

#include <poll.h>

#include <string>

#include "device/capture/log.h"
#include "device/service/reasons.h"
#include "device/service/session_tuning.h"
#include "drivers/interface/clocks.h"

namespace ldp {

void wait_for_last_frames(const LastFrames& last) {
  int64_t patience_end_ns = monotonic_now_ns() + kDiskPatience_s * kSecond_ns;
  for (size_t waiting = last.writer.pending(); waiting > 0; waiting = last.writer.pending()) {
    last.notice.still_stopping(kDiskPatience_s + 2);
    pollfd entries[] = {{last.writer.fd(), POLLIN, 0}, {last.end_request.fd(), POLLIN, 0}};
    ::poll(entries, 2, 1000);
    const int64_t now_ns = monotonic_now_ns();
    last.notice.feed_watchdog(now_ns);
    if (entries[0].revents != 0) last.serve_writer();
    if (last.writer.pending() < waiting) patience_end_ns = now_ns + kDiskPatience_s * kSecond_ns;
    const bool hangs = now_ns >= patience_end_ns;
    const bool again = entries[1].revents != 0 && last.end_request.take() && last.leaves_when_asked_again;
    if (!hangs && !again) continue;
    log_warning(std::string(hangs ? "the disk does not answer" : "left at once") +
                ": not stored in order: " + frames_text(static_cast<int>(last.writer.pending())));
    return last.writer.leave();
  }
}

}  // namespace ldp
