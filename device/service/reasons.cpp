#include "device/service/reasons.h"

#include <cmath>
#include <cstdio>

#include "core/geometry/degrees.h"
#include "device/service/session_tuning.h"

namespace ldp {
namespace {

// The person ended it, or a limit: no fault to name.
bool ended_in_order(const Reason& end) {
  return end.why == Why::ended_by_button || end.why == Why::ended_by_command || end.why == Why::sweep_complete;
}

std::string why_so_few(const ShortSweep& sweep) {
  if (sweep.storage_problem.why != Why::none) return text_of(sweep.storage_problem);
  if (!ended_in_order(sweep.end)) return text_of(sweep.end);
  const bool hold = sweep.mode == ButtonMode::hold;
  return "the sweep lasted " + seconds_text(sweep.seconds) + " and turned by " +
         std::to_string(std::lround(sweep.covered_rad * kDegreesPerRadian)) +
         " degrees: " + (hold ? "hold the button while you turn" : "press, turn") +
         " slowly through at least a quarter circle" + (hold ? "" : ", press again");
}

}  // namespace

std::string text_of(const Reason& reason) {
  switch (reason.why) {
    case Why::none:
      return {};
    case Why::ended_by_button:
      return "the sweep was ended by the button";
    case Why::ended_by_command:
      return "the sweep was ended by command";
    case Why::sweep_complete:
      return "the sweep is complete";
    case Why::camera_silent:
      return "the camera gives no more frames";
    case Why::held_to_cancel:
      return "cancelled: the button was held for " + std::to_string(kLongPress_s) + " s";
    case Why::cancelled_by_command:
      return "cancelled by command";
    case Why::shutting_down:
      return "shutting down";
    case Why::held_to_switch_off:
      return "switching off: the button was held";
    case Why::no_room:
      return "no room for another sweep on the disk: 0 sweeps left; copy captures away and delete them";
    case Why::button_lost:
      return "the button was lost: " + reason.detail;
    case Why::capture_waits:
      return "building an unfinished capture";
    case Why::built:
      return reason.detail + " is ready";
    case Why::built_but_poor:
      return reason.detail + " is ready; sweep again";
    case Why::captured:
      return reason.detail + " captured";
    case Why::ready:
      return "ready";
    case Why::ready_without_button:
      return "ready for commands only: the button is missing (" + reason.detail + ")";
    case Why::camera_lost:
    case Why::storage_failed:
    case Why::cannot_begin:
    case Why::too_few_frames:
    case Why::build_failed:
      return reason.detail;
  }
  return reason.detail;
}

std::string frames_text(int frames) { return std::to_string(frames) + (frames == 1 ? " frame" : " frames"); }

std::string seconds_text(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", seconds);
  return text;
}

Reason too_few_frames(const ShortSweep& sweep) {
  const bool not_stored = sweep.storage_problem.why != Why::none;
  return {Why::too_few_frames,
          "only " + frames_text(sweep.frames) + ", at least " + std::to_string(sweep.frames_needed) +
              " are needed: " + why_so_few(sweep),
          not_stored ? sweep.storage_problem.code : sweep.end.code};
}

}  // namespace ldp
