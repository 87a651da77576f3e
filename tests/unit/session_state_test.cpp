#include "device/service/session_state.h"

#include <gtest/gtest.h>

#include <map>
#include <vector>

namespace ldp {
namespace {

using A = Action;
using E = Event;
using P = Phase;

constexpr P kPhases[] = {P::idle, P::capturing, P::building, P::done, P::failed};

// One row per event, in the order of kEvents; one entry per phase, in the order of kPhases.
using Table = std::map<E, std::vector<Transition>>;

Table hold_table() {
  const Transition idle{P::idle, A::none}, capturing{P::capturing, A::none}, building{P::building, A::none};
  const Transition done{P::done, A::none}, failed{P::failed, A::none};
  const Transition begin{P::capturing, A::begin_sweep}, end{P::building, A::end_sweep},
      start{P::building, A::start_build};
  return {
      {E::press, {begin, capturing, {P::building, A::say_busy}, begin, begin}},
      {E::release, {idle, end, building, done, failed}},
      {E::long_press, {idle, capturing, building, done, failed}},
      {E::stop, {idle, end, building, done, failed}},
      {E::cancel, {idle, {P::idle, A::abandon_sweep}, {P::idle, A::cancel_build}, idle, idle}},
      {E::sweep_refused, {idle, failed, building, done, failed}},
      {E::sweep_full, {idle, end, building, done, failed}},
      {E::camera_lost, {idle, end, building, done, failed}},
      {E::storage_failed, {idle, end, building, done, failed}},
      {E::build_pending, {start, capturing, building, start, start}},
      {E::build_done, {idle, capturing, done, done, failed}},
      {E::build_failed, {idle, capturing, failed, done, failed}},
      {E::rest, {idle, capturing, building, idle, idle}},
      {E::shutdown, {idle, {P::idle, A::keep_sweep}, {P::idle, A::suspend_build}, idle, idle}},
  };
}

// Where toggle differs from hold.
Table toggle_table() {
  Table table = hold_table();
  table[E::press][1] = {P::building, A::end_sweep};
  table[E::release][1] = {P::capturing, A::none};
  table[E::long_press][1] = {P::idle, A::abandon_sweep};
  table[E::long_press][2] = {P::idle, A::cancel_build};
  return table;
}

void expect_table(const Table& table, ButtonMode mode) {
  ASSERT_EQ(table.size(), kEvents.size());
  for (const E event : kEvents) {
    for (size_t i = 0; i < std::size(kPhases); ++i) {
      const Transition is = next(kPhases[i], event, mode);
      const Transition wanted = table.at(event)[i];
      EXPECT_EQ(is, wanted) << name_of(kPhases[i]) << " + " << name_of(event) << " gives " << name_of(is.phase) << ", "
                            << name_of(is.action);
    }
  }
}

TEST(SessionState, EveryPairOfStateAndEventDoesWhatTheTableSaysInHoldMode) {
  expect_table(hold_table(), ButtonMode::hold);
}

TEST(SessionState, EveryPairOfStateAndEventDoesWhatTheTableSaysInToggleMode) {
  expect_table(toggle_table(), ButtonMode::toggle);
}

TEST(SessionState, NothingStartsASweepWhileAnotherSweepOrABuildIsInWork) {
  for (const ButtonMode mode : {ButtonMode::hold, ButtonMode::toggle}) {
    for (const E event : kEvents) {
      EXPECT_NE(next(P::capturing, event, mode).action, A::begin_sweep);
      EXPECT_NE(next(P::building, event, mode).action, A::begin_sweep);
    }
  }
}

TEST(SessionState, LeavingCapturingAlwaysSaysWhatBecomesOfTheFrames) {
  for (const ButtonMode mode : {ButtonMode::hold, ButtonMode::toggle}) {
    for (const E event : kEvents) {
      const Transition transition = next(P::capturing, event, mode);
      if (transition.phase == P::capturing || event == E::sweep_refused) continue;
      const bool decided = transition.action == A::end_sweep || transition.action == A::abandon_sweep ||
                           transition.action == A::keep_sweep;
      EXPECT_TRUE(decided) << name_of(event);
    }
  }
}

TEST(SessionState, ShutdownEndsIdleFromEverywhere) {
  for (const P phase : kPhases) {
    for (const ButtonMode mode : {ButtonMode::hold, ButtonMode::toggle}) {
      EXPECT_EQ(next(phase, E::shutdown, mode).phase, P::idle);
    }
  }
}

TEST(SessionState, APressAndAReleaseMakeOneSweepInHoldMode) {
  Phase phase = P::idle;
  std::vector<A> actions;
  for (const E event : {E::press, E::release, E::build_done, E::press, E::release}) {
    const Transition transition = next(phase, event, ButtonMode::hold);
    phase = transition.phase;
    if (transition.action != A::none) actions.push_back(transition.action);
  }
  EXPECT_EQ(actions, (std::vector<A>{A::begin_sweep, A::end_sweep, A::begin_sweep, A::end_sweep}));
}

}  // namespace
}  // namespace ldp
