#include "device/service/capture_session.h"

#include <malloc.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <thread>

#include "device/backends/open.h"
#include "device/capture/log.h"
#include "drivers/interface/clocks.h"
#include "drivers/interface/errors.h"

namespace ldp {
namespace {

constexpr int64_t kSecond_ns = 1'000'000'000;
constexpr int64_t kLongPress_ns = 3 * kSecond_ns;
constexpr int64_t kRest_ns = 30 * kSecond_ns;  // how long a result stays shown
constexpr int64_t kGuidanceInterval_ns = kSecond_ns / 5;
constexpr int64_t kButtonRetry_ns = 2 * kSecond_ns;
constexpr int kDiskPatience_s = 8;  // at the end, for the next frame to be stored
constexpr const char* kEndedByButton = "the sweep was ended by the button";
constexpr const char* kFull = "the sweep is complete";
constexpr double kDegrees = 57.29577951308232;
constexpr int kMaxInterruptions = 5;  // builds of a capture without a verdict, before it is left alone

std::string frames_text(int frames) { return std::to_string(frames) + (frames == 1 ? " frame" : " frames"); }

std::string seconds_text(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", seconds);
  return text;
}

// What the pictures of a sweep took, and the C library would keep for the next one.
void give_memory_back() {
#ifdef __GLIBC__
  ::malloc_trim(0);
#endif
}

UniqueFd event_descriptor() {
  UniqueFd fd(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
  if (!fd.is_open()) throw_errno("cannot make an event descriptor");
  return fd;
}

UniqueFd ending_signals() {
  sigset_t wanted;
  sigemptyset(&wanted);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&wanted, signal);
  ::pthread_sigmask(SIG_BLOCK, &wanted, nullptr);
  UniqueFd fd(::signalfd(-1, &wanted, SFD_NONBLOCK | SFD_CLOEXEC));
  if (!fd.is_open()) throw_errno("cannot receive signals");
  return fd;
}

}  // namespace

// Signals are blocked before any thread starts, or a thread that does not block them would be ended by them.
CaptureSession::CaptureSession(Config config, Run run, std::stop_token stop)
    : config_(std::move(config)),
      run_(run),
      end_request_(stop.stop_possible() ? event_descriptor() : ending_signals()),
      store_(config_.output) {
  if (stop.stop_possible()) {
    on_stop_.emplace(std::move(stop), [fd = end_request_.get()] {
      const uint64_t one = 1;
      [[maybe_unused]] const ssize_t put = ::write(fd, &one, sizeof one);
    });
  }
  for (const std::string& url : config_.status) pending_statuses_.push_back({url, {}});
  open_statuses_again();
  store_.prepare();
  if (run_ != Run::capture_only) lock_ = store_.lock();
  if (run_ != Run::service) {
    open_devices();
    return;
  }
  for (const CaptureState& capture : store_.recover()) {
    const BuildRecord& build = capture.build;
    const bool wants = !capture.built && !build.cancelled && !build.failed && build.interruptions < kMaxInterruptions;
    if (wants && capture.frames >= config_.min_frames) backlog_.push_back(capture.name);
  }
  open_button_again(monotonic_now_ns());
}

// A scene is rendered when it is opened: a mistake in the button is told before. The button that is used comes after,
// for a script's time begins with it.
void CaptureSession::open_devices() {
  try {
    open_button(config_.button).reset();
    camera_ = open_camera(config_.camera);
    button_ = open_button(config_.button);
  } catch (const std::runtime_error& error) {
    throw UnusableDevice(error.what());
  }
}

// --- the loop --------------------------------------------------------------------------------------------------------

int CaptureSession::run() {
  say(ready_text());
  notice_.ready();
  while (!stopping_) turn();
  notice_.stopping();
  const bool in_sweep = sweep_closing_;
  if (interrupted_ && in_sweep && run_ != Run::service) {
    log_note("interrupted: storing what was taken; once more to leave at once");
  }
  store_what_waits();
  if (interrupted_) leave_in_order(in_sweep);
  tell_ignored(true);
  return exit_status_;
}

void CaptureSession::turn() {
  std::vector<Watch> watched = watches();
  std::vector<pollfd> entries;
  for (const Watch& watch : watched) entries.push_back({watch.fd, POLLIN, 0});
  const int64_t wait_ns = std::max<int64_t>(next_deadline_ns() - monotonic_now_ns(), 0);
  const int timeout_ms = static_cast<int>(std::min<int64_t>(wait_ns / 1'000'000 + 1, 60'000));
  const int ready = ::poll(entries.data(), entries.size(), wait_ns == 0 ? 0 : timeout_ms);
  if (ready < 0 && errno != EINTR) throw_errno("cannot wait for events");
  // One at a time: serving one may close another, or open one in its place.
  const auto unchanged = [&] { return std::ranges::equal(watches(), watched, {}, &Watch::fd, &Watch::fd); };
  for (size_t i = 0; ready > 0 && i < entries.size(); ++i) {
    if (entries[i].revents == 0) continue;
    watched[i].serve();
    if (!unchanged()) break;
  }
  const int64_t now_ns = monotonic_now_ns();
  check_deadlines(now_ns);
  notice_.feed_watchdog(now_ns);
}

std::vector<CaptureSession::Watch> CaptureSession::watches() {
  std::vector<Watch> watched;
  const auto add = [&](int fd, std::function<void()> serve) {
    if (fd >= 0) watched.push_back({fd, std::move(serve)});
  };
  add(end_request_.get(), [this] { serve_end_request(); });
  add(writer_.fd(), [this] { serve_writer(); });
  if (button_) add(button_->fd(), [this] { serve_button(); });
  for (size_t i = 0; i < statuses_.size(); ++i) {
    if (statuses_[i].problem.empty()) add(statuses_[i].channel->fd(), [this, i] { serve_status(statuses_[i]); });
  }
  const auto add_build = [&](const BuildChild& build, void (CaptureSession::*serve)()) {
    for (const int fd : {build.progress_fd(), build.error_fd(), build.end_fd()})
      add(fd, [=, this] { (this->*serve)(); });
  };
  if (build_) add_build(*build_, &CaptureSession::serve_build);
  if (follower_) add_build(*follower_, &CaptureSession::serve_follower);
  if (sweep_) add(sweep_->fd(), [this] { serve_camera(); });
  return watched;
}

int64_t CaptureSession::next_deadline_ns() const {
  int64_t deadline_ns = next_tick_ns_;
  if (sweep_) deadline_ns = std::min(deadline_ns, sweep_->deadline_ns());
  if (pressed_since_ns_) deadline_ns = std::min(deadline_ns, *pressed_since_ns_ + kLongPress_ns);
  if (const auto feed_ns = notice_.watchdog_deadline_ns()) deadline_ns = std::min(deadline_ns, *feed_ns);
  return deadline_ns;
}

void CaptureSession::check_deadlines(int64_t now_ns) {
  if (pressed_since_ns_ && now_ns >= *pressed_since_ns_ + kLongPress_ns) {
    pressed_since_ns_.reset();
    handle(Event::long_press, "cancelled: the button was held for 3 s");
  }
  if (sweep_ && sweep_->full(now_ns)) {
    handle(Event::sweep_full, kFull);
  } else if (sweep_ && sweep_->stalled(now_ns)) {
    handle(Event::camera_lost, "the camera gives no more frames");
  }
  if (rest_at_ns_ != 0 && now_ns >= rest_at_ns_) {
    rest_at_ns_ = 0;
    handle(Event::rest, ready_text());
  }
  if (now_ns < next_tick_ns_) return;
  next_tick_ns_ = now_ns + kSecond_ns;
  if (button_) serve_button();  // a GPIO chip that goes away wakes nobody up before Linux 6.6; asked, it says so
  if (!backlog_.empty() && !build_ && !sweep_closing_) handle(Event::build_pending, "building an unfinished capture");
  open_statuses_again();
  open_button_again(now_ns);
  tell_ignored(false);
  publish_status();
}

// --- events and actions ----------------------------------------------------------------------------------------------

void CaptureSession::handle(Event event, const std::string& why) {
  const Transition transition = next(phase_, event, mode_of(config_));
  const bool changed = transition.phase != phase_;
  phase_ = transition.phase;
  if (changed) rest_at_ns_ = phase_ == Phase::done || phase_ == Phase::failed ? monotonic_now_ns() + kRest_ns : 0;
  if (changed && phase_ != Phase::capturing && phase_ != Phase::building) say(why);
  if (changed && (phase_ == Phase::failed || phase_ == Phase::idle)) last_failure_ = why;
  if (phase_ != Phase::capturing && phase_ != Phase::building) follower_.reset();
  perform(transition.action, why);
  const bool over = phase_ == Phase::idle || phase_ == Phase::done || phase_ == Phase::failed;
  if (changed && over && run_ != Run::service) {
    exit_status_ = phase_ == Phase::done ? 0 : 1;
    stopping_ = true;
  }
}

void CaptureSession::perform(Action action, const std::string& why) {
  switch (action) {
    case Action::none:
      return;
    case Action::begin_sweep:
      return begin_sweep();
    case Action::end_sweep:
      return end_sweep(why, true);
    case Action::keep_sweep:
      return end_sweep(why, false);
    case Action::abandon_sweep:
      return abandon_sweep();
    case Action::start_build:
      return start_build();
    case Action::cancel_build:
      return stop_build(true);
    case Action::suspend_build:
      return stop_build(false);
    case Action::say_busy:
      return say("still building " + capture_ + "; please wait, or hold for 3 s to cancel");
  }
}

void CaptureSession::begin_sweep() {
  frames_stored_ = 0;
  sweep_closing_ = false;  // of a sweep whose build was cancelled: its last frames are written all the same
  capture_.clear();
  storage_problem_.clear();
  say("opening the camera");  // so that a second refusal in a row is told, too
  try {
    if (sweeps_left() < 1) {
      throw std::runtime_error(
          "no room for another sweep on the disk: 0 sweeps left; copy captures away and delete them");
    }
    auto camera = camera_ ? std::move(camera_) : open_camera(config_.camera);
    capture_ =
        run_ == Run::capture_only ? std::filesystem::path(config_.output).filename().string() : store_.create_capture();
    sweep_ = std::make_unique<SweepRun>(config_, std::move(camera), capture_folder(), writer_);
    next_guidance_ns_ = 0;
    sweep_begin_ns_ = monotonic_now_ns();
    say("capturing: turn slowly, arm stretched out");
  } catch (const std::exception& error) {
    discard(std::exchange(capture_, {}));
    handle(Event::sweep_refused, error.what());
  }
}

void CaptureSession::end_sweep(const std::string& why, bool complete) {
  sweep_end_ns_ = monotonic_now_ns();
  end_reason_ = why;
  if (sweep_) covered_rad_ = sweep_->guidance().covered_rad;
  if (sweep_) sweep_->end(why, complete);
  sweep_.reset();
  sweep_closing_ = true;
  say(why + "; storing");
}

void CaptureSession::abandon_sweep() {
  sweep_.reset();
  writer_.forget(capture_folder());
  cancelled_.push_back(std::exchange(capture_, {}));
  discard_cancelled();
  give_memory_back();
  frames_stored_ = 0;
  say("the sweep was cancelled; its frames were removed");
}

// The writer must not write into a folder that is being removed.
void CaptureSession::discard_cancelled() {
  if (writer_.pending() > 0) return;
  for (const std::string& capture : std::exchange(cancelled_, {})) discard(capture);
}

void CaptureSession::discard(const std::string& capture) {
  if (capture.empty() || run_ == Run::capture_only) return;
  try {
    store_.discard(capture);
  } catch (const std::exception& error) {
    log_warning(error.what());
  }
}

// The last frame is on disk: on to the build.
void CaptureSession::continue_after_sweep() {
  sweep_closing_ = false;
  give_memory_back();
  if (phase_ != Phase::building) return;
  if (frames_stored_ < config_.min_frames) {
    return fail_build("only " + frames_text(frames_stored_) + ", at least " + std::to_string(config_.min_frames) +
                          " are needed: " + why_so_few(),
                      false);
  }
  if (run_ == Run::capture_only) {
    publish(Result{capture_, config_.output, true, frames_text(frames_stored_), 0});
    return handle(Event::build_done, frames_text(frames_stored_) + " captured");
  }
  backlog_.push_front(capture_);
  start_build();
}

// As long as frames reach the disk, however slowly; not for ever where it does not answer, nor when asked again.
void CaptureSession::store_what_waits() {
  int64_t patience_end_ns = monotonic_now_ns() + kDiskPatience_s * kSecond_ns;
  for (size_t waiting = writer_.pending(); waiting > 0; waiting = writer_.pending()) {
    notice_.still_stopping(kDiskPatience_s + 2);
    pollfd entries[] = {{writer_.fd(), POLLIN, 0}, {end_request_.get(), POLLIN, 0}};
    ::poll(entries, 2, 1000);
    const int64_t now_ns = monotonic_now_ns();
    notice_.feed_watchdog(now_ns);
    if (entries[0].revents != 0) serve_writer();
    if (writer_.pending() < waiting) patience_end_ns = now_ns + kDiskPatience_s * kSecond_ns;
    const bool hangs = now_ns >= patience_end_ns;
    const bool again = entries[1].revents != 0 && asked_again() && run_ != Run::service;
    if (!hangs && !again) continue;
    log_warning(std::string(hangs ? "the disk does not answer" : "left at once") +
                ": not stored in order: " + frames_text(static_cast<int>(writer_.pending())));
    return writer_.leave();
  }
}

// Takes one request to end; false if there is none.
bool CaptureSession::asked_again() {
  char request[sizeof(signalfd_siginfo)];
  return ::read(end_request_.get(), request, sizeof request) > 0;
}

// A sweep that was interrupted keeps the frames it has; one without any leaves no folder.
void CaptureSession::leave_in_order(bool in_sweep) {
  if (in_sweep && !sweep_closing_ && frames_stored_ == 0 && storage_problem_.empty()) {
    discard(std::exchange(capture_, {}));
  }
  if (run_ == Run::service) return;
  const std::string kept =
      capture_.empty() ? "nothing was kept"
                       : "the sweep is kept in " + capture_folder().string() + " (" + frames_text(frames_stored_) + ")";
  log_note((run_ == Run::once ? "stopped before a panorama was made; " : "stopped; ") + kept);
}

std::string CaptureSession::why_so_few() const {
  if (!storage_problem_.empty()) return storage_problem_;
  if (end_reason_ != kEndedByButton && end_reason_ != kFull) return end_reason_;
  const bool hold = mode_of(config_) == ButtonMode::hold;
  return "the sweep lasted " + seconds_text(static_cast<double>(sweep_end_ns_ - sweep_begin_ns_) * 1e-9) +
         " and turned by " + std::to_string(std::lround(covered_rad_ * kDegrees)) +
         " degrees: " + (hold ? "hold the button while you turn" : "press, turn") +
         " slowly through at least a quarter circle" + (hold ? "" : ", press again");
}

BuildCommand CaptureSession::build_command(bool follows) const {
  BuildCommand command;
  command.is_told = follows;
  command.program = program_of(config_);
  command.niceness = config_.niceness;
  command.memory_limit_bytes = uint64_t{static_cast<unsigned>(config_.memory_limit_mib)} << 20;
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  const int threads = config_.threads > 0 ? config_.threads : static_cast<int>(cores);
  command.arguments = {"build",     store_.folder_of(capture_).string(),
                       "-o",        store_.building_of(capture_).string(),
                       "--threads", std::to_string(threads)};
  if (config_.fov_degrees > 0) {
    command.arguments.insert(command.arguments.end(), {"--fov", std::to_string(config_.fov_degrees)});
  }
  if (follows) command.arguments.emplace_back("--follow");
  command.arguments.insert(command.arguments.end(), config_.options.begin(), config_.options.end());
  return command;
}

// The build begins with the first frame and is told of each. Whatever becomes of it, the sweep goes on.
void CaptureSession::follow(const std::string& stored_file) {
  if (!config_.follow || run_ == Run::capture_only || (phase_ != Phase::capturing && phase_ != Phase::building)) return;
  try {
    if (frames_stored_ == 1) {
      store_.clear_building();
      follower_ = std::make_unique<BuildChild>(build_command(true));
    }
    if (follower_) follower_->tell(stored_file);
  } catch (const std::exception& error) {
    log_warning(std::string(error.what()) + "; the sweep is built after its end");
    follower_.reset();
  }
}

bool CaptureSession::follower_takes_over() {
  if (!follower_) return false;
  try {
    follower_->tell("end");
    return true;
  } catch (const std::exception&) {
    follower_.reset();  // it has just died
    return false;
  }
}

void CaptureSession::start_build() {
  const bool unfinished = capture_ != backlog_.front();
  capture_ = backlog_.front();
  backlog_.pop_front();
  if (unfinished) sweep_end_ns_ = monotonic_now_ns();
  try {
    store_.clear_building();
    BuildRecord record = store_.read_build_record(capture_);
    ++record.interruptions;  // taken back when the build comes to a verdict
    store_.write_build_record(capture_, record);
    build_ = follower_takes_over() ? std::move(follower_) : std::make_unique<BuildChild>(build_command(false));
    say("building " + capture_);
  } catch (const std::exception& error) {
    fail_build(error.what(), true);
  }
}

void CaptureSession::stop_build(bool cancelled) {
  build_.reset();
  if (capture_.empty() || run_ == Run::capture_only) return;
  if (sweep_closing_ && !cancelled) return;  // not begun yet
  try {
    store_.clear_building();
    BuildRecord record = store_.read_build_record(capture_);
    record.interruptions = std::max(0, record.interruptions - 1);
    record.cancelled = cancelled;
    if (cancelled) record.reason = "cancelled";
    store_.write_build_record(capture_, record);
  } catch (const std::exception& error) {
    log_warning(std::string(error.what()) + ": the next start builds " + capture_ + " again");
  }
  if (cancelled) say("the build was cancelled; the frames are kept in " + capture_);
}

void CaptureSession::finish_build(const BuildEnd& end) {
  build_.reset();
  if (!end.ok) {
    // The build knows its file by the name that it has until it is whole.
    std::string reason = end.reason;
    const std::string building = store_.building_of(capture_).string();
    if (const size_t at = reason.find(building); at != std::string::npos)
      reason.replace(at, building.size(), store_.panorama_of(capture_).string());
    return fail_build(reason, end.retry);
  }
  try {
    store_.publish_panorama(capture_);
  } catch (const std::exception& error) {
    return fail_build(error.what(), true);
  }
  const double seconds = static_cast<double>(monotonic_now_ns() - sweep_end_ns_) * 1e-9;
  const std::string file = store_.panorama_of(capture_).string();
  publish(Result{capture_, file, true, "built in " + seconds_text(seconds), seconds});
  handle(Event::build_done, file + " is ready");
}

// With `retry` the next start tries again; else only a command does.
void CaptureSession::fail_build(const std::string& reason, bool retry) {
  if (run_ != Run::capture_only) {
    try {
      store_.clear_building();
      const int interruptions = retry ? store_.read_build_record(capture_).interruptions : 0;
      store_.write_build_record(capture_, {interruptions, false, !retry, reason});
    } catch (const std::exception& error) {
      log_warning(error.what());
    }
  }
  const double seconds = static_cast<double>(monotonic_now_ns() - sweep_end_ns_) * 1e-9;
  publish(Result{capture_, {}, false, reason, seconds});
  handle(Event::build_failed, reason);
}

// --- what the descriptors bring --------------------------------------------------------------------------------------

void CaptureSession::serve_camera() {
  try {
    sweep_->read_frame();
  } catch (const std::exception& error) {
    return handle(Event::camera_lost, error.what());
  }
  const int64_t now_ns = monotonic_now_ns();
  if (now_ns < next_guidance_ns_) return;
  next_guidance_ns_ = now_ns + kGuidanceInterval_ns;
  publish(sweep_->guidance());
}

void CaptureSession::serve_writer() {
  while (const auto outcome = writer_.take()) {
    if (capture_.empty() || outcome->folder != capture_folder()) {  // of a sweep before this one
      if (!outcome->error.empty()) log_warning("cannot store: " + outcome->error);
    } else if (!outcome->error.empty()) {
      if (storage_problem_.empty()) storage_problem_ = "cannot store: " + outcome->error;
    } else if (!outcome->file.empty()) {
      ++frames_stored_;
      follow(outcome->file);
      publish_status();
    }
  }
  if (!storage_problem_.empty() && sweep_) {
    handle(Event::storage_failed, storage_problem_ + " (" + frames_text(frames_stored_) + " are stored)");
  }
  if (sweep_closing_ && writer_.pending() == 0) continue_after_sweep();
  discard_cancelled();
}

void CaptureSession::serve_build() {
  if (!build_) return;
  build_->read_errors();
  if (const auto progress = build_->read_progress()) publish(Progress{capture_, progress->stage, progress->fraction});
  if (const auto end = build_->end()) finish_build(*end);
}

void CaptureSession::serve_follower() {
  if (!follower_) return;
  follower_->read_errors();
  follower_->read_progress();
  const auto end = follower_->end();
  if (!end) return;
  const std::string why = end->ok ? "it did not wait for the end" : end->reason;
  log_warning("the build that followed the sweep is over: " + why + "; the sweep is built after its end");
  follower_.reset();
}

void CaptureSession::serve_end_request() {
  asked_again();
  if (stopping_) return;  // a single run is over
  handle(Event::shutdown, "shutting down");
  stopping_ = true;
  interrupted_ = true;
  if (run_ != Run::service) exit_status_ = 1;
}

void CaptureSession::serve_button() {
  try {
    while (const auto event = button_->read()) button_changed(*event);
  } catch (const std::exception& error) {
    log_warning(std::string("the button was lost: ") + error.what());
    button_.reset();
    pressed_since_ns_.reset();
    if (phase_ == Phase::idle && run_ != Run::service)
      return give_up(std::string("the button was lost: ") + error.what());
    if (phase_ == Phase::idle) say(ready_text());
  }
}

// Of a single run that waits for what will not come.
void CaptureSession::give_up(const std::string& why) {
  last_failure_ = why;
  exit_status_ = 1;
  stopping_ = true;
}

void CaptureSession::button_changed(const ButtonEvent& event) {
  if (event.pressed) {
    pressed_since_ns_ = event.time_ns;
    handle(Event::press, kEndedByButton);
  } else {
    pressed_since_ns_.reset();
    handle(Event::release, kEndedByButton);
  }
}

void CaptureSession::serve_status(OpenStatus& status) {
  std::optional<Command> command;
  do {
    command.reset();
    attempt(status, [&](StatusChannel& channel) { command = channel.read(); });
    if (command) obey(*command);
  } while (command);
}

void CaptureSession::obey(Command command) {
  switch (command) {
    case Command::press:
      return button_changed({true, monotonic_now_ns()});
    case Command::release:
      return button_changed({false, monotonic_now_ns()});
    case Command::cancel:
      return handle(Event::cancel, "cancelled by command");
    case Command::retry:
      return retry_failed();
  }
}

void CaptureSession::retry_failed() {
  if (run_ != Run::service || build_ || sweep_ || sweep_closing_) return;
  backlog_.clear();
  try {
    for (const CaptureState& capture : store_.recover()) {
      if (capture.built || capture.frames < config_.min_frames) continue;
      store_.forget_build_record(capture.name);
      backlog_.push_back(capture.name);
    }
  } catch (const std::exception& error) {
    log_warning(error.what());
  }
  next_tick_ns_ = 0;
}

// --- what comes and goes ---------------------------------------------------------------------------------------------

void CaptureSession::open_button_again(int64_t now_ns) {
  if (button_ || now_ns < next_button_try_ns_) return;
  const bool first_try = next_button_try_ns_ == 0;
  next_button_try_ns_ = now_ns + kButtonRetry_ns;
  try {
    button_ = open_button(config_.button);
    if (!first_try) log_note("the button is there: " + config_.button);
    if (phase_ == Phase::idle && !text_.empty()) say(ready_text());
  } catch (const std::exception& error) {
    if (first_try) log_warning(std::string(error.what()) + "; trying again every 2 s");
  }
}

// A network may come up late, an LED may go. Each problem is told once.
void CaptureSession::open_statuses_again() {
  for (OpenStatus& status : statuses_) {
    if (!status.problem.empty()) pending_statuses_.push_back({status.url, {}});
  }
  std::erase_if(statuses_, [](const OpenStatus& status) { return !status.problem.empty(); });
  std::vector<PendingStatus> still_pending;
  for (PendingStatus& pending : pending_statuses_) {
    try {
      statuses_.push_back({pending.url, open_status(pending.url), {}});
    } catch (const std::exception& error) {
      if (pending.problem != error.what()) log_warning(error.what());
      still_pending.push_back({pending.url, error.what()});
    }
  }
  pending_statuses_ = std::move(still_pending);
}

// --- what the world is told ------------------------------------------------------------------------------------------

void CaptureSession::publish(const StatusMessage& message) {
  for (OpenStatus& status : statuses_) {
    if (status.problem.empty()) attempt(status, [&](StatusChannel& channel) { channel.publish(message); });
  }
}

// A channel that fails is closed at the next tick: this may be called from its own commands.
void CaptureSession::attempt(OpenStatus& status, const std::function<void(StatusChannel&)>& what) {
  try {
    what(*status.channel);
  } catch (const std::exception& error) {
    status.problem = error.what();
    log_warning(status.url + ": " + error.what());
  }
}

void CaptureSession::publish_status() {
  int left = 0;
  try {
    left = sweeps_left();
  } catch (const std::exception&) {
    left = 0;  // the folder went away; the next sweep will say so
  }
  publish(Status{phase_, capture_, text_, frames_stored_, left});
}

// Again only when there are ten times as many, and at the end.
void CaptureSession::tell_ignored(bool at_end) {
  int64_t ignored = 0;
  for (const OpenStatus& status : statuses_) ignored += status.channel->ignored();
  if (ignored == ignored_told_ || (!at_end && ignored < 10 * ignored_told_)) return;
  ignored_told_ = ignored;
  log_warning("malformed messages ignored so far: " + std::to_string(ignored));
}

void CaptureSession::say(const std::string& text) {
  if (text == text_) return;
  text_ = text;
  notice_.status(std::string(name_of(phase_)) + ": " + text);
  publish_status();
}

std::string CaptureSession::ready_text() const {
  return button_ ? "ready" : "ready for commands only: the button is missing (" + config_.button + ")";
}

int CaptureSession::sweeps_left() const {
  return store_.sweeps_left(uint64_t{static_cast<unsigned>(config_.reserve_mib)} << 20);
}

std::filesystem::path CaptureSession::capture_folder() const {
  return run_ == Run::capture_only ? std::filesystem::path(config_.output) : store_.folder_of(capture_);
}

}  // namespace ldp
