// The capture service: one poll loop over camera, button, status channels, writer, build and signals.
//
// What it turns: the button (events/button_port.h), and the cycle of sweep and build (capture_cycle.h), which is made
// of one run of a sweep (sweep_run.h), the queue of builds (builds/build_queue.h) and the channels that tell the world
// (announcer.h). Why things happen: reasons.h.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <stop_token>
#include <string>

#include "device/service/capture_cycle.h"
#include "device/service/config/config.h"
#include "device/service/events/button_port.h"
#include "device/service/events/end_request.h"
#include "device/service/events/poll_loop.h"
#include "device/service/events/service_notice.h"
#include "device/service/reasons.h"

namespace ldp {

// A camera or button that was named for a single run cannot be opened.
struct UnusableDevice : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class CaptureSession {
 public:
  // Ends when asked through `stop`, or, where that can never be, by SIGTERM, SIGINT and SIGHUP, which it then blocks in
  // this thread and all that start later. Throws UnusableDevice, and what CaptureStore throws where the folder cannot
  // be used or another service works in it.
  CaptureSession(Config config, Run run, std::stop_token stop = {});
  CaptureSession(const CaptureSession&) = delete;
  CaptureSession& operator=(const CaptureSession&) = delete;

  // Until asked to end or the end of what was to be run once. The exit status: 0, 1 when a single run failed, or
  // kSwitchOffStatus.
  int run();
  const Reason& last_failure() const { return cycle_.last_failure(); }
  int frames_stored() const { return cycle_.frames_stored(); }

 private:
  void open_devices();
  Watches watches();
  int64_t next_deadline_ns() const;
  void check_deadlines(int64_t now_ns);
  void tick(int64_t now_ns);
  void serve_button();
  void serve_end_request();
  void button_changed(const ButtonEvent& event);
  void button_is_held(Hold hold);
  void obey(Command command);
  void end_in_order();
  Reason ready() const;

  Config config_;
  Run run_;
  EndRequest end_request_;
  ServiceNotice notice_;
  CaptureCycle cycle_;
  ButtonPort button_;
  int64_t next_tick_ns_ = 0;
  bool interrupted_ = false;
  bool press_is_sweep_ = false;  // the present press, or the last one, found or began one
};

}  // namespace ldp
