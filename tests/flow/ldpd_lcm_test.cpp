// The service over LCM: its messages, recorded and replayed, commands, noise on every channel, and `ldp watch`.
#include "tests/flow/ldpd.h"

#include <lcm/lcm-cpp.hpp>
#include <random>

#include "device/backends/open.h"
#include "drivers/interface/status.h"
#include "tests/private_network.h"

namespace ldp {
namespace {

TEST_F(LdpdTest, TheMessagesOfASweepPassOverLcm) {
  NEEDS_MULTICAST();
  const std::string url = "lcm:" + private_network();
  const auto listener = open_status_listener(url);
  Process service(command({"--once", "--status", url}), room_ / "said");
  EXPECT_EQ(service.wait().status, 0);
  std::vector<int> kinds(4, 0);
  while (const auto heard = listener->read()) ++kinds[heard->message.index()];
  EXPECT_GT(kinds[0], 3);
  EXPECT_EQ(kinds[1], 1);
  EXPECT_GT(kinds[2], 0);
  EXPECT_EQ(kinds[3], 1);
}

TEST_F(LdpdTest, ARecordedSessionReplaysThroughLdpWatch) {
  NEEDS_MULTICAST();
  if (std::system("command -v lcm-logger >/dev/null") != 0) GTEST_SKIP() << "no lcm-logger here";
  const std::string url = private_network();
  const auto listener = open_status_listener("lcm:" + url);
  const fs::path log = room_ / "session.log";
  {
    Process logger({"lcm-logger", "--lcm-url=" + url, "--flush-interval=10", log.string()}, room_ / "logger");
    // Its file appears when it has seen something.
    for (int i = 0; i < 200 && (!fs::exists(log) || fs::file_size(log) == 0); ++i) {
      listener->send(Command::release);
      std::this_thread::sleep_for(milliseconds(20));
    }
    ASSERT_TRUE(fs::exists(log) && fs::file_size(log) > 0) << text_of(room_ / "logger");
    Process service(command({"--once", "--status", "lcm:" + url}), room_ / "said");
    EXPECT_EQ(service.wait().status, 0);
    std::this_thread::sleep_for(milliseconds(100));
    logger.stop(SIGINT);
  }
  std::vector<std::string> heard;
  while (const auto message = listener->read())
    heard.push_back("\"monotonic_ns\":" + std::to_string(message->monotonic_ns));
  const std::string watch = std::string(LDP_DEVICE_PROGRAM) + " watch --json --status 'lcm:file://" + log.string() +
                            "?speed=0' > " + (room_ / "replayed").string();
  EXPECT_EQ(Process({"bash", "-c", watch}, room_ / "watch").wait().status, 0) << text_of(room_ / "watch");
  const std::string replayed = text_of(room_ / "replayed");
  EXPECT_GT(heard.size(), 5U);
  for (const std::string& message : heard) EXPECT_THAT(replayed, HasSubstr(message));
  EXPECT_EQ(static_cast<size_t>(std::count(replayed.begin(), replayed.end(), '\n')), heard.size());
  for (const char* const type : {"status", "progress", "guidance", "result"}) {
    EXPECT_THAT(replayed, HasSubstr("\"type\":\"" + std::string(type) + "\""));
  }
}

TEST_F(LdpdTest, LdpWatchTellsASpeedOnceThereIsOne) {
  NEEDS_MULTICAST();
  const std::string url = private_network();
  const auto publisher = open_status("lcm:" + url);
  const fs::path printed = room_ / "printed";
  Process watching(
      {"bash", "-c",
       std::string("exec ") + LDP_DEVICE_PROGRAM + " watch --status 'lcm:" + url + "' --count 4 > " + printed.string()},
      room_ / "watch");
  for (int i = 0; i < 500 && watching.runs(); ++i) {
    publisher->publish(Guidance{.frames_chosen = 1});
    publisher->publish(Guidance{Advice::slower, 1, 0.5, 0, 0.4, 9});
    std::this_thread::sleep_for(milliseconds(10));
  }
  ASSERT_FALSE(watching.runs()) << text_of(printed);
  EXPECT_THAT(text_of(printed), HasSubstr("guidance  keep going: 0 degrees, 1 frame\n"));
  EXPECT_THAT(text_of(printed), HasSubstr("guidance  slower: 57 degrees, 29 degrees/s, 9 frames\n"));
}

// One message a line, as many as were asked for; a log that is at its end before that ends it, too.
TEST_F(LdpdTest, LdpWatchEndsAfterAsManyMessagesAsWereAskedFor) {
  NEEDS_MULTICAST();
  const std::string url = private_network();
  const auto publisher = open_status("lcm:" + url);
  for (const int count : {1, 3}) {
    const fs::path printed = room_ / ("printed_" + std::to_string(count));
    const std::string watch = std::string("exec ") + LDP_DEVICE_PROGRAM + " watch --status 'lcm:" + url + "' --count " +
                              std::to_string(count) + " > " + printed.string();
    Process watching({"bash", "-c", watch}, room_ / "watch");
    Status status;
    for (int i = 0; i < 500 && watching.runs(); ++i) {
      status.text = "message " + std::to_string(i);
      publisher->publish(status);
      std::this_thread::sleep_for(milliseconds(10));
    }
    ASSERT_FALSE(watching.runs()) << text_of(printed);
    EXPECT_EQ(watching.wait().status, 0);
    const std::string lines = text_of(printed);
    EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), count) << lines;
    EXPECT_THAT(lines, HasSubstr("message "));
  }
}

