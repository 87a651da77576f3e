#include <array>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "drivers/interface/clocks.h"
#include "drivers/interface/ticker.h"
#include "sim/devices.h"

namespace ldp {
namespace {

constexpr size_t kMostBytes = 1 << 20;
constexpr double kMostWait_ms = 1e10;  // in all: four months

std::string script_text(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("cannot read the button script '" + file + "': check its name and permissions");
  std::string text;
  std::array<char, 4096> part;
  while (text.size() <= kMostBytes && (in.read(part.data(), part.size()), in.gcount() > 0))
    text.append(part.data(), static_cast<size_t>(in.gcount()));
  if (text.empty())
    throw std::runtime_error("the button script '" + file + "' is empty" +
                             (std::filesystem::is_regular_file(file) ? "" : ": a pipe can be read once only"));
  if (text.size() > kMostBytes) throw std::runtime_error("the button script '" + file + "' is longer than a megabyte");
  return text;
}

std::vector<ButtonEvent> parse_script(const std::string& file, int64_t start_ns) {
  std::istringstream lines(script_text(file));
  std::vector<ButtonEvent> events;
  double waited_ms = 0;
  int line_number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++line_number;
    const auto refuse = [&](const std::string& why) {
      throw std::runtime_error(file + ":" + std::to_string(line_number) + ": " + why);
    };
    std::istringstream words(line.substr(0, line.find('#')));
    for (std::string word; words >> word;) {
      double wait_ms = -1;
      if (word == "press" || word == "release") {
        events.push_back({word == "press", start_ns + static_cast<int64_t>(waited_ms * 1e6)});
      } else if (word != "wait" || !(words >> wait_ms) || wait_ms < 0) {
        refuse("'" + word + "' is not press, release or wait MILLISECONDS");
      } else if ((waited_ms += wait_ms) > kMostWait_ms) {
        refuse("the waits are longer than four months in all");
      }
    }
  }
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
