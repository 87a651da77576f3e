// Push button and LED on GPIO lines through libgpiod, whose two generations have different interfaces: version 1
// (Debian 12) is recognised by its line bulks, which version 2 does not have. Everything that differs is in `GpioLine`.
#include <gpiod.h>
#include <poll.h>
#include <sys/epoll.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/backends.h"
#include "drivers/debouncer.h"
#include "drivers/interface/clocks.h"
#include "drivers/interface/errors.h"
#include "drivers/interface/ticker.h"
#include "drivers/led_light.h"
#include "drivers/led_pattern.h"

namespace ldp {
namespace {

enum class Bias { as_is, off, pull_up, pull_down };

struct LineSpec {
  std::string url;   // for messages
  std::string name;  // of the line, or empty:
  std::string chip;  // "gpiochip0" or "/dev/gpiochip0"
  unsigned offset = 0;
  bool output = false;
  bool active_low = false;
  Bias bias = Bias::as_is;
  int64_t debounce_ns = 0;
};

constexpr double kDebounce_ms = 30;

LineSpec spec_from(const Url& url) {
  LineSpec spec;
  spec.url = url.text();
  spec.active_low = url.flag("active_low", false);
  const std::string bias = url.word("bias", "as-is");
  constexpr std::array kBiases = {"as-is", "off", "pull-up", "pull-down"};
  const auto found = std::find(kBiases.begin(), kBiases.end(), bias);
  if (found == kBiases.end()) {
    throw std::runtime_error("'" + spec.url + "': bias is '" + bias + "', expected as-is, off, pull-up or pull-down");
  }
  spec.bias = static_cast<Bias>(found - kBiases.begin());
  const std::string& path = url.path();
  if (path.starts_with("name=")) {
    spec.name = path.substr(5);
    return spec;
  }
  const size_t slash = path.rfind('/');
  const std::string offset = slash == std::string::npos ? "" : path.substr(slash + 1);
  const bool digits =
      !offset.empty() && offset.size() < 6 && offset.find_first_not_of("0123456789") == std::string::npos;
  if (!digits || slash == 0) {
    throw std::runtime_error("'" + spec.url + "': expected CHIP/LINE as in gpiochip0/17, or name=LINE_NAME");
  }
  spec.chip = path.substr(0, slash);
  spec.offset = static_cast<unsigned>(std::stoul(offset));
  return spec;
}

LineSpec button_spec_from(const Url& url) {
  url.allow_only("active_low bias debounce_ms");
  LineSpec spec = spec_from(url);
  spec.debounce_ns = static_cast<int64_t>(url.number("debounce_ms", kDebounce_ms, {0, 1000}) * 1e6);
  return spec;
}

LineSpec led_spec_from(const Url& url) {
  url.allow_only("active_low bias");
  LineSpec spec = spec_from(url);
  spec.output = true;
  return spec;
}

std::string device_of(const std::string& chip) { return chip.starts_with("/") ? chip : "/dev/" + chip; }

[[noreturn]] void refuse(const LineSpec& spec, const std::string& why, int error = errno) {
  throw_errno("'" + spec.url + "': " + why, error);
}

// Removes what a constructor failed to hand over, and what a destructor frees.
template <auto free_function>
struct Free {
  template <typename T>
  void operator()(T* object) const {
    free_function(object);
  }
};

#ifdef GPIOD_LINE_BULK_MAX_LINES

class GpioLine {
 public:
  // Version 1 cannot ask the kernel to debounce.
  explicit GpioLine(const LineSpec& spec) {
    line_ = spec.name.empty() ? by_offset(spec) : by_name(spec);
    chip_.reset(gpiod_line_get_chip(line_));
    const int flags = flags_of(spec);
    const int result = spec.output ? gpiod_line_request_output_flags(line_, "ldpd", flags, 0)
                                   : gpiod_line_request_both_edges_events_flags(line_, "ldpd", flags);
    if (result != 0) refuse(spec, "cannot use this GPIO line");
  }

  int fd() const { return gpiod_line_event_get_fd(line_); }
  bool debounces() const { return false; }

  bool value() const {
    const int value = gpiod_line_get_value(line_);
    if (value < 0) throw_errno("the GPIO line was lost");
    return value == 1;
  }

  void set(bool on) {
    if (gpiod_line_set_value(line_, on ? 1 : 0) != 0) throw_errno("the GPIO line was lost");
  }

  void read_edges() {
    gpiod_line_event events[16];
    if (gpiod_line_event_read_fd_multiple(fd(), events, 16) < 0) throw_errno("the GPIO line was lost");
  }

