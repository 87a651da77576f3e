#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <deque>

#include "drivers/interface/clocks.h"
#include "drivers/interface/errors.h"
#include "sim/devices.h"

namespace ldp {
namespace {

// Standard input without line buffering and echo; the terminal's own settings come back at the end.
class KeyboardButton final : public Button {
 public:
  explicit KeyboardButton(const Url& url) {
    check_keyboard_button(url);
    if (tcgetattr(STDIN_FILENO, &before_) != 0) throw_errno("keyboard: needs a terminal on standard input");
    termios raw = before_;
    raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    raw.c_cc[VMIN] = 0;
    raw.c_cc[VTIME] = 0;
    if (tcsetattr(STDIN_FILENO, TCSANOW, &raw) != 0) throw_errno("keyboard: cannot set up the terminal");
  }
  KeyboardButton(const KeyboardButton&) = delete;
  KeyboardButton& operator=(const KeyboardButton&) = delete;
  ~KeyboardButton() override { tcsetattr(STDIN_FILENO, TCSANOW, &before_); }

  int fd() const override { return STDIN_FILENO; }

  std::optional<ButtonEvent> read() override {
    char key = 0;
    while (events_.empty() && ::read(STDIN_FILENO, &key, 1) == 1) {
      if (key != ' ' && key != '\n' && key != '\r') continue;
      events_.push_back({true, monotonic_now_ns()});
      events_.push_back({false, monotonic_now_ns()});
    }
    if (events_.empty()) {
      refuse_hung_up();
      return std::nullopt;
    }
    const ButtonEvent event = events_.front();
    events_.pop_front();
    return event;
  }

 private:
  // Reading gives nothing, at once and for ever, once the other end is gone.
  static void refuse_hung_up() {
    pollfd entry{STDIN_FILENO, POLLIN, 0};
    if (::poll(&entry, 1, 0) == 1 && (entry.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0) {
      throw std::runtime_error("keyboard: the terminal has hung up");
    }
  }

  termios before_{};
  std::deque<ButtonEvent> events_;
};

}  // namespace

void check_keyboard_button(const Url& url) { url.allow_only(""); }

std::unique_ptr<Button> open_keyboard_button(const Url& url) { return std::make_unique<KeyboardButton>(url); }

}  // namespace ldp
