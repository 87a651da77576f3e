// The button by its URL, opened again while it is gone, and what a press that lasts comes to.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/interface/button.h"

namespace ldp {

enum class Hold : uint8_t { cancels, switches_off };

class ButtonPort {
 public:
  // Opens nothing yet. `switch_off_s`: how long a press lasts that switches off; 0 = none does.
  explicit ButtonPort(std::string url, double switch_off_s = 0);
  ButtonPort(const ButtonPort&) = delete;
  ButtonPort& operator=(const ButtonPort&) = delete;

  void open();  // throws std::runtime_error
  bool try_again(
      int64_t now_ns);  // where it is missing, from time to time; true when it has come. Tells the first failure
  void close();

  bool is_open() const { return button_ != nullptr; }
  const std::string& url() const { return url_; }
  int fd() const { return button_ ? button_->fd() : -1; }
  std::optional<ButtonEvent> read() { return button_->read(); }  // throws std::runtime_error when it is lost

  // A press that lasts.
  void note(const ButtonEvent& event);
  std::optional<int64_t> next_hold_at_ns() const;  // when the present one will come to something more
  std::optional<Hold> take_hold(int64_t now_ns);   // to what it has; each once

 private:
  struct Step {
    int64_t after_ns;
    Hold hold;
  };
  std::string url_;
  std::vector<Step> steps_;  // in the order of time
  std::unique_ptr<Button> button_;
  std::optional<int64_t> pressed_since_ns_;
  size_t steps_taken_ = 0;   // of the present press
  int64_t next_try_ns_ = 0;  // 0 = none yet
};

}  // namespace ldp
