// Messages over LCM inside the process (memq), and what happens to datagrams of strangers.
#include <gtest/gtest.h>
#include <poll.h>

#include <cstdlib>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <random>

#include "device/backends/open.h"
#include "drivers/interface/status.h"
#include "drivers/lcm_messages.h"
#include "tests/private_network.h"

namespace ldp {
namespace {

constexpr const char* kUrl = "lcm:memq://";

TEST(Lcm, EveryKindOfMessageArrivesAsItWasSent) {
  const auto channel = open_status(kUrl);
  const auto listener = open_status_listener(kUrl);
  channel->publish(Status{Phase::capturing, "sweep_000001", "turn slowly", 7, 12});
  channel->publish(Progress{"sweep_000001", "poses", 0.25});
  channel->publish(Guidance{Advice::slower, 1.5, 0.5, -3, 0.4, 9});
  channel->publish(Result{"sweep_000001", "/x/sweep_000001.ldp", true, "built", 4.5, Judgement::sweep_again, 14.5,
                          "the photos are dark\nblurred"});
  const auto status = listener->read();
  ASSERT_TRUE(status);
  EXPECT_GT(status->utc_ns, 0);
  EXPECT_EQ(std::get<Status>(status->message).text, "turn slowly");
  EXPECT_EQ(std::get<Status>(status->message).sweeps_left, 12);
  EXPECT_EQ(std::get<Progress>(listener->read()->message).fraction, 0.25);
  EXPECT_EQ(std::get<Guidance>(listener->read()->message).advice, Advice::slower);
  const Result result = std::get<Result>(listener->read()->message);
  EXPECT_EQ(result.file, "/x/sweep_000001.ldp");
  EXPECT_EQ(result.verdict, Judgement::sweep_again);
  EXPECT_EQ(result.expected_view_psnr_db, 14.5);
  EXPECT_EQ(result.reasons, "the photos are dark\nblurred");
  EXPECT_FALSE(listener->read());
  EXPECT_EQ(listener->ignored(), 0);
}

TEST(Lcm, CommandsReachTheDevice) {
  const auto channel = open_status(kUrl);
  const auto listener = open_status_listener(kUrl);
  for (const Command command : kCommands) {
    listener->send(command);
    EXPECT_EQ(channel->read(), command) << name_of(command);
  }
  EXPECT_EQ(channel->read(), std::nullopt);
}

// What nobody at this end asked for counts, too: one who sends without end must not keep the loop from the button.
TEST(Lcm, AReadLooksAtSoManyMessagesAndNoMore) {
  const auto channel = open_status(kUrl);
  const auto listener = open_status_listener(kUrl);
  for (int i = 0; i < 1500; ++i) listener->send(Command::cancel);
  pollfd entry{listener->fd(), POLLIN, 0};
  EXPECT_FALSE(listener->read());
  EXPECT_EQ(poll(&entry, 1, 0), 1) << "it looked at all of them";
  EXPECT_FALSE(listener->read());
  EXPECT_EQ(poll(&entry, 1, 0), 0);
  int heard = 0;
  while (channel->read()) ++heard;
  EXPECT_EQ(heard, 1500);
}

TEST(Lcm, LongAndStrangeTextsTravel) {
  const auto channel = open_status(kUrl);
  const auto listener = open_status_listener(kUrl);
  channel->publish(Status{Phase::idle, "", std::string(100'000, 'x'), 0, 0});
  channel->publish(Status{Phase::idle, "", std::string("a\0b", 3), 0, 0});
  EXPECT_EQ(std::get<Status>(listener->read()->message).text.size(), 1000U);
  EXPECT_EQ(std::get<Status>(listener->read()->message).text, "a");
}

const StatusMessage kMessages[] = {Status{Phase::done, "sweep_000001", "text", 7, 12},
                                   Progress{"sweep_000001", "poses", 0.25}, Guidance{},
                                   Result{"sweep_000001", "file", true, "built", 4.5, Judgement::fair, 21, "blurred"}};

// Noise, and good messages with bytes changed, cut off or added.
std::vector<uint8_t> damaged(std::mt19937& random, const std::vector<uint8_t>& good) {
  std::vector<uint8_t> bytes = good;
  if (random() % 4 == 0) {
    bytes.resize(random() % 200);
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random());
    return bytes;
  }
  for (unsigned changes = random() % 4; changes > 0; --changes)
    bytes[random() % bytes.size()] = static_cast<uint8_t>(random());
  if (random() % 2 == 0) bytes.resize(random() % (bytes.size() + 8));
  return bytes;
}

TEST(Lcm, AHundredThousandRandomDatagramsOnEveryChannelDoNoHarm) {
  std::mt19937 random(1);
  for (const StatusMessage& message : kMessages) {
    const std::vector<uint8_t> good = encode_message(message);
    const char* const channel = kMessageChannels[message.index()];
    ASSERT_TRUE(decode_message(channel, good));
    int refused = 0;
    for (int i = 0; i < 100'000; ++i) {
      const auto heard = decode_message(channel, damaged(random, good));
      if (!heard) ++refused;
      if (heard) {
        EXPECT_EQ(heard->message.index(), message.index());
      }
    }
    EXPECT_GT(refused, 50'000);
  }
  const std::vector<uint8_t> good = encode_command(Command::cancel);
  for (int i = 0; i < 100'000; ++i) {
    const auto command = decode_command(damaged(random, good));
    if (command) {
      EXPECT_LE(*command, kCommands.back());
    }
  }
}

TEST(Lcm, EveryTruncationIsRefused) {
  for (const StatusMessage& message : kMessages) {
    const std::vector<uint8_t> good = encode_message(message);
    for (size_t size = 0; size < good.size(); ++size) {
      EXPECT_FALSE(decode_message(kMessageChannels[message.index()], std::span(good).first(size)));
    }
  }
}

TEST(Lcm, AStringWhoseLengthIsUnderOneIsRefused) {
  std::vector<uint8_t> bytes = encode_message(kMessages[1]);
  // After hash, version and two clocks: the length of `capture`. The least int less one would be the greatest.
  for (const uint32_t length : {0x80000000U, 0x80000001U, 0xFFFFFFFFU, 0U}) {
    for (size_t i = 0; i < 4; ++i) bytes[28 + i] = static_cast<uint8_t>(length >> (24 - 8 * i));
    EXPECT_FALSE(decode_message("LDP_PROGRESS", bytes)) << length;
  }
}

// Datagrams that a stranger sends over the network of this machine. Each burst is waited for until it is counted whole:
// nothing is lost but what the kernel drops, and a burst is too small for that.
class Stranger : public testing::Test {
 protected:
  // On each channel: more than LCM's own queue of 30 takes, and of all five less than a socket holds that nobody reads:
  // 195 were seen, in 208 KiB.
  static constexpr int kBurst = 32;
  static constexpr int kMessagesOfBurst = kBurst * 4;

  void SetUp() override {
    NEEDS_MULTICAST();
    ASSERT_TRUE(stranger_.good());
    channel_ = open_status("lcm:" + network_);
    listener_ = open_status_listener("lcm:" + network_);
    send(kCommandChannel);
    ASSERT_TRUE(wait_for(*channel_));
    ASSERT_GT(counted(*channel_), 0);
  }

  void send(const char* channel) {
    for (uint8_t& byte : noise_) byte = static_cast<uint8_t>(random_());
    stranger_.publish(channel, noise_.data(), static_cast<unsigned>(noise_.size()));
  }
  // A busy machine may let LCM's thread wait for long; where nothing comes, the test must still end.
  template <typename End>
  static bool wait_for(const End& end) {
    pollfd entry{end.fd(), POLLIN, 0};
    return poll(&entry, 1, 10'000) > 0;
  }
  template <typename End>
  static int64_t counted(End& end) {
    while (end.read()) {
    }
    return end.ignored();
  }

  // Noise on every channel, and how much of it each end counted. Every end's socket takes in all channels; waiting for
  // both ends after each burst keeps what a slow one has not yet taken below what the kernel holds.
  struct Counts {
    int64_t commands, messages;
  };
  Counts burst() {
    const Counts before{counted(*channel_), counted(*listener_)};
    for (int i = 0; i < kBurst; ++i) {
      for (const char* const channel : kMessageChannels) send(channel);
      send(kCommandChannel);
    }
    while (counted(*channel_) - before.commands < kBurst && wait_for(*channel_)) {
    }
    while (counted(*listener_) - before.messages < kMessagesOfBurst && wait_for(*listener_)) {
    }
    return {counted(*channel_) - before.commands, counted(*listener_) - before.messages};
  }

  const std::string network_ = private_network();
  lcm::LCM stranger_{network_};
  std::unique_ptr<StatusChannel> channel_;
  std::unique_ptr<StatusListener> listener_;
  std::mt19937 random_{2};
  std::vector<uint8_t> noise_ = std::vector<uint8_t>(64);
};

// LDP_DATAGRAMS: how many on each of the five channels.
TEST_F(Stranger, RandomDatagramsOnEveryChannelAreCountedWholeAndChangeNothing) {
  const char* const wanted = std::getenv("LDP_DATAGRAMS");
  const int bursts = (wanted ? std::atoi(wanted) : 10'000) / kBurst;
  for (int i = 0; i < bursts; ++i) {
    const Counts counts = burst();
    ASSERT_EQ(counts.commands, kBurst) << "burst " << i;
    ASSERT_EQ(counts.messages, kMessagesOfBurst) << "burst " << i;
  }
  listener_->send(Command::retry);
  std::optional<Command> command;
  while (!command && wait_for(*channel_)) command = channel_->read();
  EXPECT_EQ(command, Command::retry);
}

}  // namespace
}  // namespace ldp