 private:
  static gpiod_line* by_name(const LineSpec& spec) {
    gpiod_line* const line = gpiod_line_find(spec.name.c_str());
    if (line == nullptr)
      throw AdvisedError("'" + spec.url + "': no GPIO line of that name", ENOENT, "gpioinfo lists them");
    return line;
  }

  static gpiod_line* by_offset(const LineSpec& spec) {
    gpiod_chip* const chip = gpiod_chip_open(device_of(spec.chip).c_str());
    if (chip == nullptr) refuse(spec, "cannot open the GPIO chip '" + device_of(spec.chip) + "'");
    gpiod_line* const line = gpiod_chip_get_line(chip, spec.offset);
    if (line == nullptr) {
      const int error = errno;
      gpiod_chip_close(chip);
      refuse(spec, "the GPIO chip has no such line", error);
    }
    return line;
  }

  static int flags_of(const LineSpec& spec) {
    constexpr std::array kBiasFlags = {0, int{GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE},
                                       int{GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP},
                                       int{GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN}};
    return kBiasFlags[static_cast<size_t>(spec.bias)] | (spec.active_low ? int{GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW} : 0);
  }

  gpiod_line* line_ = nullptr;  // owned by its chip
  std::unique_ptr<gpiod_chip, Free<gpiod_chip_close>> chip_;
};

#else

class GpioLine {
 public:
  // Asks the kernel to debounce.
  explicit GpioLine(const LineSpec& spec) {
    const std::unique_ptr<gpiod_chip, Free<gpiod_chip_close>> chip(open_chip(spec));
    const std::unique_ptr<gpiod_line_settings, Free<gpiod_line_settings_free>> settings(gpiod_line_settings_new());
    const std::unique_ptr<gpiod_line_config, Free<gpiod_line_config_free>> lines(gpiod_line_config_new());
    const std::unique_ptr<gpiod_request_config, Free<gpiod_request_config_free>> request(gpiod_request_config_new());
    events_.reset(gpiod_edge_event_buffer_new(16));
    if (!settings || !lines || !request || !events_) refuse(spec, "out of memory", ENOMEM);
    gpiod_request_config_set_consumer(request.get(), "ldpd");
    fill(*settings, spec);
    gpiod_line_settings_set_debounce_period_us(settings.get(), static_cast<unsigned long>(spec.debounce_ns / 1000));
    debounces_ = spec.debounce_ns > 0;
    for (;;) {
      gpiod_line_config_reset(lines.get());
      gpiod_line_config_add_line_settings(lines.get(), &offset_, 1, settings.get());
      request_.reset(gpiod_chip_request_lines(chip.get(), request.get(), lines.get()));
      if (request_ || !debounces_) break;
      debounces_ = false;  // an old kernel: once more without
      gpiod_line_settings_set_debounce_period_us(settings.get(), 0);
    }
    if (!request_) refuse(spec, "cannot use this GPIO line");
  }

  int fd() const { return gpiod_line_request_get_fd(request_.get()); }
  bool debounces() const { return debounces_; }

  bool value() const {
    const gpiod_line_value value = gpiod_line_request_get_value(request_.get(), offset_);
    if (value == GPIOD_LINE_VALUE_ERROR) throw_errno("the GPIO line was lost");
    return value == GPIOD_LINE_VALUE_ACTIVE;
  }

  void set(bool on) {
    const auto value = on ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
    if (gpiod_line_request_set_value(request_.get(), offset_, value) != 0) throw_errno("the GPIO line was lost");
  }

  void read_edges() {
    if (gpiod_line_request_read_edge_events(request_.get(), events_.get(), 16) < 0) {
      throw_errno("the GPIO line was lost");
    }
  }

 private:
  gpiod_chip* open_chip(const LineSpec& spec) {
    offset_ = spec.offset;
    if (spec.name.empty()) {
      gpiod_chip* const chip = gpiod_chip_open(device_of(spec.chip).c_str());
      if (chip == nullptr) refuse(spec, "cannot open the GPIO chip '" + device_of(spec.chip) + "'");
      return chip;
    }
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator("/dev", error)) {
      if (!gpiod_is_gpiochip_device(entry.path().c_str())) continue;
      gpiod_chip* const chip = gpiod_chip_open(entry.path().c_str());
      if (chip == nullptr) continue;
      const int offset = gpiod_chip_get_line_offset_from_name(chip, spec.name.c_str());
      if (offset >= 0) {
        offset_ = static_cast<unsigned>(offset);
        return chip;
      }
      gpiod_chip_close(chip);
    }
    throw AdvisedError("'" + spec.url + "': no GPIO line of that name", ENOENT, "gpioinfo lists them");
  }

