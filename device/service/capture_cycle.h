// From the press of the button through a sweep and its build to a result, again and again: the states of
// session_state.h and what is done in them. Time and descriptors come from the loop (capture_session.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "device/capture/capture_store.h"
#include "device/capture/frame_writer.h"
#include "device/service/announcer.h"
#include "device/service/builds/build_queue.h"
#include "device/service/config/config.h"
#include "device/service/events/end_request.h"
#include "device/service/events/poll_loop.h"
#include "device/service/events/service_notice.h"
#include "device/service/reasons.h"
#include "device/service/session_state.h"
#include "device/service/sweep_folders.h"
#include "device/service/sweep_run.h"

namespace ldp {

// The service's exit status when the button was held to switch the device off, which is then the system's to do.
inline constexpr int kSwitchOffStatus = 10;

enum class Run : uint8_t {
  service,       // until told to stop
  once,          // one sweep, its build, then the end
  capture_only,  // one sweep into the output folder itself, no build
};

class CaptureCycle {
 public:
  // All must live longer. A service takes up what an earlier run left. Throws what CaptureStore throws where the
  // folder cannot be used or another service works in it.
  CaptureCycle(const Config& config, Run run, ServiceNotice& notice, EndRequest& end_request);
  CaptureCycle(const CaptureCycle&) = delete;
  CaptureCycle& operator=(const CaptureCycle&) = delete;

  // Of a single sweep; throws std::runtime_error. False: the end was asked for meanwhile.
  bool open_camera_ahead();
  void give_up();  // before anything began: no folder that it made is left

  // What the loop asks.
  Watches watches(const std::function<void(Command)>& obey);
  int64_t deadline_ns() const;
  void check_deadlines(int64_t now_ns, const Reason& ready);  // `ready`: told once a result has been shown long enough
  void begin_waiting_build();
  void refresh_channels();

  void handle(Event event, const Reason& reason);
  bool retry_failed();  // everything without a panorama waits to be built again; false where there is other work
  void say(const std::string& text);
  Phase phase() const { return phase_; }
  bool stood_still() const {
    return !sweep_ || sweep_->stands_still();
  }  // in the present or last sweep, if there is one

  // The end.
  bool over() const { return over_; }  // of a single run, or told so
  void end_run(const Reason& reason);  // that waits for what will not come
  void interrupt();                    // whatever goes on is left for the next start
  void switch_off();                   // the same, but a sweep that was begun is none
  void store_what_waits();
  void leave_in_order(bool in_sweep);  // `in_sweep`: it was storing when it was interrupted
  void tell_ignored() { announcer_.tell_ignored(true); }
  bool is_storing() const { return sweep_ && sweep_->stores(); }
  int exit_status() const { return exit_status_; }
  const Reason& last_failure() const { return last_failure_; }
  int frames_stored() const { return sweep_ ? sweep_->frames_stored() : 0; }

 private:
  void perform(Action action, const Reason& reason);
  std::unique_ptr<CameraDevice> ready_camera();
  void begin_sweep();
  void refuse_sweep(const Reason& reason);
  void end_sweep(const Reason& reason, bool complete);
  void abandon_sweep();
  void discard_if_empty();
  void continue_after_sweep();

  void follow(const std::string& stored_file);
  void start_build();
  void stop_build(bool cancelled);
  void finish_build(const BuildEnd& end);
  void fail_build(const Reason& reason, bool retry);
  void tell_failure(const Reason& reason);

  void serve_camera();
  void serve_writer();
  void serve_build();

  void publish_status();
  double seconds_of_work() const;
  bool is_taking() const { return sweep_ && sweep_->takes(); }

  const Config& config_;
  Run run_;
  ServiceNotice& notice_;
  EndRequest& end_request_;
  CaptureStore store_;
  std::vector<std::filesystem::path> made_;  // for the store
  UniqueFd lock_;                            // on the store; let go after the builds have ended
  FrameWriter writer_;
  Announcer announcer_;
  std::unique_ptr<CameraDevice> camera_;  // opened ahead of a single sweep
  SweepFolders folders_;
  std::unique_ptr<SweepRun> sweep_;  // the present one or, until another begins, the last
  BuildQueue builds_;

  Phase phase_ = Phase::idle;
  std::string text_;           // the present one line for people
  std::string capture_;        // name of the sweep in work
  int64_t work_since_ns_ = 0;  // end of the sweep in work; begin of the build of an earlier one
  int64_t rest_at_ns_ = 0;     // 0 = no result is shown
  bool over_ = false;
  int exit_status_ = 0;
  Reason last_failure_;
};

}  // namespace ldp
