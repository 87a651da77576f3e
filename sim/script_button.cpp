#include <fstream>
#include <sstream>
#include <vector>

#include "drivers/interface/clocks.h"
#include "drivers/interface/ticker.h"
#include "sim/devices.h"

namespace ldp {
namespace {

std::vector<ButtonEvent> parse_script(const std::string& file, int64_t start_ns) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("cannot read the button script '" + file + "'");
  std::vector<ButtonEvent> events;
  int64_t now_ns = start_ns;
  int line_number = 0;
  for (std::string line; std::getline(in, line);) {
    ++line_number;
    std::istringstream words(line.substr(0, line.find('#')));
    for (std::string word; words >> word;) {
      double wait_ms = -1;
      if (word == "press" || word == "release") {
        events.push_back({word == "press", now_ns});
      } else if (word == "wait" && words >> wait_ms && wait_ms >= 0 && wait_ms < 1e9) {
        now_ns += static_cast<int64_t>(wait_ms * 1e6);
      } else {
        std::string refusal = file;
        refusal.append(":").append(std::to_string(line_number)).append(": '").append(word);
        throw std::runtime_error(refusal.append("' is not press, release or wait MILLISECONDS"));
      }
    }
  }
  if (line_number == 0)
    throw std::runtime_error("the button script '" + file + "' is empty: a pipe can be read once only");
  return events;
}

class ScriptButton final : public Button {
 public:
  explicit ScriptButton(const Url& url) : events_(parse_script(url.path(), monotonic_now_ns())) { arm(); }

  int fd() const override { return ticker_.fd(); }

  std::optional<ButtonEvent> read() override {
    ticker_.take_expirations();
    if (next_ == events_.size()) return std::nullopt;
    if (events_[next_].time_ns > monotonic_now_ns()) {
      arm();
      return std::nullopt;
    }
    const ButtonEvent event = events_[next_++];
    arm();
    return event;
  }

 private:
  void arm() {
    if (next_ < events_.size()) ticker_.start_at(events_[next_].time_ns, 0);
  }

  std::vector<ButtonEvent> events_;
  size_t next_ = 0;
  Ticker ticker_;
};

}  // namespace

void check_script_button(const Url& url) { url.allow_only(""); }

std::unique_ptr<Button> open_script_button(const Url& url) {
  check_script_button(url);
  return std::make_unique<ScriptButton>(url);
}

}  // namespace ldp