  static void fill(gpiod_line_settings& settings, const LineSpec& spec) {
    constexpr std::array kBiases = {GPIOD_LINE_BIAS_AS_IS, GPIOD_LINE_BIAS_DISABLED, GPIOD_LINE_BIAS_PULL_UP,
                                    GPIOD_LINE_BIAS_PULL_DOWN};
    gpiod_line_settings_set_direction(&settings,
                                      spec.output ? GPIOD_LINE_DIRECTION_OUTPUT : GPIOD_LINE_DIRECTION_INPUT);
    if (!spec.output) gpiod_line_settings_set_edge_detection(&settings, GPIOD_LINE_EDGE_BOTH);
    gpiod_line_settings_set_bias(&settings, kBiases[static_cast<size_t>(spec.bias)]);
    gpiod_line_settings_set_active_low(&settings, spec.active_low);
  }

  unsigned offset_ = 0;
  bool debounces_ = false;
  std::unique_ptr<gpiod_line_request, Free<gpiod_line_request_release>> request_;
  std::unique_ptr<gpiod_edge_event_buffer, Free<gpiod_edge_event_buffer_free>> events_;
};

#endif

bool is_readable(int fd) {
  pollfd entry{fd, POLLIN, 0};
  return ::poll(&entry, 1, 0) == 1;
}

// The line and the debouncing timer behind one epoll descriptor.
class GpioButton final : public Button {
 public:
  explicit GpioButton(const LineSpec& spec)
      : line_(spec),
        debouncer_(line_.value(), line_.debounces() ? 0 : spec.debounce_ns),
        epoll_(epoll_create1(EPOLL_CLOEXEC)) {
    if (!epoll_.is_open()) throw_errno("cannot make an epoll descriptor");
    for (const int fd : {line_.fd(), ticker_.fd()}) {
      epoll_event event{};
      event.events = EPOLLIN;
      if (epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, fd, &event) != 0) throw_errno("cannot poll the button");
    }
  }

  int fd() const override { return epoll_.get(); }

  std::optional<ButtonEvent> read() override {
    ticker_.take_expirations();
    while (is_readable(line_.fd())) {
      line_.read_edges();
      debouncer_.edge(monotonic_now_ns());
    }
    const auto event = debouncer_.settle(line_.value(), monotonic_now_ns());
    if (const auto deadline_ns = debouncer_.deadline_ns()) ticker_.start_at(*deadline_ns, 0);
    return event;
  }

 private:
  GpioLine line_;
  Debouncer debouncer_;
  Ticker ticker_;
  UniqueFd epoll_;
};

// Shows led_sign of what it is told.
class GpioLed final : public StatusChannel {
 public:
  explicit GpioLed(const LineSpec& spec) : line_(spec) {}
  GpioLed(const GpioLed&) = delete;
  GpioLed& operator=(const GpioLed&) = delete;
  ~GpioLed() override {
    try {
      line_.set(false);
    } catch (const std::exception&) {
      // it went away, and its light with it
    }
  }

  void publish(const StatusMessage& message) override {
    if (const auto* const status = std::get_if<Status>(&message)) {
      if (status->phase != said_.phase) said_.advice = Advice::keep_going;
      said_.phase = status->phase;
      said_.has_room = status->sweeps_left > 0;
    } else if (const auto* const guidance = std::get_if<Guidance>(&message)) {
      said_.advice = guidance->advice;
    } else if (const auto* const result = std::get_if<Result>(&message)) {
      said_.judgement = result->verdict;
      return;  // shown with the phase that follows
    } else {
      return;
    }
    light_.show(led_pattern(led_sign(said_)));
  }

  int fd() const override { return light_.fd(); }

  std::optional<Command> read() override {
    light_.wake();
    return std::nullopt;
  }

 private:
  GpioLine line_;
  LedLight light_{[this](bool lit) { line_.set(lit); }};
  LedSources said_;
};

}  // namespace

void check_gpiod_button(const Url& url) { button_spec_from(url); }
void check_gpiod_led(const Url& url) { led_spec_from(url); }

std::unique_ptr<Button> open_gpiod_button(const Url& url) {
  return std::make_unique<GpioButton>(button_spec_from(url));
}
std::unique_ptr<StatusChannel> open_gpiod_led(const Url& url) { return std::make_unique<GpioLed>(led_spec_from(url)); }

}  // namespace ldp
