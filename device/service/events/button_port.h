// The button by its URL, opened again while it is gone, and for how long it has been pressed.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "drivers/interface/button.h"

namespace ldp {

class ButtonPort {
 public:
  explicit ButtonPort(std::string url) : url_(std::move(url)) {}  // opens nothing yet
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

  // A press that lasts, of the button or by command.
  void note(const ButtonEvent& event);
  std::optional<int64_t> long_press_at_ns() const;  // when the present one will be a long one
  bool take_long_press(int64_t now_ns);             // once, when it is

 private:
  std::string url_;
  std::unique_ptr<Button> button_;
  std::optional<int64_t> pressed_since_ns_;
  int64_t next_try_ns_ = 0;  // 0 = none yet
};

}  // namespace ldp
