// Why a session did what it did: told apart by an enum, said to people in one place (reasons.cpp).
#pragma once

#include <cstdint>
#include <string>
#include <system_error>

#include "device/service/session_state.h"

namespace ldp {

enum class Why : uint8_t {
  none,
  // a sweep ends
  ended_by_button,
  ended_by_command,
  sweep_complete,  // all the way round, or a limit was reached
  camera_lost,     // detail: what its back-end said
  camera_silent,
  storage_failed,  // detail: what could not be stored
  // by the person
  held_to_cancel,  // the button, for kLongPress_s
  cancelled_by_command,
  shutting_down,
  held_to_switch_off,
  // a sweep does not begin, or a single run waits for what will not come
  no_room,       // on the disk
  cannot_begin,  // detail: the camera that cannot be opened, the folder that cannot be made
  button_lost,   // detail: what its back-end said
  // of builds
  capture_waits,
  too_few_frames,  // detail: see `too_few_frames`
  build_failed,    // detail: what the build said
  built,           // detail: the file
  built_but_poor,  // the same; the sweep should be taken again
  captured,        // detail: how many frames
  // nothing happens
  ready,
  ready_without_button,  // detail: its URL
};

struct Reason {
  Why why = Why::none;
  std::string detail;
  std::error_code code = {};  // of the system call that failed, where it is known
};

// One line for people; capture.json, the status channels and `ldp capture` tell it.
std::string text_of(const Reason& reason);

std::string frames_text(int frames);       // "1 frame", "7 frames"
std::string seconds_text(double seconds);  // "12.3 s"

// What a sweep came to that is not worth a build.
struct ShortSweep {
  int frames = 0, frames_needed = 0;
  Reason end;              // why it ended
  Reason storage_problem;  // none: everything was stored
  double seconds = 0;
  double covered_rad = 0;
  ButtonMode mode = ButtonMode::toggle;
};
Reason too_few_frames(const ShortSweep& sweep);

}  // namespace ldp
