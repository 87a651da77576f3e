#include "device/service/events/button_port.h"

#include <exception>

#include "device/backends/open.h"
#include "device/capture/log.h"
#include "device/service/session_tuning.h"

namespace ldp {

void ButtonPort::open() { button_ = open_button(url_); }

bool ButtonPort::try_again(int64_t now_ns) {
  if (button_ || now_ns < next_try_ns_) return false;
  const bool first_try = next_try_ns_ == 0;
  next_try_ns_ = now_ns + kButtonRetry_s * kSecond_ns;
  try {
    open();
    if (!first_try) log_note("the button is there: " + url_);
    return true;
  } catch (const std::exception& error) {
    const std::string again = "; trying again every " + std::to_string(kButtonRetry_s) + " s";
    if (first_try) log_warning(error.what() + again);
    return false;
  }
}

void ButtonPort::close() {
  button_.reset();
  pressed_since_ns_.reset();
}

void ButtonPort::note(const ButtonEvent& event) {
  pressed_since_ns_ = event.pressed ? std::optional(event.time_ns) : std::nullopt;
}

std::optional<int64_t> ButtonPort::long_press_at_ns() const {
  if (!pressed_since_ns_) return std::nullopt;
  return *pressed_since_ns_ + kLongPress_s * kSecond_ns;
}

bool ButtonPort::take_long_press(int64_t now_ns) {
  const auto at_ns = long_press_at_ns();
  if (!at_ns || now_ns < *at_ns) return false;
  pressed_since_ns_.reset();
  return true;
}

}  // namespace ldp
