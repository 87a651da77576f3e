// What core says, in the words of the command line.
#include "device/tool/switches.h"

#include <gtest/gtest.h>

namespace ldp {
namespace {

TEST(Switches, AFieldIsNamedByItsSwitch) {
  EXPECT_EQ(with_switches("far_depth 2: is nearer than 3: give a larger one, or near_depth too"),
            "--far 2: is nearer than 3: give a larger one, or --near too");
  EXPECT_EQ(with_switches("1 MiB are allowed (memory_bytes)"), "1 MiB are allowed (--memory)");
}

TEST(Switches, AdviceGetsItsSwitchOnce) {
  EXPECT_EQ(with_switches("more overlap, or give the field of view"),
            "more overlap, or give the field of view (--fov)");
  EXPECT_EQ(with_switches("give the field of view (--fov)"), "give the field of view (--fov)");
}

TEST(Switches, TurnsAreGivenByTheirSwitch) {
  EXPECT_EQ(with_switches("a turn by 90 or by 270 degrees shows things upright, where it stood upright, no turn"),
            "--turn 90 or --turn 270 shows things upright, where it stood upright, no --turn");
  EXPECT_EQ(with_switches("add a turn by 90 or by 270 degrees (where it stood upright, leave the turn out)"),
            "add --turn 90 or --turn 270 (where it stood upright, leave --turn out)");
}

TEST(Switches, WhatAShellWouldTakeApartIsQuoted) {
  EXPECT_EQ(in_shell({"photos/a-1.jpg", "my photos", "it's", "", "*.jpg"}),
            "photos/a-1.jpg 'my photos' 'it'\\''s' '' '*.jpg'");
}

TEST(Switches, OtherWordsStay) {
  for (const char* text :
       {"a field of view of 60 degrees", "/data/near_depth/a.jpg: ends early", "near_depth.jpg", "a_near_depth"})
    EXPECT_EQ(with_switches(text), text);
  EXPECT_EQ(with_switches(std::vector<std::string>{"a", "near_depth"}), (std::vector<std::string>{"a", "--near"}));
}

}  // namespace
}  // namespace ldp
