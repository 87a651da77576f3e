// Status messages over LCM (UDP multicast, memq, log files), both ends of them.
//
// Messages are decoded here and not by LCM's own typed subscriptions: those print on stderr and say nothing to us about
// what is malformed. The generated decoders are safe on any bytes as long as exceptions are caught: a string length
// under one makes std::string::assign throw, longer than the datagram is refused.
#include <cmath>
#include <deque>
#include <lcm/lcm-cpp.hpp>
#include <limits>
#include <mutex>

#include "backends.h"
#include "clocks.h"
#include "ldp_lcm/command_t.hpp"
#include "ldp_lcm/guidance_t.hpp"
#include "ldp_lcm/progress_t.hpp"
#include "ldp_lcm/result_t.hpp"
#include "ldp_lcm/status_t.hpp"

namespace ldp {
namespace {

constexpr int32_t kVersion = 1;
constexpr size_t kMaxTextBytes = 1000;
constexpr const char* kStatusChannel = "LDP_STATUS";
constexpr const char* kProgressChannel = "LDP_PROGRESS";
constexpr const char* kGuidanceChannel = "LDP_GUIDANCE";
constexpr const char* kResultChannel = "LDP_RESULT";
constexpr const char* kCommandChannel = "LDP_COMMAND";

// A NUL would end the text in LCM's encoding but not in its length.
std::string wire_text(const std::string& text) { return text.substr(0, std::min(text.find('\0'), kMaxTextBytes)); }

template <typename Wire>
Wire stamped() {
  Wire wire{};
  wire.version = kVersion;
  wire.utc_ns = utc_now_ns();
  wire.monotonic_ns = monotonic_now_ns();
  return wire;
}

ldp_lcm::status_t wire_from(const Status& status) {
  auto wire = stamped<ldp_lcm::status_t>();
  wire.phase = static_cast<int8_t>(status.phase);
  wire.capture = wire_text(status.capture);
  wire.text = wire_text(status.text);
  wire.frames_stored = status.frames_stored;
  wire.sweeps_left = status.sweeps_left;
  return wire;
}

ldp_lcm::progress_t wire_from(const Progress& progress) {
  auto wire = stamped<ldp_lcm::progress_t>();
  wire.capture = wire_text(progress.capture);
  wire.stage = wire_text(progress.stage);
  wire.fraction = progress.fraction;
  return wire;
}

ldp_lcm::guidance_t wire_from(const Guidance& guidance) {
  auto wire = stamped<ldp_lcm::guidance_t>();
  wire.advice = static_cast<int8_t>(guidance.advice);
  wire.covered_rad = guidance.covered_rad;
  wire.speed_rad_s = guidance.speed_rad_s;
  wire.tilt_px = guidance.tilt_px;
  wire.brightness = guidance.brightness;
  wire.frames_chosen = guidance.frames_chosen;
  return wire;
}

ldp_lcm::result_t wire_from(const Result& result) {
  auto wire = stamped<ldp_lcm::result_t>();
  wire.ok = result.ok ? 1 : 0;
  wire.capture = wire_text(result.capture);
  wire.file = wire_text(result.file);
  wire.text = wire_text(result.text);
  wire.seconds = result.seconds;
  return wire;
}

// The other direction refuses what no sender of ours would say.
template <typename Enum>
std::optional<Enum> enum_from(int8_t code, Enum last) {
  if (code < 0 || code > static_cast<int8_t>(last)) return std::nullopt;
  return static_cast<Enum>(code);
}

bool all_finite(std::initializer_list<double> values) {
  for (const double value : values) {
    if (!std::isfinite(value)) return false;
  }
  return true;
}

std::optional<StatusMessage> message_from(const ldp_lcm::status_t& wire) {
  const auto phase = enum_from(wire.phase, Phase::failed);
  if (!phase || wire.frames_stored < 0) return std::nullopt;
  return Status{*phase, wire.capture, wire.text, wire.frames_stored, wire.sweeps_left};
}

std::optional<StatusMessage> message_from(const ldp_lcm::progress_t& wire) {
  if (!all_finite({wire.fraction})) return std::nullopt;
  return Progress{wire.capture, wire.stage, wire.fraction};
}

std::optional<StatusMessage> message_from(const ldp_lcm::guidance_t& wire) {
  const auto advice = enum_from(wire.advice, Advice::done);
  if (!advice || !all_finite({wire.covered_rad, wire.speed_rad_s, wire.tilt_px, wire.brightness})) return std::nullopt;
  return Guidance{*advice, wire.covered_rad, wire.speed_rad_s, wire.tilt_px, wire.brightness, wire.frames_chosen};
}

std::optional<StatusMessage> message_from(const ldp_lcm::result_t& wire) {
  if (!all_finite({wire.seconds})) return std::nullopt;
  return Result{wire.capture, wire.file, wire.ok != 0, wire.text, wire.seconds};
}

template <typename Wire>
std::optional<Wire> decode(const lcm::ReceiveBuffer& buffer) {
  if (buffer.data_size > static_cast<uint32_t>(std::numeric_limits<int>::max())) return std::nullopt;
  const int size = static_cast<int>(buffer.data_size);
  Wire wire{};
  try {
    if (wire.decode(buffer.data, 0, size) != size || wire.version != kVersion) return std::nullopt;
  } catch (const std::exception&) {
    return std::nullopt;
  }
  return wire;
}

// memq:// keeps its messages inside one LCM object, so everybody in the process who names it shares one.
std::shared_ptr<lcm::LCM> connect(const Url& url) {
  static std::mutex mutex;
  static std::weak_ptr<lcm::LCM> shared_queue;
  const bool in_memory = url.rest().starts_with("memq:");
  const std::scoped_lock lock(mutex);
  if (in_memory) {
    if (auto queue = shared_queue.lock()) return queue;
  }
  auto connection = std::make_shared<lcm::LCM>(url.rest());
  if (!connection->good()) {
    throw std::runtime_error("'" + url.text() +
                             "': LCM cannot use this address; a network that is up and a route for " +
                             "multicast are needed (ip route add 224.0.0.0/4 dev lo serves the machine itself)");
  }
  if (in_memory) shared_queue = connection;
  return connection;
}

// One connection with a queue of what came in, shared by both ends.
template <typename Item>
class Inbox {
 public:
  explicit Inbox(const Url& url) : connection_(connect(url)) {}
  Inbox(const Inbox&) = delete;
  Inbox& operator=(const Inbox&) = delete;
  ~Inbox() {
    for (lcm::Subscription* subscription : subscriptions_) connection_->unsubscribe(subscription);
  }