// Noise on every channel, commands among them: the service and who watches it count it and go on as if nothing had
// been.
TEST_F(LdpdTest, AHundredThousandRandomDatagramsOnEveryChannelChangeNothingButACounter) {
  NEEDS_MULTICAST();
  const std::string url = private_network();
  lcm::LCM stranger(url);
  ASSERT_TRUE(stranger.good());
  script("wait 1");
  Process service(command({"--status", "lcm:" + url, "--status", "console:"}), room_ / "said");
  ASSERT_TRUE(service.says("ready"));
  const auto watcher = open_status_listener("lcm:" + url);
  const auto drain = [&] {
    while (watcher->read()) {
    }
  };
  std::mt19937 random(3);
  std::array<uint8_t, 256> noise{};
  for (int i = 0; i < 100'000; ++i) {
    const size_t at = random() % noise.size();
    noise[at] = static_cast<uint8_t>(random());
    for (const char* const channel : {"LDP_COMMAND", "LDP_STATUS", "LDP_PROGRESS", "LDP_GUIDANCE", "LDP_RESULT"}) {
      stranger.publish(channel, noise.data(), static_cast<unsigned>(random() % noise.size()));
    }
    // LCM keeps 30 messages that were not looked at, and drops the rest.
    if (i % 25 != 24) continue;
    const int64_t all = 4 * (i + 1);
    for (int waits = 0; waits < 2 && watcher->ignored() < all; ++waits) {
      std::this_thread::sleep_for(std::chrono::microseconds(200));
      drain();
    }
  }
  RecordProperty("ignored_by_watcher", std::to_string(watcher->ignored()));
  ASSERT_TRUE(service.says("ignored so far")) << text_of(room_ / "said");
  EXPECT_THAT(text_of(room_ / "said"), Not(HasSubstr("capturing")));
  EXPECT_FALSE(fs::exists(capture()));
  const auto person = open_status_listener("lcm:" + url);
  for (int i = 0; i < 100 && !service.says("capturing", 0); ++i) {
    person->send(Command::press);
    std::this_thread::sleep_for(milliseconds(20));
  }
  EXPECT_TRUE(service.says("capturing", 5));
  const std::string said = service.stop(SIGTERM).said;
  const int ignored = std::atoi(said.c_str() + said.rfind("ignored so far: ") + 16);
  RecordProperty("ignored_by_service", ignored);
  EXPECT_GE(ignored, 10'000);  // of the 100,000; a busy machine drops some on their way
  EXPECT_GE(watcher->ignored(), 40'000);
}

// Who sends a press sends no release: the gallery's Start, `ldp watch --send press`.
TEST_F(LdpdTest, ASweepIsBegunAndEndedByCommandInEitherMode) {
  NEEDS_MULTICAST();
  const std::string url = "lcm:" + private_network();
  script("wait 1");
  for (const char* const mode : {"hold", "toggle"}) {
    fs::remove_all(room_ / "out");
    configure("mode = \"" + std::string(mode) + "\"\nmin_frames = 3\n");
    Process service(command({"--status", url, "--status", "console:"}, "&hold=yes"), room_ / mode);
    ASSERT_TRUE(service.says("ready")) << text_of(room_ / mode);
    const auto person = open_status_listener(url);
    person->send(Command::press);
    ASSERT_TRUE(service.says("capturing")) << text_of(room_ / mode);
    ASSERT_TRUE(service.says("stored: 4")) << text_of(room_ / mode);
    person->send(Command::stop);
    EXPECT_TRUE(service.says("sweep_000001.ldp is ready")) << text_of(room_ / mode);
    EXPECT_THAT(text_of(capture() / "capture.json"), HasSubstr("ended by command"));
    EXPECT_EQ(service.stop(SIGTERM).status, 0);
  }
}

TEST_F(LdpdTest, APressByCommandIsNoButtonThatIsHeld) {
  NEEDS_MULTICAST();
  const std::string url = "lcm:" + private_network();
  fs::remove_all(room_ / "frames");
  make_frames(1, 200, 150);
  script("wait 1");
  for (const char* const mode : {"hold", "toggle"}) {
    configure_switch_off(mode);
    Process service(command({"--status", url, "--status", "console:"}, "&hold=yes"), room_ / mode);
    ASSERT_TRUE(service.says("ready")) << text_of(room_ / mode);
    const auto person = open_status_listener(url);
    person->send(Command::press);
    ASSERT_TRUE(service.says("capturing")) << text_of(room_ / mode);
    ASSERT_FALSE(service.ends_within(5)) << text_of(room_ / mode);
    EXPECT_THAT(text_of(room_ / mode), Not(HasSubstr("cancelled")));
    person->send(Command::stop);
    EXPECT_TRUE(service.says("the sweep was ended by command")) << text_of(room_ / mode);
    EXPECT_EQ(service.stop(SIGTERM).status, 0);
  }
}

}  // namespace
}  // namespace ldp
