#include "device/service/config/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace ldp {
namespace {

using testing::HasSubstr;

TEST(Config, WhatIsPrintedReadsBackTheSame) {
  Config config;
  config.camera = "v4l2:/dev/video2?width=640";
  config.status = {"console:", "lcm:memq://"};
  config.mode = ButtonMode::toggle;
  config.overlap = 0.6;
  config.memory_limit_mib = 300;
  config.follow = false;
  config.options = {"--layers", "2"};
  const std::string text = config_text(config);
  const CheckedConfig checked = parse_config(text);
  EXPECT_TRUE(checked.mistakes.empty()) << checked.mistakes[0].text;
  EXPECT_EQ(config_text(checked.config), text);
  EXPECT_FALSE(checked.config.follow);
}

TEST(Config, BothEndsOfEveryRangeReadBackTheSame) {
  const std::pair<const char*, std::vector<const char*>> ends[] = {{"switch_off_seconds", {"0", "4", "60"}},
                                                                   {"sweep.overlap", {"0.3", "0.95", "0.7654321"}},
                                                                   {"sweep.max_frames", {"4", "1000"}},
                                                                   {"sweep.max_seconds", {"1", "3600", "1234.567"}},
                                                                   {"sweep.min_frames", {"3", "80"}},
                                                                   {"sweep.arm_length_m", {"0.05", "10"}},
                                                                   {"sweep.fov_degrees", {"0", "5", "150"}},
                                                                   {"sweep.lost_after_seconds", {"0.2", "60"}},
                                                                   {"sweep.reserve_mib", {"0", "1000000"}},
                                                                   {"build.threads", {"0", "256"}},
                                                                   {"build.memory_limit_mib", {"0", "64", "1000000"}},
                                                                   {"build.niceness", {"0", "19"}}};
  for (const auto& [key, values] : ends) {
    for (const char* const value : values) {
      const CheckedConfig first = parse_config(std::string(key) + " = " + value);
      EXPECT_TRUE(first.mistakes.empty()) << key << " " << value;
      const std::string text = config_text(first.config);
      const std::string name = std::string(key).substr(std::string(key).find('.') + 1);
      EXPECT_THAT(text, HasSubstr("\n" + name + " = " + value + "\n"));
      const CheckedConfig again = parse_config(text);
      EXPECT_TRUE(again.mistakes.empty()) << key << " " << value;
      EXPECT_EQ(config_text(again.config), text);
    }
  }
  EXPECT_THAT(parse_config("sweep.reserve_mib = -1").mistakes.at(0).text, testing::EndsWith("from 0 to 1000000"));
}

TEST(Config, TheFileThatIsInstalledSaysWhatHoldsWithoutIt) {
  std::ostringstream installed;
  installed << std::ifstream(LDP_TEST_DATA "/../device/systemd/ldpd.toml").rdbuf();
  EXPECT_THAT(installed.str(), testing::EndsWith("\n" + config_text(Config())));
}

TEST(Config, TheDefaultsAreGood) { EXPECT_TRUE(parse_config(config_text(Config())).mistakes.empty()); }

TEST(Config, EveryMistakeIsNamedWithItsLine) {
  const CheckedConfig checked = parse_config(
      "camera = \"webcam:0\"\n"
      "buton = \"keyboard:\"\n"
      "status = \"console:\"\n"
      "switch_off_seconds = 3\n"
      "[sweep]\n"
      "overlap = 2.0\n"
      "mode = \"press\"\n"
      "max_frames = 3.5\n"
      "[build]\n"
      "follow = 1\n"
      "options = [1]\n"
      "[network]\n"
      "port = 80\n");
  ASSERT_EQ(checked.mistakes.size(), 10U);
  const std::pair<int, const char*> expected[] = {
      {1, "webcam"},      {2, "buton"},      {3, "list"},  {4, "0 or a number from 4 to 60"},
      {6, "0.3 to 0.95"}, {7, "\"toggle\""}, {8, "whole"}, {10, "true or false"},
      {11, "options"},    {12, "network"}};
  for (size_t i = 0; i < std::size(expected); ++i) {
    EXPECT_EQ(checked.mistakes[i].line, expected[i].first) << checked.mistakes[i].text;
    EXPECT_THAT(checked.mistakes[i].text, HasSubstr(expected[i].second));
  }
}

TEST(Config, WhatUrlsOutputAndProgramSayWronglyIsNamedWithItsLine) {
  const CheckedConfig checked = parse_config(
      "camera = 'scene:moon'\n"
      "button = 'gpiod:17'\n"
      "status = ['console:',\n"
      " 'lcm:upd://239.255.76.67:7667',\n"
      " 'lcm:udpm://10.0.0.1:7667',\n"
      " 'led:name=a?bias=up']\n"
      "output = ''\n"
      "[build]\n"
      "program = '/nowhere/ldp'\n"
      "[sweep]\n"
      "min_frames = 9\n"
      "max_frames = 5\n");
  const std::pair<int, const char*> expected[] = {
      {1, "camera: 'scene:moon': no scene of that name; known: "},
      {2, "button: 'gpiod:17': expected CHIP/LINE"},
      {4, "status: 'lcm:upd://239.255.76.67:7667': LCM has no provider 'upd'"},
      {5, "status: 'lcm:udpm://10.0.0.1:7667': '10.0.0.1' is no multicast address"},
      {6, "status: 'led:name=a?bias=up': bias is 'up'"},
      {7, "output: is empty: give the folder"},
      {9, "build.program: there is no '/nowhere/ldp': give the whole path of ldp"},
      {12, "sweep.max_frames is smaller"}};
  ASSERT_EQ(checked.mistakes.size(), std::size(expected));
  for (size_t i = 0; i < std::size(expected); ++i) {
    EXPECT_EQ(checked.mistakes[i].line, expected[i].first) << checked.mistakes[i].text;
    EXPECT_THAT(checked.mistakes[i].text, testing::StartsWith(expected[i].second));
  }
  EXPECT_THAT(parse_config("output = '/dev/null'").mistakes.at(0).text, HasSubstr("'/dev/null' is no folder"));
  EXPECT_THAT(parse_config("build.program = '/dev/null'").mistakes.at(0).text, HasSubstr("cannot be run"));
  EXPECT_THAT(parse_config("build.program = '/'").mistakes.at(0).text, HasSubstr("cannot be run"));
  EXPECT_TRUE(parse_config("build.program = '/bin/sh'\noutput = '/nowhere/yet'").mistakes.empty());
}

TEST(Config, ABuildsEffortIsOneOfThree) {
  EXPECT_EQ(parse_config("").config.effort, "standard");
  for (const char* const known : {"fast", "standard", "best"}) {
    const CheckedConfig checked = parse_config(std::string("[build]\neffort = '") + known + "'");
    EXPECT_TRUE(checked.mistakes.empty());
    EXPECT_EQ(checked.config.effort, known);
  }
  const CheckedConfig unknown = parse_config("[build]\neffort = 'medium'");
  ASSERT_EQ(unknown.mistakes.size(), 1U);
  EXPECT_EQ(unknown.mistakes[0].line, 2);
  EXPECT_THAT(unknown.mistakes[0].text, HasSubstr("build.effort: expected \"fast\", \"standard\" or \"best\""));
}

TEST(Config, WhatWasNotReadIsNotComparedByItsDefault) {
  const CheckedConfig frames = parse_config("[sweep]\nmax_frames = 'many'\nmin_frames = 500\n");
  ASSERT_EQ(frames.mistakes.size(), 1U) << frames.mistakes[1].text;
  EXPECT_EQ(frames.mistakes[0].line, 2);
  const CheckedConfig button = parse_config("button = 'keyboard:?bias=up'\n[sweep]\nmode = 'hold'\n");
  ASSERT_EQ(button.mistakes.size(), 1U) << button.mistakes[1].text;
  EXPECT_EQ(button.mistakes[0].line, 1);
  const CheckedConfig left_out = parse_config("[sweep]\nmin_frames = 500\n");
  ASSERT_EQ(left_out.mistakes.size(), 1U);
  EXPECT_THAT(left_out.mistakes[0].text, HasSubstr("sweep.max_frames is smaller"));
}

TEST(Config, AMemoryLimitLeavesTheBuildEnoughToStart) {
  for (const char* const good : {"0", "64", "512"}) {
    EXPECT_TRUE(parse_config(std::string("[build]\nmemory_limit_mib = ") + good).mistakes.empty()) << good;
  }
  for (const char* const bad : {"1", "63", "-1"}) {
    const CheckedConfig checked = parse_config(std::string("[build]\nmemory_limit_mib = ") + bad);
    ASSERT_EQ(checked.mistakes.size(), 1U) << bad;
    EXPECT_EQ(checked.mistakes[0].line, 2);
    EXPECT_THAT(checked.mistakes[0].text, HasSubstr("build.memory_limit_mib: expected 0 or a whole number from 64 to"));
  }
}

TEST(Config, AFieldOfViewIsOneThatABuildTakesOrUnknown) {
  for (const char* const good : {"0", "5", "62.2", "150"})
    EXPECT_TRUE(parse_config(std::string("[sweep]\nfov_degrees = ") + good).mistakes.empty()) << good;
  for (const char* const bad : {"3", "4.9", "151", "170", "-1"}) {
    const CheckedConfig checked = parse_config(std::string("[sweep]\nfov_degrees = ") + bad);
    ASSERT_EQ(checked.mistakes.size(), 1U) << bad;
    EXPECT_EQ(checked.mistakes[0].text, "sweep.fov_degrees: expected 0 or a number from 5 to 150");
  }
}

TEST(Config, AMissingFolderOrScriptIsNamedWithItsLineWhereItMustExist) {
  const std::string missing = "output = '/tmp'\ncamera='folder:/nowhere?fps=5'\nbutton='script:/nowhere/turn'\n";
  EXPECT_TRUE(parse_config(missing).mistakes.empty()) << "a service waits for them";
  const CheckedConfig checked = parse_config(missing, Inputs::must_exist);
  ASSERT_EQ(checked.mistakes.size(), 2U);
  EXPECT_EQ(checked.mistakes[0].line, 2);
  EXPECT_EQ(checked.mistakes[0].text, "camera: 'folder:/nowhere?fps=5': there is no folder '/nowhere': check its name");
  EXPECT_EQ(checked.mistakes[1].line, 3);
  EXPECT_EQ(checked.mistakes[1].text,
            "button: 'script:/nowhere/turn': there is no file '/nowhere/turn': check its name");
  const auto mistakes = [](const std::string& text) { return parse_config(text, Inputs::must_exist).mistakes.size(); };
  EXPECT_EQ(mistakes("camera='folder:/dev/null'\nbutton='script:/dev'"), 2U);
  EXPECT_EQ(mistakes("camera='folder:/dev'\nbutton='script:/dev/null'"), 0U);
  EXPECT_EQ(mistakes("camera='folder:/nowhere?fsp=5'\n"), 1U) << "one value, one mistake";
  EXPECT_EQ(mistakes("camera='v4l2:/dev/nowhere'\nbutton='gpiod:nowhere/1'"), 0U) << "devices come and go";
  EXPECT_EQ(wrong_values(checked.config).size(), 0U);
  EXPECT_EQ(wrong_values(checked.config, Inputs::must_exist).size(), 2U);
}

TEST(Config, AModeThatNobodyGaveIsWhatTheButtonCan) {
  const auto mode = [](const std::string& text) {
    const CheckedConfig checked = parse_config(text);
    EXPECT_TRUE(checked.mistakes.empty() && wrong_values(checked.config).empty()) << text;
    return mode_of(checked.config);
  };
  EXPECT_EQ(mode(""), ButtonMode::hold);
  EXPECT_EQ(mode("button = \"keyboard:\"\n"), ButtonMode::toggle);
  EXPECT_EQ(mode("button = \"script:a\"\nsweep.mode = \"toggle\"\n"), ButtonMode::toggle);
  const CheckedConfig held = parse_config("[sweep]\nmode = \"hold\"\noverlap = 9\n[build]\n");
  EXPECT_EQ(held.mistakes.size(), 1U);
  const CheckedConfig keyboard = parse_config("button = \"keyboard:\"\n[sweep]\nmode = \"hold\"\noverlap = 9\n");
  ASSERT_EQ(keyboard.mistakes.size(), 2U);
  EXPECT_EQ(keyboard.mistakes[0].line, 3);
  EXPECT_THAT(keyboard.mistakes[0].text, HasSubstr("sweep.mode: a terminal"));
  Config mixed;
  mixed.button = "keyboard:", mixed.mode = ButtonMode::hold;
  ASSERT_EQ(wrong_values(mixed).size(), 1U);
  EXPECT_THAT(wrong_values(mixed)[0].text, HasSubstr("mode: a terminal"));
}

TEST(Config, TextThatIsNotTomlIsNamedWithItsLine) {
  const CheckedConfig checked = parse_config("camera = \"folder:x\"\noverlap = = 3\n");
  ASSERT_EQ(checked.mistakes.size(), 1U);
  EXPECT_EQ(checked.mistakes[0].line, 2);
  for (const char* text : {"[=]", "[[.]]", "[", "[\x01]", "schl\u00fcssel = 1", "= \u0435"})
    EXPECT_EQ(parse_config(text).mistakes.size(), 1U) << text;
}

TEST(Config, AMissingFileIsAMistakeAndSoIsAFolder) {
  EXPECT_EQ(read_config("/nowhere/ldpd.toml").mistakes.size(), 1U);
  EXPECT_EQ(read_config("/").mistakes.size(), 1U);
}

TEST(Config, AnEmptyFileLeavesEverythingAsItIs) { EXPECT_TRUE(read_config("/dev/null").mistakes.empty()); }

}  // namespace
}  // namespace ldp
