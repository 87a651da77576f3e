#include "device/service/session_state.h"

namespace ldp {
namespace {

Transition when_idle(Event event) {
  switch (event) {
    case Event::press:
      return {Phase::capturing, Action::begin_sweep};
    case Event::build_pending:
      return {Phase::building, Action::start_build};
    default:
      return {Phase::idle, Action::none};
  }
}

Transition when_capturing(Event event, ButtonMode mode) {
  constexpr Transition kStay = {Phase::capturing, Action::none};
  constexpr Transition kEnd = {Phase::building, Action::end_sweep};
  constexpr Transition kAbandon = {Phase::idle, Action::abandon_sweep};
  switch (event) {
    case Event::press:
      return mode == ButtonMode::toggle ? kEnd : kStay;
    case Event::release:
      return mode == ButtonMode::hold ? kEnd : kStay;
    case Event::long_press:
      return mode == ButtonMode::toggle ? kAbandon : kStay;
    case Event::cancel:
      return kAbandon;
    case Event::sweep_refused:
      return {Phase::failed, Action::none};
    case Event::stop:
    case Event::sweep_full:
    case Event::camera_lost:
    case Event::storage_failed:
      return kEnd;
    case Event::shutdown:
      return {Phase::idle, Action::keep_sweep};
    default:
      return kStay;
  }
}

Transition when_building(Event event, ButtonMode mode) {
  constexpr Transition kStay = {Phase::building, Action::none};
  constexpr Transition kCancel = {Phase::idle, Action::cancel_build};
  switch (event) {
    case Event::press:
      return {Phase::building, Action::say_busy};
    case Event::long_press:
      return mode == ButtonMode::toggle ? kCancel : kStay;
    case Event::cancel:
      return kCancel;
    case Event::build_done:
      return {Phase::done, Action::none};
    case Event::build_failed:
      return {Phase::failed, Action::none};
    case Event::shutdown:
      return {Phase::idle, Action::suspend_build};
    default:
      return kStay;
  }
}

Transition when_over(Phase phase, Event event) {
  switch (event) {
    case Event::press:
      return {Phase::capturing, Action::begin_sweep};
    case Event::build_pending:
      return {Phase::building, Action::start_build};
    case Event::cancel:
    case Event::rest:
    case Event::shutdown:
      return {Phase::idle, Action::none};
    default:
      return {phase, Action::none};
  }
}

}  // namespace

Transition next(Phase phase, Event event, ButtonMode mode) {
  switch (phase) {
    case Phase::idle:
      return when_idle(event);
    case Phase::capturing:
      return when_capturing(event, mode);
    case Phase::building:
      return when_building(event, mode);
    case Phase::done:
    case Phase::failed:
      return when_over(phase, event);
  }
  return {phase, Action::none};
}

const char* name_of(Event event) {
  switch (event) {
    case Event::press:
      return "press";
    case Event::release:
      return "release";
    case Event::long_press:
      return "long press";
    case Event::stop:
      return "stop";
    case Event::cancel:
      return "cancel";
    case Event::sweep_refused:
      return "sweep refused";
    case Event::sweep_full:
      return "sweep full";
    case Event::camera_lost:
      return "camera lost";
    case Event::storage_failed:
      return "storage failed";
    case Event::build_pending:
      return "build pending";
    case Event::build_done:
      return "build done";
    case Event::build_failed:
      return "build failed";
    case Event::rest:
      return "rest";
    case Event::shutdown:
      return "shutdown";
  }
  return "unknown";
}

const char* name_of(Action action) {
  switch (action) {
    case Action::none:
      return "none";
    case Action::begin_sweep:
      return "begin sweep";
    case Action::end_sweep:
      return "end sweep";
    case Action::abandon_sweep:
      return "abandon sweep";
    case Action::keep_sweep:
      return "keep sweep";
    case Action::start_build:
      return "start build";
    case Action::cancel_build:
      return "cancel build";
    case Action::suspend_build:
      return "suspend build";
    case Action::say_busy:
      return "say busy";
  }
  return "unknown";
}

}  // namespace ldp
