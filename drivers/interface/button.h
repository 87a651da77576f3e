// A push button: debounced presses and releases through one file descriptor, chosen by URL.
//
//   gpiod:gpiochip0/17   gpiod:name=capture-button   ?active_low=yes bias=pull-up|pull-down|off debounce_ms=20
//   script:FILE          words press, release, wait MILLISECONDS, played from opening on; # starts a comment
//   keyboard:            space or Enter on the terminal: presses and releases at once
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace ldp {

struct ButtonEvent {
  bool pressed = false;  // false: released
  int64_t time_ns = 0;   // CLOCK_MONOTONIC
};

class Button {
 public:
  virtual ~Button() = default;
  virtual int fd() const = 0;                     // readable when `read` may give something
  virtual std::optional<ButtonEvent> read() = 0;  // presses and releases alternate; throws std::runtime_error when lost
};

}  // namespace ldp
