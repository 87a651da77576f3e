#include "device/service/capture_session.h"

#include <algorithm>
#include <exception>
#include <iterator>
#include <utility>

#include "device/capture/log.h"
#include "device/service/session_tuning.h"
#include "drivers/interface/clocks.h"

namespace ldp {

// The signals are blocked, by the end request, before any thread starts.
CaptureSession::CaptureSession(Config config, Run run, std::stop_token stop)
    : config_(std::move(config)),
      run_(run),
      end_request_(std::move(stop)),
      cycle_(config_, run_, notice_, end_request_),
      button_(config_.button, run_ == Run::service ? config_.switch_off_s : 0) {
  if (run_ == Run::service)
    button_.try_again(monotonic_now_ns());
  else
    open_devices();
}

// A scene is rendered ahead: a mistake in the button is told before. The button that is used comes after,
// for a script's time begins with it.
void CaptureSession::open_devices() {
  try {
    button_.open();
    button_.close();
    if (cycle_.open_camera_ahead()) button_.open();
  } catch (const std::runtime_error& error) {
    cycle_.give_up();
    throw UnusableDevice(error.what());
  }
}

int CaptureSession::run() {
  if (!end_request_.waits()) cycle_.say(text_of(ready()));
  notice_.ready();
  while (!cycle_.over()) {
    wait_and_serve([this] { return watches(); }, next_deadline_ns());
    const int64_t now_ns = monotonic_now_ns();
    check_deadlines(now_ns);
    notice_.feed_watchdog(now_ns);
  }
  notice_.stopping();
  end_in_order();
  return cycle_.exit_status();
}

Watches CaptureSession::watches() {
  Watches watched{{end_request_.fd(), [this] { serve_end_request(); }}};
  if (button_.is_open()) watched.push_back({button_.fd(), [this] { serve_button(); }});
  std::ranges::copy(cycle_.watches([this](Command command) { obey(command); }), std::back_inserter(watched));
  return watched;
}

int64_t CaptureSession::next_deadline_ns() const {
  int64_t deadline_ns = std::min(next_tick_ns_, cycle_.deadline_ns());
  if (const auto hold_ns = button_.next_hold_at_ns()) deadline_ns = std::min(deadline_ns, *hold_ns);
  if (const auto feed_ns = notice_.watchdog_deadline_ns()) deadline_ns = std::min(deadline_ns, *feed_ns);
  return deadline_ns;
}

void CaptureSession::check_deadlines(int64_t now_ns) {
  if (const auto hold = button_.take_hold(now_ns)) button_is_held(*hold);
  cycle_.check_deadlines(now_ns, ready());
  if (now_ns >= next_tick_ns_) tick(now_ns);
}

void CaptureSession::tick(int64_t now_ns) {
  next_tick_ns_ = now_ns + kTick_ns;
  if (button_.is_open()) serve_button();  // a GPIO chip that goes away wakes nobody before Linux 6.6; asked, it says so
  cycle_.begin_waiting_build();
  if (button_.try_again(now_ns) && cycle_.phase() == Phase::idle) cycle_.say(text_of(ready()));
  cycle_.refresh_channels();
}

void CaptureSession::serve_button() {
  try {
    while (const auto event = button_.read()) button_changed(*event);
  } catch (const std::exception& error) {
    const Reason lost{Why::button_lost, error.what()};
    log_warning(text_of(lost));
    button_.close();
    if (cycle_.phase() != Phase::idle) return;
    if (run_ != Run::service) return cycle_.end_run(lost);
    cycle_.say(text_of(ready()));
  }
}

// How long a press lasts counts from when what it began is begun: to open a camera may take longer.
void CaptureSession::button_changed(const ButtonEvent& event) {
  const int64_t begin_ns = monotonic_now_ns();
  cycle_.handle(event.pressed ? Event::press : Event::release, {Why::ended_by_button, {}});
  if (event.pressed) press_is_sweep_ = cycle_.phase() == Phase::capturing;
  button_.note({event.pressed, event.time_ns + (monotonic_now_ns() - begin_ns)});
}

void CaptureSession::button_is_held(Hold hold) {
  switch (hold) {
    case Hold::cancels:
      return cycle_.handle(Event::long_press, {Why::held_to_cancel, {}});
    case Hold::switches_off:
      if (!press_is_sweep_ || cycle_.stood_still()) cycle_.switch_off();
      return;
  }
}

// A command holds nothing: who sends a press may send no release, and that is no button that is held.
void CaptureSession::obey(Command command) {
  switch (command) {
    case Command::press:
      return cycle_.handle(Event::press, {Why::ended_by_command, {}});
    case Command::release:
      return cycle_.handle(Event::release, {Why::ended_by_command, {}});
    case Command::stop:
      return cycle_.handle(Event::stop, {Why::ended_by_command, {}});
    case Command::cancel:
      return cycle_.handle(Event::cancel, {Why::cancelled_by_command, {}});
    case Command::retry:
      if (cycle_.retry_failed()) next_tick_ns_ = 0;
      return;
  }
}

void CaptureSession::serve_end_request() {
  end_request_.take();
  if (cycle_.over()) return;
  interrupted_ = true;
  cycle_.interrupt();
}

void CaptureSession::end_in_order() {
  const bool in_sweep = cycle_.is_storing();
  if (interrupted_ && in_sweep && run_ != Run::service) {
    log_note("interrupted: storing what was taken; once more to leave at once");
  }
  cycle_.store_what_waits();
  if (interrupted_) cycle_.leave_in_order(in_sweep);
  cycle_.tell_ignored();
}

Reason CaptureSession::ready() const {
  if (button_.is_open()) return {Why::ready, {}};
  return {Why::ready_without_button, button_.url()};
}

}  // namespace ldp
