#include "device/service/events/button_port.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "device/backends/open.h"
#include "device/capture/log.h"
#include "device/service/session_tuning.h"

namespace ldp {

ButtonPort::ButtonPort(std::string url, double switch_off_s)
    : url_(std::move(url)), steps_{{kLongPress_s * kSecond_ns, Hold::cancels}} {
  if (switch_off_s > 0) steps_.push_back({static_cast<int64_t>(switch_off_s * 1e9), Hold::switches_off});
  std::ranges::sort(steps_, {}, &Step::after_ns);
}

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
  steps_taken_ = 0;
}

std::optional<int64_t> ButtonPort::next_hold_at_ns() const {
  if (!pressed_since_ns_ || steps_taken_ == steps_.size()) return std::nullopt;
  return *pressed_since_ns_ + steps_[steps_taken_].after_ns;
}

std::optional<Hold> ButtonPort::take_hold(int64_t now_ns) {
  const auto at_ns = next_hold_at_ns();
  if (!at_ns || now_ns < *at_ns) return std::nullopt;
  return steps_[steps_taken_++].hold;
}

}  // namespace ldp
