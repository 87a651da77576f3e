// The states of the device and what happens in them as a pure function: no clock, no file, no device.
//
// What the button means depends on how it is set up: toggle, where one press begins and the next ends the sweep and a
// press of three seconds cancels; or hold, where the sweep lasts as long as the button is held.
#pragma once

#include <array>
#include <cstdint>

#include "drivers/interface/status.h"

namespace ldp {

enum class ButtonMode : uint8_t { toggle, hold };

enum class Event : uint8_t {
  press,
  release,
  long_press,  // held for three seconds by now
  stop,        // the sweep is to end; asked for over the status channel, as is the next
  cancel,
  sweep_refused,  // the sweep could not begin: no camera, no room
  sweep_full,     // all the way round, or as many frames or seconds as allowed
  camera_lost,
  storage_failed,  // a frame could not be stored
  build_pending,   // a capture waits to be built
  build_done,
  build_failed,  // or there was too little to build from
  rest,          // a result has been shown long enough
  shutdown,
};
inline constexpr std::array kEvents = {
    Event::press,         Event::release,      Event::long_press,  Event::stop,           Event::cancel,
    Event::sweep_refused, Event::sweep_full,   Event::camera_lost, Event::storage_failed, Event::build_pending,
    Event::build_done,    Event::build_failed, Event::rest,        Event::shutdown};
const char* name_of(Event event);

enum class Action : uint8_t {
  none,
  begin_sweep,
  end_sweep,      // store what is chosen, then build
  abandon_sweep,  // remove its frames: the person said so
  keep_sweep,     // store what is chosen and leave it for the next start
  start_build,    // of the capture that waits
  cancel_build,   // stop it and do not try again by oneself
  suspend_build,  // stop it and leave it for the next start
  say_busy,
};
const char* name_of(Action action);

struct Transition {
  Phase phase = Phase::idle;
  Action action = Action::none;
  friend bool operator==(const Transition&, const Transition&) = default;
};

Transition next(Phase phase, Event event, ButtonMode mode);

}  // namespace ldp
