// camera.toml on a card: every mistake by its line, and what the services are told.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "device/card/card_files.h"
#include "device/service/config/config.h"

namespace ldp {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

CardSettings settings_of(const std::string& text) {
  const CheckedCard checked = parse_card(text);
  for (const ConfigMistake& mistake : checked.mistakes) ADD_FAILURE() << mistake.line << ": " << mistake.text;
  return checked.settings;
}

std::string file_of(const CardSettings& settings, const std::string& path) {
  for (const CardFile& file : card_files(settings))
    if (file.path == path) return file.text;
  return "no such file";
}

Config service_of(const CardSettings& settings) {
  const CheckedConfig checked = parse_config(file_of(settings, "ldpd.toml"));
  EXPECT_TRUE(checked.mistakes.empty()) << checked.mistakes[0].text;
  return checked.config;
}

std::string default_text() {
  std::ostringstream text;
  text << std::ifstream(LDP_TEST_DATA "/../device/card/boot/camera.toml").rdbuf();
  return text.str();
}

const char* const kHome =
    "[network]\n"
    "kind = 'wifi'\n"
    "ssid = 'Café'\n"
    "password = 'a \"quoted\" one'\n"
    "country = 'DE'\n";

const std::string kKey = "ssh-ed25519 AAAAC3NzaC1lZDI1NTE5AAAAIKg0IbaCPqYEjPg6EDtfxodJEYBvVKS4pcamQkNYLegr me@home";

const std::string kEcdsaKey =
    "ecdsa-sha2-nistp256 "
    "AAAAE2VjZHNhLXNoYTItbmlzdHAyNTYAAAAIbmlzdHAyNTYAAABBBL8CfI0x3JblyQrFUaszVPJ93fVZC1VvKV/"
    "5bXlyJ1I9rxcHtDyMEbhPcFvq+9TtaDX1mnix4MXZ6+l0FYt/hxA=";

struct Mistake {
  int line;
  const char* text;
};

void expect_mistakes(const std::string& text, const std::vector<Mistake>& expected) {
  const CheckedCard checked = parse_card(text);
  ASSERT_EQ(checked.mistakes.size(), expected.size()) << card_report(checked, "1");
  for (size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(checked.mistakes[i].line, expected[i].line) << checked.mistakes[i].text;
    EXPECT_THAT(checked.mistakes[i].text, StartsWith(expected[i].text));
  }
}

TEST(Card, TheFileOnTheCardSaysWhatHoldsWithoutIt) {
  const std::string text = default_text();
  ASSERT_THAT(text, HasSubstr("[network]"));
  EXPECT_EQ(file_of(settings_of(text), "ldpd.toml"), file_of(CardSettings(), "ldpd.toml"));
  EXPECT_EQ(card_files(settings_of(text)).size(), card_files(CardSettings()).size());
  EXPECT_EQ(settings_of(text).name, CardSettings().name);
}

TEST(Card, ItsRemarksAreGoodSettingsOnceTheyAreMade) {
  std::string text = default_text();
  text.replace(text.find("'none'"), 6, "'wifi'");
  for (const char* key : {"#ssid", "#password", "#country"}) text.erase(text.find(key), 1);
  EXPECT_EQ(settings_of(text).ssid, "Home");
}

TEST(Card, AnEditorOfWindowsChangesNothing) {
  std::string text = "\xEF\xBB\xBF";
  for (const char c : default_text()) text += c == '\n' ? "\r\n" : std::string(1, c);
  EXPECT_EQ(file_of(settings_of(text), "ldpd.toml"), file_of(CardSettings(), "ldpd.toml"));
}

TEST(Card, EveryMistakeIsNamedWithItsLine) {
  expect_mistakes(
      "name = 'my camera'\n"
      "camera = 'webcam:0'\n"
      "arm_length_m = 65\n"
      "effort = 'most'\n"
      "gallery = 'on'\n"
      "colour = 'red'\n"
      "[button]\n"
      "line = 17.5\n"
      "mode = 'click'\n"
      "switch_off_s = 3\n"
      "[led]\n"
      "line = 'GPIO27?bias=up'\n"
      "[network]\n"
      "kind = 'wlan'\n"
      "ssid = ''\n"
      "password = 'short'\n"
      "country = 'de'\n"
      "[light]\n"
      "line = 3\n",
      {{1, "name: expected 1 to 63 letters"},
       {2, "camera: 'webcam:0'"},
       {3, "arm_length_m: expected metres"},
       {4, "effort: expected"},
       {5, "gallery: expected true or false"},
       {6, "unknown key 'colour'"},
       {8, "button.line: expected the GPIO line's number"},
       {9, "button.mode: expected 'hold' or 'toggle'"},
       {10, "button.switch_off_s: expected seconds"},
       {12, "led.line: expected the GPIO line's number"},
       {14, "network.kind: expected 'none', 'cable', 'wifi' or 'access-point'"},
       {15, "network.ssid: expected the network's name"},
       {16, "network.password: expected 8 to 63"},
       {17, "network.country: expected two capital letters"},
       {18, "unknown section 'light'"}});
}

TEST(Card, WhatEditorsAndHabitsMakeOfItIsToldInWords) {
  expect_mistakes("name = 'a'\nbutton = 17\n", {{2, "'button' is a section: write [button]"}});
  expect_mistakes(std::string(70000, '\n'), {{1, "the file is larger than 64 KiB"}});
  expect_mistakes(std::string("\xFF\xFEn\0a\0", 6), {{1, "the file is in UTF-16: save it again as UTF-8"}});
}

TEST(Card, ANetworkOfWhichHalfIsSaidIsAMistake) {
  expect_mistakes("[network]\nkind = 'wifi'\nssid = 'Home'\n",
                  {{2, "network.password is missing"}, {2, "network.country is missing"}});
  expect_mistakes("[network]\nssid = 'Home'\n", {{2, "network.ssid: is for network.kind = 'wifi'"}});
  expect_mistakes("[network]\nkind = 'cable'\n\npassword = 'long enough'\n", {{4, "network.password: is for"}});
}

TEST(Card, WhatIsNoPublicKeyIsAMistake) {
  const size_t end = kKey.find(" me");
  for (const std::string& wrong : {std::string("ssh-ed25519"), std::string("-----BEGIN OPENSSH PRIVATE KEY-----"),
                                   kKey + "\n" + kKey, "command=\"sh\" " + kKey,  // two; options
                                   std::string(kKey, 0, end - 5),                 // cut
                                   "ssh-rsa" + std::string(kKey, 11),             // of another kind than it says
                                   kEcdsaKey.substr(0, kEcdsaKey.size() - 1),     // cut within its padding
                                   kKey + std::string(1 << 13, 'e')})
    expect_mistakes("[network]\nkind = 'cable'\nssh_key = \"\"\"" + wrong + "\"\"\"\n",
                    {{3, "network.ssh_key: expected"}});
  expect_mistakes("[network]\nkind = 'cable'\nssh_key = 7\n", {{3, "network.ssh_key: expected"}});
  expect_mistakes("[network]\nssh_key = '" + kKey + "'\n", {{2, "network.ssh_key: there is no network"}});
}

TEST(Card, OneLineForButtonAndLightIsAMistake) {
  expect_mistakes("[led]\nline = 17\n", {{2, "button.line and led.line are both gpiochip0/17"}});
  expect_mistakes("[button]\nline = 5\n[led]\nline = 5\n", {{2, "button.line and led.line are both gpiochip0/5"}});
}

TEST(Card, WhatIsNotTomlIsToldWithItsLine) {
  expect_mistakes("name = 'panorama'\ncamera = v4l2:/dev/video0\n", {{2, ""}});
  expect_mistakes("name = 'a'\nname = 'b'\n", {{2, ""}});
  expect_mistakes("gallery = true\nname = 'panorama\n", {{2, ""}});
}

TEST(Card, WhatStandsAboveALineThatIsNoTomlHolds) {
  const CheckedCard checked = parse_card("\n[led]\nline = 5\n[network]\nssh_key = ssh-ed25519 AAAA\nkind = 'cable'\n");
  ASSERT_EQ(checked.mistakes.size(), 1U);
  EXPECT_EQ(checked.mistakes[0].line, 5);
  EXPECT_THAT(checked.mistakes[0].text, HasSubstr("a text stands in quotes, on one line"));
  EXPECT_EQ(checked.settings.led_line, "gpiochip0/5");
  EXPECT_EQ(checked.settings.network, Network::none);
}

TEST(Card, TheReportNamesLinesAndWhatToDo) {
  const std::string report = card_report(parse_card("\neffort = 'most'\n"), "1.2.3");
  EXPECT_THAT(report, HasSubstr("\nline 2: effort: expected"));
  EXPECT_THAT(report, HasSubstr("switch the camera on again"));
  EXPECT_THAT(report, HasSubstr("version 1.2.3"));
  EXPECT_EQ(card_report(parse_card(""), "1.2.3"),
            "camera.toml was read without a mistake.\nThe camera's programs are of version 1.2.3.\n");
  CheckedCard missing;
  missing.there = false;
  EXPECT_THAT(card_report(missing, "1"), HasSubstr("There is no camera.toml here"));
}

TEST(Card, TheServiceIsToldOfButtonLightArmAndEffort) {
  const Config config =
      service_of(settings_of("name = 'attic'\n"
                             "camera = 'libcamera:0'\n"
                             "arm_length_m = 1\n"
                             "effort = 'fast'\n"
                             "button.line = 'gpiochip0/5'\n"
                             "button.mode = 'toggle'\n"
                             "button.switch_off_s = 5\n"
                             "led.line = 4\n"));
  EXPECT_EQ(config.camera, "libcamera:0");
  EXPECT_EQ(config.button, "gpiod:gpiochip0/5?active_low=yes&bias=pull-up");
  EXPECT_EQ(config.mode, ButtonMode::toggle);
  EXPECT_EQ(config.status, (std::vector<std::string>{"console:", "led:gpiochip0/4"}));
  EXPECT_EQ(config.switch_off_s, 5);
  EXPECT_EQ(config.arm_length_m, 1);
  EXPECT_EQ(config.effort, "fast");
  EXPECT_EQ(config.device_name, "attic");
  EXPECT_EQ(config.output, Config().output);
}

TEST(Card, WithoutALightNoneIsTold) {
  EXPECT_EQ(service_of(settings_of("led.line = ''\n")).status, std::vector<std::string>{"console:"});
}

TEST(Card, NothingListensUnlessItIsAskedFor) {
  const auto paths = [](const CardSettings& settings) {
    std::vector<std::string> all;
    for (const CardFile& file : card_files(settings)) all.push_back(file.path.string());
    return all;
  };
  EXPECT_THAT(paths(CardSettings()), testing::ElementsAre("ldpd.toml", "hostname"));
  EXPECT_THAT(service_of(CardSettings()).status, Not(testing::Contains(StartsWith("lcm:"))));
  const CardSettings cable = settings_of("network.kind = 'cable'\n");
  EXPECT_THAT(paths(cable), testing::Contains("gallery"));
  EXPECT_THAT(service_of(cable).status, testing::Contains(StartsWith("lcm:udpm://239.255.76.67:7667?ttl=0")));
  const CardSettings closed = settings_of("gallery = false\nnetwork.kind = 'cable'\n");
  EXPECT_THAT(paths(closed), Not(testing::Contains("gallery")));
  EXPECT_THAT(service_of(closed).status, Not(testing::Contains(StartsWith("lcm:"))));
}

TEST(Card, OnlyTheHolderOfAKeyMayLogIn) {
  EXPECT_EQ(file_of(settings_of("network.kind = 'cable'\n"), "authorized_keys"), "no such file");
  EXPECT_EQ(file_of(settings_of("network.ssh_key = ''\n"), "authorized_keys"), "no such file");
  EXPECT_EQ(settings_of("network.kind = 'cable'\nnetwork.ssh_key = '" + kEcdsaKey + "'\n").ssh_key, kEcdsaKey);
  EXPECT_EQ(file_of(settings_of("network.kind = 'cable'\nnetwork.ssh_key = '" + kKey + "'\n"), "authorized_keys"),
            kKey + "\n");
}

TEST(Card, ANetworkByRadioIsWrittenForItsDaemons) {
  const CardSettings home = settings_of(kHome);
  const std::string radio = file_of(home, "wpa_supplicant.conf");
  EXPECT_THAT(radio, HasSubstr("country=DE\n"));
  EXPECT_THAT(radio, HasSubstr("  ssid=436166c3a9\n"));
  EXPECT_THAT(radio, HasSubstr("  psk=\"a \"quoted\" one\"\n"));
  EXPECT_THAT(radio, Not(HasSubstr("mode=2")));
  EXPECT_THAT(file_of(home, "network/20-camera.network"), HasSubstr("DHCP=yes"));
  for (const CardFile& file : card_files(home)) EXPECT_EQ(file.secret, file.path == "wpa_supplicant.conf");
}

TEST(Card, ItsOwnNetworkGivesOutAddresses) {
  std::string text = kHome;
  text.replace(text.find("wifi"), 4, "access-point");
  const CardSettings own = settings_of(text);
  EXPECT_THAT(file_of(own, "wpa_supplicant.conf"), HasSubstr("mode=2\n  frequency=2437\n"));
  EXPECT_THAT(file_of(own, "network/20-camera.network"), HasSubstr("DHCPServer=yes"));
  EXPECT_THAT(file_of(own, "network/20-camera.network"), Not(HasSubstr("DHCP=yes")));
}

}  // namespace
}  // namespace ldp
