// Status messages over LCM (UDP multicast, memq, log files), both ends of them.
//
// Messages are decoded here and not by LCM's own typed subscriptions: those print on stderr and say nothing to us about
// what is malformed. The generated decoders refuse a string length that is longer than the datagram, and one under 1
// because drivers/CMakeLists.txt adds that to them.
#include <cmath>
#include <deque>
#include <lcm/lcm-cpp.hpp>
#include <limits>
#include <mutex>

#include "drivers/backends.h"
#include "drivers/interface/clocks.h"
#include "drivers/lcm_messages.h"
#include "ldp_lcm/command_t.hpp"
#include "ldp_lcm/guidance_t.hpp"
#include "ldp_lcm/progress_t.hpp"
#include "ldp_lcm/result_t.hpp"
#include "ldp_lcm/status_t.hpp"

namespace ldp {
namespace {

template <typename Wire>
constexpr int32_t kVersion = 1;
template <>
constexpr int32_t kVersion<ldp_lcm::result_t> = 2;  // 1 had no verdict

constexpr size_t kMaxTextBytes = 1000;
// A NUL would end the text in LCM's encoding but not in its length.
std::string wire_text(const std::string& text) { return text.substr(0, std::min(text.find('\0'), kMaxTextBytes)); }

template <typename Wire>
Wire stamped() {
  Wire wire{};
  wire.version = kVersion<Wire>;
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
  wire.verdict = static_cast<int8_t>(result.verdict);
  wire.expected_view_psnr_db = result.expected_view_psnr_db;
  wire.reasons = wire_text(result.reasons);
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
  const auto verdict = enum_from(wire.verdict, Judgement::sweep_again);
  if (!verdict || !all_finite({wire.seconds, wire.expected_view_psnr_db})) return std::nullopt;
  return Result{wire.capture, wire.file, wire.ok != 0, wire.text, wire.seconds, *verdict, wire.expected_view_psnr_db,
                wire.reasons};
}

template <typename Wire>
std::vector<uint8_t> encode(const Wire& wire) {
  std::vector<uint8_t> bytes(static_cast<size_t>(wire.getEncodedSize()));
  wire.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

template <typename Wire>
std::optional<Wire> decode(std::span<const uint8_t> bytes) {
  if (bytes.size() > static_cast<size_t>(std::numeric_limits<int>::max())) return std::nullopt;
  const int size = static_cast<int>(bytes.size());
  Wire wire{};
  try {
    if (wire.decode(bytes.data(), 0, size) != size || wire.version != kVersion<Wire>) return std::nullopt;
  } catch (const std::exception&) {
    return std::nullopt;
  }
  return wire;
}

template <typename Wire>
std::optional<HeardMessage> heard(std::span<const uint8_t> bytes) {
  const auto wire = decode<Wire>(bytes);
  const auto message = wire ? message_from(*wire) : std::nullopt;
  if (!message) return std::nullopt;
  return HeardMessage{*message, wire->utc_ns, wire->monotonic_ns};
}

std::span<const uint8_t> bytes_of(const lcm::ReceiveBuffer& buffer) {
  return {static_cast<const uint8_t*>(buffer.data), buffer.data_size};
}

void publish_bytes(lcm::LCM& connection, const char* channel, const std::vector<uint8_t>& bytes) {
  connection.publish(channel, bytes.data(), static_cast<unsigned>(bytes.size()));
}

// memq:// keeps its messages inside one LCM object, so everybody in the process who names it shares one.
std::shared_ptr<lcm::LCM> connect(const Url& url) {
  static std::mutex mutex;
  static std::weak_ptr<lcm::LCM> shared_queue;
  check_lcm(url);
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

// LCM's thread takes messages off the socket at once and drops, without a word, those beyond a queue of 30 that nobody
// has read yet; a burst must be counted whole.
constexpr int kWaitingMessages = 1000;

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
    subscriptions_.back()->setQueueCapacity(kWaitingMessages);
  }

  void put(std::optional<Item> item) {
    if (item) {
      items_.push_back(std::move(*item));
    } else {
      ++ignored_;
    }
  }

  std::optional<Item> take() {
    for (int looked = 0; items_.empty() && looked < kWaitingMessages; ++looked) {  // strangers must not hold us up
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
    publish_bytes(inbox_.connection(), kMessageChannels[message.index()], encode_message(message));
  }
  int fd() const override { return inbox_.fd(); }
  std::optional<Command> read() override {
    auto command = inbox_.take();
    if (!command && inbox_.ended()) throw std::runtime_error("the connection broke");
    return command;
  }
  int64_t ignored() const override { return inbox_.ignored(); }

 private:
  void on_command(const lcm::ReceiveBuffer* buffer, const std::string&) {
    inbox_.put(decode_command(bytes_of(*buffer)));
  }

  Inbox<Command> inbox_;
};

class LcmListener final : public StatusListener {
 public:
  explicit LcmListener(const Url& url) : inbox_(url) {
    for (const char* const channel : kMessageChannels) inbox_.listen(channel, &LcmListener::on_message, this);
  }

  int fd() const override { return inbox_.fd(); }
  std::optional<HeardMessage> read() override { return inbox_.take(); }
  int64_t ignored() const override { return inbox_.ignored(); }
  bool ended() const override { return inbox_.ended(); }

  void send(Command command) override { publish_bytes(inbox_.connection(), kCommandChannel, encode_command(command)); }

 private:
  void on_message(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
    inbox_.put(decode_message(channel, bytes_of(*buffer)));
  }

  Inbox<HeardMessage> inbox_;
};

}  // namespace

std::vector<uint8_t> encode_message(const StatusMessage& message) {
  return std::visit([](const auto& m) { return encode(wire_from(m)); }, message);
}

std::vector<uint8_t> encode_command(Command command) {
  auto wire = stamped<ldp_lcm::command_t>();
  wire.command = static_cast<int8_t>(command);
  return encode(wire);
}

std::optional<HeardMessage> decode_message(const std::string& channel, std::span<const uint8_t> bytes) {
  if (channel == kMessageChannels[0]) return heard<ldp_lcm::status_t>(bytes);
  if (channel == kMessageChannels[1]) return heard<ldp_lcm::progress_t>(bytes);
  if (channel == kMessageChannels[2]) return heard<ldp_lcm::guidance_t>(bytes);
  if (channel == kMessageChannels[3]) return heard<ldp_lcm::result_t>(bytes);
  return std::nullopt;
}

std::optional<Command> decode_command(std::span<const uint8_t> bytes) {
  const auto wire = decode<ldp_lcm::command_t>(bytes);
  return wire ? enum_from(wire->command, kCommands.back()) : std::nullopt;
}

std::unique_ptr<StatusChannel> open_lcm_status(const Url& url) { return std::make_unique<LcmStatus>(url); }
std::unique_ptr<StatusListener> open_lcm_listener(const Url& url) { return std::make_unique<LcmListener>(url); }

}  // namespace ldp
