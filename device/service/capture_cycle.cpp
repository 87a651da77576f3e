#include "device/service/capture_cycle.h"

#include <malloc.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <iterator>
#include <limits>
#include <system_error>
#include <utility>

#include "device/backends/open.h"
#include "device/capture/log.h"
#include "device/service/builds/build_verdict.h"
#include "device/service/events/last_frames.h"
#include "device/service/session_tuning.h"
#include "drivers/interface/clocks.h"
#include "drivers/interface/errors.h"

namespace ldp {
namespace {

// What pictures and builds took, and the C library would keep: every time in other pages, so that the service seemed to
// grow.
void give_memory_back() {
#ifdef __GLIBC__
  ::malloc_trim(0);
#endif
}

bool has_result(Phase phase) { return phase == Phase::done || phase == Phase::failed; }
bool is_at_work(Phase phase) { return phase == Phase::capturing || phase == Phase::building; }

}  // namespace

CaptureCycle::CaptureCycle(const Config& config, Run run, ServiceNotice& notice, EndRequest& end_request)
    : config_(config),
      run_(run),
      notice_(notice),
      end_request_(end_request),
      store_(config_.output),
      announcer_(config_.status),
      folders_(config_, store_, run_ == Run::capture_only),
      builds_(config_, store_) {
  made_ = store_.prepare();
  if (run_ != Run::capture_only) lock_ = store_.lock();
  if (run_ == Run::service) builds_.add_unfinished();
}

// None where the end was asked for meanwhile: to open a camera may take long, and nobody waits for that sweep any more.
std::unique_ptr<CameraDevice> CaptureCycle::ready_camera() {
  auto camera = open_camera(config_.camera);
  const auto give_up = [this] { return end_request_.waits(); };
  if (!camera->prepare(give_up) || give_up()) return nullptr;
  return camera;
}

void CaptureCycle::give_up() { store_.give_up(made_); }

bool CaptureCycle::open_camera_ahead() {
  camera_ = ready_camera();
  return camera_ != nullptr;
}

// --- what the loop asks ----------------------------------------------------------------------------------------------

Watches CaptureCycle::watches(const std::function<void(Command)>& obey) {
  Watches watched{{writer_.fd(), [this] { serve_writer(); }}};
  std::ranges::copy(announcer_.watches(obey), std::back_inserter(watched));
  std::ranges::copy(builds_.watches([this] { serve_build(); }), std::back_inserter(watched));
  if (is_taking()) watched.push_back({sweep_->fd(), [this] { serve_camera(); }});
  return watched;
}

int64_t CaptureCycle::deadline_ns() const {
  return is_taking() ? sweep_->deadline_ns() : std::numeric_limits<int64_t>::max();
}

void CaptureCycle::check_deadlines(int64_t now_ns, const Reason& ready) {
  if (is_taking() && sweep_->full(now_ns)) {
    handle(Event::sweep_full, {Why::sweep_complete, {}});
  } else if (is_taking() && sweep_->stalled(now_ns)) {
    handle(Event::camera_lost, {Why::camera_silent, {}});
  }
  if (rest_at_ns_ == 0 || now_ns < rest_at_ns_) return;
  rest_at_ns_ = 0;
  handle(Event::rest, ready);
}

void CaptureCycle::begin_waiting_build() {
  if (builds_.waits() && !builds_.runs() && !is_storing()) handle(Event::build_pending, {Why::capture_waits, {}});
}

void CaptureCycle::refresh_channels() {
  announcer_.open_missing();
  announcer_.tell_ignored(false);
  publish_status();
}

// --- the states ------------------------------------------------------------------------------------------------------

// What comes together with the request to end begins nothing.
void CaptureCycle::handle(Event event, const Reason& reason) {
  if (over_) return;
  const Transition transition = next(phase_, event, mode_of(config_));
  const bool changed = transition.phase != phase_;
  phase_ = transition.phase;
  if (changed) rest_at_ns_ = has_result(phase_) ? monotonic_now_ns() + kRest_ns : 0;
  if (changed && !is_at_work(phase_)) say(text_of(reason));
  if (changed && (phase_ == Phase::failed || phase_ == Phase::idle)) last_failure_ = reason;
  if (!is_at_work(phase_)) builds_.stop_following();
  perform(transition.action, reason);
  if (changed && !is_at_work(phase_)) give_memory_back();
  if (changed && !is_at_work(phase_) && run_ != Run::service) {
    exit_status_ = phase_ == Phase::done ? 0 : 1;
    over_ = true;
  }
}

void CaptureCycle::perform(Action action, const Reason& reason) {
  switch (action) {
    case Action::none:
      return;
    case Action::begin_sweep:
      return begin_sweep();
    case Action::end_sweep:
      return end_sweep(reason, true);
    case Action::keep_sweep:
      return is_taking() ? end_sweep(reason, false) : void();
    case Action::abandon_sweep:
      return abandon_sweep();
    case Action::start_build:
      return start_build();
    case Action::cancel_build:
      return stop_build(true);
    case Action::suspend_build:
      return stop_build(false);
    case Action::say_busy:
      return say("still building " + capture_ + "; please wait, or hold for " + std::to_string(kLongPress_s) +
                 " s to cancel");
  }
}

// --- the sweep -------------------------------------------------------------------------------------------------------

void CaptureCycle::begin_sweep() {
  sweep_.reset();  // of one whose build was cancelled the last frames are written all the same
  capture_.clear();
  say("opening the camera");  // so that a second refusal in a row is told, too
  try {
    if (folders_.sweeps_left() < 1) return refuse_sweep({Why::no_room, {}});
    auto camera = camera_ ? std::move(camera_) : ready_camera();
    if (!camera) return handle(Event::shutdown, {Why::shutting_down, {}});
    capture_ = folders_.create();
    sweep_ = std::make_unique<SweepRun>(config_, std::move(camera), folders_.of(capture_), writer_);
  } catch (const std::exception& error) {
    return refuse_sweep({Why::cannot_begin, error.what(), code_of(error)});
  }
  say("turn slowly, arm stretched out");
}

void CaptureCycle::refuse_sweep(const Reason& reason) {
  folders_.discard(std::exchange(capture_, {}));
  handle(Event::sweep_refused, reason);
}

void CaptureCycle::end_sweep(const Reason& reason, bool complete) {
  sweep_->end(reason, complete);
  work_since_ns_ = sweep_->end_ns();
  say(text_of(reason) + "; storing");
}

void CaptureCycle::abandon_sweep() {
  sweep_.reset();
  folders_.cancel(std::exchange(capture_, {}), writer_);
  say("the sweep was cancelled; its frames were removed");
}

// A sweep without a frame leaves no folder, unless it is the disk's doing.
void CaptureCycle::discard_if_empty() {
  if (frames_stored() == 0 && sweep_->storage_problem().why == Why::none) folders_.discard(std::exchange(capture_, {}));
}

// The last frame is on disk: on to the build.
void CaptureCycle::continue_after_sweep() {
  sweep_->finish_storing();
  give_memory_back();
  if (phase_ != Phase::building) return;
  if (frames_stored() < config_.min_frames) {
    fail_build(sweep_->too_few_frames(), false);
    return discard_if_empty();
  }
  if (run_ == Run::capture_only) {
    const std::string frames = frames_text(frames_stored());
    Result stored;
    stored.capture = capture_, stored.file = config_.output, stored.ok = true, stored.text = frames;
    announcer_.publish(stored);
    return handle(Event::build_done, {Why::captured, frames});
  }
  builds_.put_first(capture_);
  start_build();
}

// --- its build -------------------------------------------------------------------------------------------------------

// The build begins with the first frame.
void CaptureCycle::follow(const std::string& stored_file) {
  if (!config_.follow || run_ == Run::capture_only || !is_at_work(phase_)) return;
  builds_.follow(capture_, stored_file, frames_stored() == 1);
}

void CaptureCycle::start_build() {
  const std::string previous = std::exchange(capture_, builds_.take_next());
  if (capture_ != previous) work_since_ns_ = monotonic_now_ns();
  try {
    builds_.start(capture_);
  } catch (const std::exception& error) {
    return fail_build({Why::build_failed, error.what()}, true);
  }
  say("building " + capture_);
}

void CaptureCycle::stop_build(bool cancelled) {
  builds_.kill();
  if (capture_.empty() || run_ == Run::capture_only) return;
  if (is_storing() && !cancelled) return;  // not begun yet
  builds_.record_stop(capture_, cancelled);
  if (cancelled) say("the build was cancelled; the frames are kept in " + capture_);
}

void CaptureCycle::finish_build(const BuildEnd& end) {
  const BuildEnd outcome = builds_.conclude(capture_, end);
  if (!outcome.ok) return tell_failure({Why::build_failed, outcome.reason});
  const double seconds = seconds_of_work();
  const std::string file = store_.panorama_of(capture_).string();
  Result result;
  result.capture = capture_, result.file = file, result.ok = true;
  result.text = "built in " + seconds_text(seconds), result.seconds = seconds;
  add_verdict(store_.report_of(capture_), result);
  std::error_code ignored;  // what lies there is removed before the next build begins
  std::filesystem::remove(store_.report_of(capture_), ignored);
  announcer_.publish(result);
  const Why why = result.verdict == Judgement::sweep_again ? Why::built_but_poor : Why::built;
  handle(Event::build_done, {why, file});
}

// With `retry` the next start tries again; else only a command does.
void CaptureCycle::fail_build(const Reason& reason, bool retry) {
  if (run_ != Run::capture_only) builds_.record_failure(capture_, {false, text_of(reason), retry});
  tell_failure(reason);
}

void CaptureCycle::tell_failure(const Reason& reason) {
  Result result;
  result.capture = capture_, result.text = text_of(reason), result.seconds = seconds_of_work();
  announcer_.publish(result);
  handle(Event::build_failed, reason);
}

// A sweep that was cancelled may still be written: it is neither to be built, nor are its temporary files left over.
bool CaptureCycle::retry_failed() {
  if (run_ != Run::service || builds_.runs() || is_taking() || is_storing() || writer_.pending() > 0) return false;
  builds_.add_failed();
  return true;
}

// --- what the descriptors bring --------------------------------------------------------------------------------------

void CaptureCycle::serve_camera() {
  try {
    sweep_->read_frame();
  } catch (const std::exception& error) {
    return handle(Event::camera_lost, {Why::camera_lost, error.what()});
  }
  if (const auto guidance = sweep_->next_guidance(monotonic_now_ns())) announcer_.publish(*guidance);
}

void CaptureCycle::serve_writer() {
  while (const auto outcome = writer_.take()) {
    if (!sweep_ || outcome->folder != sweep_->folder()) {  // of a sweep before this one
      if (!outcome->error.empty()) log_warning("cannot store: " + outcome->error);
      continue;
    }
    const int before = frames_stored();
    sweep_->note(*outcome);
    if (frames_stored() == before) continue;
    follow(outcome->file);
    publish_status();
  }
  if (is_taking() && sweep_->storage_problem().why != Why::none) {
    Reason failed = sweep_->storage_problem();
    failed.detail += " (" + frames_text(frames_stored()) + " are stored)";
    handle(Event::storage_failed, failed);
  }
  if (is_storing() && writer_.pending() == 0) continue_after_sweep();
  folders_.discard_cancelled(writer_);
}

void CaptureCycle::serve_build() {
  if (!builds_.runs()) return;
  const auto end = builds_.end();  // asked first: of one that is over, what is read now is all that it said
  if (const auto progress = builds_.read_progress()) {
    announcer_.publish(Progress{capture_, progress->stage, progress->fraction});
  }
  if (const auto remark = builds_.take_remark()) say(capture_ + "; so far " + *remark);
  if (end) finish_build(*end);
}

// --- the end ---------------------------------------------------------------------------------------------------------

void CaptureCycle::end_run(const Reason& reason) {
  last_failure_ = reason;
  exit_status_ = 1;
  over_ = true;
}

void CaptureCycle::interrupt() {
  handle(Event::shutdown, {Why::shutting_down, {}});
  over_ = true;
  if (run_ != Run::service) exit_status_ = 1;
}

void CaptureCycle::switch_off() {
  handle(is_taking() ? Event::cancel : Event::shutdown, {Why::held_to_switch_off, {}});
  say(text_of({Why::held_to_switch_off, {}}));
  over_ = true;
  exit_status_ = kSwitchOffStatus;
}

void CaptureCycle::store_what_waits() {
  wait_for_last_frames({writer_, end_request_, notice_, run_ != Run::service, [this] { serve_writer(); }});
}

// A sweep that was interrupted keeps the frames it has.
void CaptureCycle::leave_in_order(bool in_sweep) {
  if (in_sweep && !is_storing()) discard_if_empty();
  if (run_ == Run::service) return;
  const std::string kept = capture_.empty() ? "nothing was kept"
                                            : "the sweep is kept in " + folders_.of(capture_).string() + " (" +
                                                  frames_text(frames_stored()) + ")";
  log_note((run_ == Run::once ? "stopped before a panorama was made; " : "stopped; ") + kept);
}

// --- what the world is told ------------------------------------------------------------------------------------------

void CaptureCycle::say(const std::string& text) {
  if (text == text_) return;
  text_ = text;
  notice_.status(std::string(name_of(phase_)) + ": " + text);
  publish_status();
}

void CaptureCycle::publish_status() {
  int left = 0;
  try {
    left = folders_.sweeps_left();
  } catch (const std::exception&) {
    left = 0;  // the folder went away; the next sweep will say so
  }
  announcer_.publish(Status{phase_, capture_, text_, frames_stored(), left});
}

double CaptureCycle::seconds_of_work() const { return static_cast<double>(monotonic_now_ns() - work_since_ns_) * 1e-9; }

}  // namespace ldp
