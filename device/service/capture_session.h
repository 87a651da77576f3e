// The capture service: one poll loop over camera, button, status, writer, build and signals, and the state machine of
// session_state.h between them.
#pragma once

#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <vector>

#include "device/capture/capture_store.h"
#include "device/capture/frame_writer.h"
#include "device/service/build_child.h"
#include "device/service/config.h"
#include "device/service/service_notice.h"
#include "device/service/session_state.h"
#include "device/service/sweep_run.h"
#include "drivers/interface/button.h"
#include "drivers/interface/status.h"

namespace ldp {

// A camera or button that was named for a single run cannot be opened.
struct UnusableDevice : std::runtime_error {
  using std::runtime_error::runtime_error;
};

enum class Run : uint8_t {
  service,       // until told to stop
  once,          // one sweep, its build, then the end
  capture_only,  // one sweep into the output folder itself, no build
};

class CaptureSession {
 public:
  // Ends when asked through `stop`, or, where that can never be, by SIGTERM, SIGINT and SIGHUP, which it then blocks in
  // this thread and all that start later. Throws UnusableDevice, and what CaptureStore throws where the folder cannot
  // be used or another service works in it.
  CaptureSession(Config config, Run run, std::stop_token stop = {});
  CaptureSession(const CaptureSession&) = delete;
  CaptureSession& operator=(const CaptureSession&) = delete;

  // Until asked to end or the end of what was to be run once. The exit status: 0, or 1 when a single run failed.
  int run();
  const std::string& last_failure() const { return last_failure_; }
  int frames_stored() const { return frames_stored_; }

 private:
  struct Watch {
    int fd;
    std::function<void()> serve;
  };
  struct OpenStatus {
    std::string url;
    std::unique_ptr<StatusChannel> channel;
    std::string problem;  // why it is of no further use
  };
  struct PendingStatus {
    std::string url;
    std::string problem;
  };

  std::vector<Watch> watches();
  int64_t next_deadline_ns() const;
  void turn();
  void check_deadlines(int64_t now_ns);

  void handle(Event event, const std::string& why);
  void perform(Action action, const std::string& why);
  void begin_sweep();
  void end_sweep(const std::string& why, bool complete);
  void abandon_sweep();
  void start_build();
  void stop_build(bool cancelled);
  void finish_build(const BuildEnd& end);
  void continue_after_sweep();
  std::string why_so_few() const;
  void leave_in_order(bool in_sweep);
  void store_what_waits();
  bool asked_again();
  void discard_cancelled();
  void discard(const std::string& capture);
  void fail_build(const std::string& reason, bool retry);
  BuildCommand build_command(bool follows) const;
  void follow(const std::string& stored_file);
  bool follower_takes_over();

  void open_devices();
  void open_button_again(int64_t now_ns);
  void open_statuses_again();
  void serve_button();
  void give_up(const std::string& why);
  void button_changed(const ButtonEvent& event);
  void serve_camera();
  void serve_writer();
  void serve_build();
  void serve_follower();
  void serve_end_request();
  void serve_status(OpenStatus& status);
  void obey(Command command);
  void retry_failed();

  void publish(const StatusMessage& message);
  void attempt(OpenStatus& status, const std::function<void(StatusChannel&)>& what);
  void publish_status();
  void tell_ignored(bool at_end);
  void say(const std::string& text);
  std::string ready_text() const;
  int sweeps_left() const;
  std::filesystem::path capture_folder() const;

  Config config_;
  Run run_;
  UniqueFd end_request_;  // readable when the session is to end
  CaptureStore store_;
  UniqueFd lock_;  // on the store; let go after the builds have ended
  ServiceNotice notice_;
  FrameWriter writer_;
  std::vector<OpenStatus> statuses_;
  std::vector<PendingStatus> pending_statuses_;
  std::unique_ptr<CameraDevice> camera_;  // opened ahead of a single sweep
  std::unique_ptr<Button> button_;
  std::unique_ptr<SweepRun> sweep_;
  std::unique_ptr<BuildChild> build_;
  std::unique_ptr<BuildChild> follower_;  // the build of the sweep that still goes on; becomes `build_` at its end
  std::optional<std::stop_callback<std::function<void()>>> on_stop_;

  Phase phase_ = Phase::idle;
  std::string text_;     // the present one line for people
  std::string capture_;  // name of the sweep in work
  int frames_stored_ = 0;
  bool sweep_closing_ = false;                // ended, its last frames are being written
  std::string end_reason_, storage_problem_;  // of the sweep
  std::deque<std::string> backlog_;           // captures that wait to be built
  std::vector<std::string> cancelled_;        // captures that go when nothing is written into them any more
  std::optional<int64_t> pressed_since_ns_;
  double covered_rad_ = 0;  // by the sweep, when it ended
  int64_t sweep_begin_ns_ = 0, sweep_end_ns_ = 0, next_tick_ns_ = 0, next_button_try_ns_ = 0, rest_at_ns_ = 0,
          next_guidance_ns_ = 0;
  bool stopping_ = false;
  bool interrupted_ = false;  // stopping because it was asked to
  int64_t ignored_told_ = 0;  // malformed messages, when they were last spoken of
  int exit_status_ = 0;
  std::string last_failure_;
};

}  // namespace ldp
