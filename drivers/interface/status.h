// What the device tells the world, and commands that come back: chosen by URL.
//
//   lcm:udpm://239.255.76.67:7667?ttl=0    lcm:memq://     channels LDP_STATUS, LDP_PROGRESS, ... (drivers/*.lcm)
//   console:                                               one line a message on standard error
//   led:gpiochip0/18   led:name=capture-led                a sign for each state (drivers/led_pattern.h)
//
// Publishing never blocks. It throws where a channel is lost, as a light that is unplugged: who publishes goes on
// without it, and may open it again.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>

namespace ldp {

enum class Phase : uint8_t { idle, capturing, building, done, failed };
const char* name_of(Phase phase);

// Every change of state, and once a second while anybody may have missed one.
struct Status {
  Phase phase = Phase::idle;
  std::string capture;    // name of the sweep concerned, empty in idle
  std::string text;       // one line for people
  int frames_stored = 0;  // whole on disk
  int sweeps_left = 0;    // that fit into the free space
};

// How far the build is.
struct Progress {
  std::string capture, stage;
  double fraction = 0;  // of this stage, 0 .. 1
};

enum class Advice : uint8_t { keep_going, slower, faster, level, too_dark, turn_back, done };
const char* name_of(Advice advice);

// What the person should do now; while the sweep runs, several times a second.
struct Guidance {
  Advice advice = Advice::keep_going;
  double covered_rad = 0;  // angle from the first frame to now
  double speed_rad_s = 0;  // of the turn
  double tilt_px = 0;      // drift up (+) or down since the first frame
  double brightness = 0;   // mean grey, 0 .. 1
  int frames_chosen = 0;
};

// What a build says of its sweep.
enum class Judgement : uint8_t { none, good, fair, sweep_again };
const char* name_of(Judgement judgement);

// A finished or failed build.
struct Result {
  std::string capture, file;  // file empty when failed
  bool ok = false;
  std::string text;    // one line: figures, or the reason
  double seconds = 0;  // from the end of the sweep
  Judgement verdict = Judgement::none;
  double expected_view_psnr_db = 0;  // of new views; 0 when not judged
  std::string reasons;               // for people, one a line; empty when nothing is wrong
};

// `press` and `release` do what the button does, held for no time; `stop` ends the sweep whatever its mode.
enum class Command : uint8_t { press, release, cancel, retry, stop };
inline constexpr std::array kCommands = {Command::press, Command::release, Command::cancel, Command::retry,
                                         Command::stop};
const char* name_of(Command command);

using StatusMessage = std::variant<Status, Progress, Guidance, Result>;

class StatusChannel {
 public:
  virtual ~StatusChannel() = default;
  virtual void publish(const StatusMessage& message) = 0;         // throws std::runtime_error when lost
  virtual int fd() const { return -1; }                           // readable when `read` may give something; -1 = never
  virtual std::optional<Command> read() { return std::nullopt; }  // throws std::runtime_error when lost
  virtual int64_t ignored() const { return 0; }                   // malformed or unknown messages so far
};

// The other end: what `ldp watch` reads. Only lcm: URLs can be listened to, log files (lcm:file://LOG?speed=0)
// included.
struct HeardMessage {
  StatusMessage message;
  int64_t utc_ns = 0, monotonic_ns = 0;  // the sender's clocks
};

class StatusListener {
 public:
  virtual ~StatusListener() = default;
  virtual int fd() const = 0;
  virtual std::optional<HeardMessage> read() = 0;
  virtual int64_t ignored() const = 0;  // malformed messages so far
  virtual bool ended() const = 0;       // a log was read to its end, or the connection broke
  virtual void send(Command command) = 0;
};

}  // namespace ldp
