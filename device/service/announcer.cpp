#include "device/service/announcer.h"

#include <exception>
#include <optional>
#include <utility>

#include "device/backends/open.h"
#include "device/capture/log.h"

namespace ldp {

Announcer::Announcer(const std::vector<std::string>& urls) {
  for (const std::string& url : urls) pending_.push_back({url, {}});
  open_missing();
}

// A network may come up late, an LED may go.
void Announcer::open_missing() {
  for (const OpenChannel& open : open_) {
    if (open.failed) pending_.push_back({open.url, {}});
  }
  std::erase_if(open_, [](const OpenChannel& open) { return open.failed; });
  std::vector<PendingChannel> still_pending;
  for (const PendingChannel& pending : pending_) {
    try {
      open_.push_back({pending.url, open_status(pending.url)});
    } catch (const std::exception& error) {
      if (pending.problem != error.what()) log_warning(error.what());
      still_pending.push_back({pending.url, error.what()});
    }
  }
  pending_ = std::move(still_pending);
}

void Announcer::publish(const StatusMessage& message) {
  for (OpenChannel& open : open_) {
    if (!open.failed) attempt(open, [&](StatusChannel& channel) { channel.publish(message); });
  }
}

// A channel that fails is closed when missing ones are opened: this may be called from its own commands.
void Announcer::attempt(OpenChannel& open, const std::function<void(StatusChannel&)>& what) {
  try {
    what(*open.channel);
  } catch (const std::exception& error) {
    open.failed = true;
    log_warning(open.url + ": " + error.what());
  }
}

Watches Announcer::watches(const std::function<void(Command)>& obey) {
  Watches watched;
  for (size_t i = 0; i < open_.size(); ++i) {
    const int fd = open_[i].failed ? -1 : open_[i].channel->fd();
    if (fd >= 0) watched.push_back({fd, [this, i, obey] { serve(open_[i], obey); }});
  }
  return watched;
}

void Announcer::serve(OpenChannel& open, const std::function<void(Command)>& obey) {
  std::optional<Command> command;
  do {
    command.reset();
    attempt(open, [&](StatusChannel& channel) { command = channel.read(); });
    if (command) obey(*command);
  } while (command);
}

void Announcer::tell_ignored(bool at_end) {
  int64_t ignored = 0;
  for (const OpenChannel& open : open_) ignored += open.channel->ignored();
  if (ignored == ignored_told_ || (!at_end && ignored < 10 * ignored_told_)) return;
  ignored_told_ = ignored;
  log_warning("malformed messages ignored so far: " + std::to_string(ignored));
}

}  // namespace ldp