  lcm::LCM& connection() const { return *connection_; }
  int fd() const { return connection_->getFileno(); }
  int64_t ignored() const { return ignored_; }
  bool ended() const { return ended_; }

  template <typename Owner>
  void listen(const char* channel, void (Owner::*handler)(const lcm::ReceiveBuffer*, const std::string&),
              Owner* owner) {
    subscriptions_.push_back(connection_->subscribe(channel, handler, owner));
  }

  void put(std::optional<Item> item) {
    if (item) {
      items_.push_back(std::move(*item));
    } else {
      ++ignored_;
    }
  }

  std::optional<Item> take() {
    while (items_.empty()) {
      const int handled = connection_->handleTimeout(0);
      if (handled < 0) ended_ = true;
      if (handled <= 0) break;
    }
    if (items_.empty()) return std::nullopt;
    Item item = std::move(items_.front());
    items_.pop_front();
    return item;
  }

 private:
  std::shared_ptr<lcm::LCM> connection_;
  std::vector<lcm::Subscription*> subscriptions_;
  std::deque<Item> items_;
  int64_t ignored_ = 0;
  bool ended_ = false;
};

class LcmStatus final : public StatusChannel {
 public:
  explicit LcmStatus(const Url& url) : inbox_(url) { inbox_.listen(kCommandChannel, &LcmStatus::on_command, this); }

  void publish(const StatusMessage& message) override {
    static constexpr const char* kChannels[] = {kStatusChannel, kProgressChannel, kGuidanceChannel, kResultChannel};
    std::visit(
        [&](const auto& m) {
          const auto wire = wire_from(m);
          inbox_.connection().publish(kChannels[message.index()], &wire);
        },
        message);
  }
  int fd() const override { return inbox_.fd(); }
  std::optional<Command> read() override { return inbox_.take(); }
  int64_t ignored() const override { return inbox_.ignored(); }

 private:
  void on_command(const lcm::ReceiveBuffer* buffer, const std::string&) {
    const auto wire = decode<ldp_lcm::command_t>(*buffer);
    inbox_.put(wire ? enum_from(wire->command, Command::retry) : std::nullopt);
  }

  Inbox<Command> inbox_;
};

class LcmListener final : public StatusListener {
 public:
  explicit LcmListener(const Url& url) : inbox_(url) {
    inbox_.listen(kStatusChannel, &LcmListener::on_message<ldp_lcm::status_t>, this);
    inbox_.listen(kProgressChannel, &LcmListener::on_message<ldp_lcm::progress_t>, this);
    inbox_.listen(kGuidanceChannel, &LcmListener::on_message<ldp_lcm::guidance_t>, this);
    inbox_.listen(kResultChannel, &LcmListener::on_message<ldp_lcm::result_t>, this);
  }

  int fd() const override { return inbox_.fd(); }
  std::optional<HeardMessage> read() override { return inbox_.take(); }
  int64_t ignored() const override { return inbox_.ignored(); }
  bool ended() const override { return inbox_.ended(); }

  void send(Command command) override {
    auto wire = stamped<ldp_lcm::command_t>();
    wire.command = static_cast<int8_t>(command);
    inbox_.connection().publish(kCommandChannel, &wire);
  }

 private:
  template <typename Wire>
  void on_message(const lcm::ReceiveBuffer* buffer, const std::string&) {
    const auto wire = decode<Wire>(*buffer);
    const auto message = wire ? message_from(*wire) : std::nullopt;
    if (message) {
      inbox_.put(HeardMessage{*message, wire->utc_ns, wire->monotonic_ns});
    } else {
      inbox_.put(std::nullopt);
    }
  }

  Inbox<HeardMessage> inbox_;
};

}  // namespace

std::unique_ptr<StatusChannel> open_lcm_status(const Url& url) { return std::make_unique<LcmStatus>(url); }
std::unique_ptr<StatusListener> open_lcm_listener(const Url& url) { return std::make_unique<LcmListener>(url); }

}  // namespace ldp
