// The gallery without its network: ranges, what a folder gives out, replies, the live feed.
#include "device/gallery/gallery.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <atomic>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <new>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/base/files.h"
#include "core/panorama/file/ldp_file.h"
#include "device/gallery/byte_range.h"
#include "device/gallery/cut_files.h"
#include "device/gallery/http/server.h"
#include "tests/golden/synthetic_panorama.h"

namespace ldp::gallery {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

// A device that tells what a test gives it.
class ScriptedDevice : public StatusListener {
 public:
  explicit ScriptedDevice(std::vector<Command>& heard)
      : heard_(heard), fd_(::eventfd(0, EFD_NONBLOCK | EFD_SEMAPHORE)) {}
  void tell(StatusMessage message) {
    const std::lock_guard lock(mutex_);
    messages_.push_back({std::move(message), 0, 0});
    const uint64_t one = 1;
    EXPECT_EQ(::write(fd_.get(), &one, sizeof one), ssize_t{sizeof one});
  }
  int fd() const override { return fd_.get(); }
  std::optional<HeardMessage> read() override {
    const std::lock_guard lock(mutex_);
    uint64_t one = 0;
    if (messages_.empty() || ::read(fd_.get(), &one, sizeof one) < 0) return std::nullopt;
    HeardMessage message = messages_.front();
    messages_.pop_front();
    return message;
  }
  int64_t ignored() const override { return 0; }
  bool ended() const override { return ended_; }
  void send(Command command) override { heard_.push_back(command); }
  // Whoever reads may destroy it as soon as it has ended.
  void end() {
    const uint64_t one = 1;
    EXPECT_EQ(::write(fd_.get(), &one, sizeof one), ssize_t{sizeof one});
    ended_ = true;
  }

 private:
  std::atomic<bool> ended_ = false;
  std::vector<Command>& heard_;
  UniqueFd fd_;
  std::mutex mutex_;
  std::deque<HeardMessage> messages_;
};

LiveFeed::Open opens(std::unique_ptr<StatusListener> device) {
  auto shared = std::make_shared<std::unique_ptr<StatusListener>>(std::move(device));
  return [shared] {
    if (!*shared) throw std::runtime_error("opened twice");
    return std::move(*shared);
  };
}

// The feed opens its device on a thread of its own.
void send_when_open(LiveFeed& feed, Command command) {
  for (int i = 0; i < 2000; ++i) try {
      return feed.send(command);
    } catch (const std::runtime_error&) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  ADD_FAILURE() << "the feed does not open its device";
}

// What a follower hears until a text comes, for at most ten seconds.
std::string heard_until(int follower, const std::string& text) {
  std::string heard;
  char part[4096];
  pollfd entry{follower, POLLIN, 0};
  while (heard.find(text) == std::string::npos && ::poll(&entry, 1, 10'000) > 0) {
    const ssize_t got = ::recv(follower, part, sizeof part, 0);
    if (got <= 0) break;
    heard.append(part, static_cast<size_t>(got));
  }
  return heard;
}

std::pair<UniqueFd, UniqueFd> sockets() {
  int ends[2];
  EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
  return {UniqueFd(ends[0]), UniqueFd(ends[1])};
}

class GalleryTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "ldp_gallery_XXXXXX";
    folder_ = mkdtemp(name.data());
    LayeredPanorama panorama = synthetic_panorama({});
    panorama.metadata["captured_utc"] = "2026-01-02T03:04:05Z";
    write_file(folder_ / "old.ldp", encode_ldp(panorama, {}));
    write_file(folder_ / "new.ldp", encode_ldp(panorama, {}));
    fs::last_write_time(folder_ / "old.ldp", fs::last_write_time(folder_ / "new.ldp") - std::chrono::hours(1));
  }
  void TearDown() override { fs::remove_all(folder_); }

  Reply ask(Gallery& gallery, const std::string& path, const std::string& method = "GET",
            const std::map<std::string, std::string>& headers = {}) {
    return gallery.answer({method, path, [&headers](const std::string& name) {
                             const auto found = headers.find(name);
                             return found == headers.end() ? std::string() : found->second;
                           }});
  }

  fs::path folder_;
};

TEST(GalleryRange, OneRangeIsAPartAndAnythingElseIsAll) {
  const auto is = [](std::string_view header, int status, uint64_t begin, uint64_t end) {
    const RangeAnswer answer = range_of(header, 100);
    EXPECT_EQ(answer.status, status) << header;
    if (status == 416) return;
    EXPECT_EQ(answer.range.begin, begin) << header;
    EXPECT_EQ(answer.range.end, end) << header;
  };
  is("", 200, 0, 100);
  is("bytes=0-0", 206, 0, 1);
  is("bytes=10-19", 206, 10, 20);
  is("bytes=99-", 206, 99, 100);
  is("bytes=90-500", 206, 90, 100);
  is("bytes=-1", 206, 99, 100);
  is("bytes=-500", 206, 0, 100);
  is("bytes=5-99999999999999999999999", 206, 5, 100);
  is("bytes=100-", 416, 0, 0);
  is("bytes=-0", 416, 0, 0);
  is("bytes=99999999999999999999999-", 416, 0, 0);
  for (const char* header :
       {"bytes=", "bytes=-", "bytes=5-2", "bytes=a-b", "bytes=1-2,3-4", "bytes= 1-2", "bytes=+1-2", "lines=1-2"})
    is(header, 200, 0, 100);
}

TEST(GalleryRange, AnEmptyFileHasNoPart) {
  EXPECT_EQ(range_of("bytes=0-", 0).status, 416);
  EXPECT_EQ(range_of("bytes=-1", 0).status, 416);
}

TEST(GalleryFolder, NamesThatLeadElsewhereAreNone) {
  for (const char* name : {"room.ldp", "a b \xC3\xA4.ldp", "...x.ldp"})
    EXPECT_EQ(is_panorama_name(name), name[0] != '.') << name;
  for (const std::string name :
       {"", ".ldp", "room", "room.jpg", "../room.ldp", "a/b.ldp", "/room.ldp", ".room.ldp", "a\nb.ldp"})
    EXPECT_FALSE(is_panorama_name(name)) << name;
  EXPECT_FALSE(is_panorama_name(std::string("a\0b.ldp", 7)));
  EXPECT_FALSE(is_panorama_name(std::string(300, 'a') + ".ldp"));
  EXPECT_TRUE(is_sweep_name("sweep_000012"));
  for (const char* name : {"sweep_12", "sweep_0000000012", "sweep_00001x", "Sweep_000012", "sweep_000012/"})
    EXPECT_FALSE(is_sweep_name(name));
  EXPECT_TRUE(is_frame_name("frame_000.jpg") && is_frame_name("frame_1234.jpg"));
  for (const char* name : {"frame_.jpg", "frame_0.jpg.jpg", "capture.json", "frame_../.jpg"})
    EXPECT_FALSE(is_frame_name(name));
}

TEST_F(GalleryTest, PanoramasAreListedNewestFirst) {
  const Folder folder(folder_);
  LiveFeed feed({});
  Gallery gallery(folder, feed, {}, {});
  const auto json = nlohmann::json::parse(ask(gallery, "/panoramas.json").text);
  ASSERT_EQ(json["panoramas"].size(), 2U);
  EXPECT_EQ(json["panoramas"][0]["name"], "new.ldp");
  EXPECT_EQ(json["panoramas"][1]["name"], "old.ldp");
  EXPECT_EQ(json["panoramas"][0]["captured_utc"], "2026-01-02T03:04:05Z");
  EXPECT_EQ(json["panoramas"][0]["layers"], 3);
  EXPECT_FALSE(json["live"]);
  EXPECT_FALSE(json["changes"]);
}

TEST_F(GalleryTest, AReplacedFileIsToldAnew) {
  const Folder folder(folder_);
  Cards cards(folder);
  const SharedCard before = cards.of("new.ldp");
  EXPECT_EQ(cards.of("new.ldp"), before) << "read again";
  write_file(folder_ / "new.ldp", "no panorama");
  EXPECT_THAT(cards.of("new.ldp")->trouble, HasSubstr("header"));
  EXPECT_EQ(cards.of("none.ldp"), nullptr);
}

TEST_F(GalleryTest, WhatTakesTooMuchMemoryIsNotConverted) {
  const Folder folder(folder_);
  LiveFeed feed({});
  Gallery small(folder, feed, {"", {.memory_bytes = 1000}}, {});
  const Reply reply = ask(small, "/panoramas/new.glb");
  EXPECT_EQ(reply.status, 422);
  EXPECT_THAT(reply.text, HasSubstr("too large"));
}

TEST_F(GalleryTest, ConversionsAreKeptWithinTheirBound) {
  const Folder folder(folder_);
  const auto made = [&](Conversions& conversions, const char* name) {
    return conversions.convert(*folder.open_panorama(name), ".jpg");
  };
  Conversions unbounded({}, {});
  const size_t bytes = made(unbounded, "new.ldp")->size();
  Conversions conversions({.kept_bytes = bytes + bytes / 2}, {});
  const SharedBytes first = made(conversions, "new.ldp");
  EXPECT_EQ(made(conversions, "new.ldp"), first) << "made again";
  EXPECT_NE(made(conversions, "old.ldp"), first);
  EXPECT_NE(made(conversions, "new.ldp"), first) << "kept although there is no room";
}

TEST_F(GalleryTest, OnlyTheTokenChangesAnything) {
  const Folder folder(folder_);
  std::vector<Command> heard;
  LiveFeed feed(opens(std::make_unique<ScriptedDevice>(heard)));
  send_when_open(feed, Command::retry);
  heard.clear();
  Gallery closed(folder, feed, {}, {});
  EXPECT_EQ(ask(closed, "/device/press", "POST", {{"Authorization", "Bearer "}}).status, 403);
  EXPECT_EQ(ask(closed, "/panoramas/new.ldp", "DELETE", {{"Authorization", "Bearer "}}).status, 403);
  const std::string token = "0123456789abcdef";
  Gallery open(folder, feed, {token, {}}, {});
  for (const std::string wrong :
       {"", "Bearer", "Bearer ", "Bearer 0123456789abcde", "Bearer 0123456789abcdef0", "Bearer 0123456789abcdeg"})
    EXPECT_EQ(ask(open, "/device/press", "POST", {{"Authorization", wrong}}).status, 401) << wrong;
  EXPECT_TRUE(heard.empty());
  const std::map<std::string, std::string> right{{"Authorization", "Bearer " + token}};
  EXPECT_EQ(ask(open, "/device/press", "POST", right).status, 204);
  EXPECT_EQ(ask(open, "/device/stop", "POST", right).status, 204);
  EXPECT_EQ(ask(open, "/device/cancel", "POST", right).status, 204);
  EXPECT_EQ(ask(open, "/device/explode", "POST", right).status, 404);
  EXPECT_EQ(ask(open, "/device/press", "GET", right).status, 404);
  EXPECT_THAT(heard, testing::ElementsAre(Command::press, Command::stop, Command::cancel));
  EXPECT_EQ(ask(open, "/panoramas/new.ldp", "DELETE", right).status, 204);
  EXPECT_THAT(folder.panoramas(), UnorderedElementsAre("old.ldp"));
  EXPECT_THROW(Gallery(folder, feed, {"short", {}}, {}), std::invalid_argument);
}

TEST_F(GalleryTest, APanoramasOwnSweepGoesWithItAndNobodyElsesFolder) {
  for (const char* name : {"sweep_000001", "new", "sweep_000002"}) fs::create_directory(folder_ / name);
  for (const char* name :
       {"sweep_000001/capture.json", "sweep_000001/frame_000.jpg", "new/capture.json", "sweep_000002/photo.jpg"})
    std::ofstream(folder_ / name) << "x";
  for (const char* name : {"sweep_000001.ldp", "sweep_000002.ldp"}) fs::copy(folder_ / "new.ldp", folder_ / name);
  const Folder folder(folder_);
  for (const char* name : {"sweep_000001.ldp", "sweep_000002.ldp", "new.ldp"})
    EXPECT_TRUE(folder.remove_panorama(name));
  EXPECT_FALSE(folder.remove_panorama("none.ldp"));
  EXPECT_FALSE(fs::exists(folder_ / "sweep_000001"));
  EXPECT_TRUE(fs::exists(folder_ / "sweep_000002/photo.jpg")) << "no capture's record in it";
  EXPECT_TRUE(fs::exists(folder_ / "new/capture.json"));
}

TEST(GalleryFeed, FollowersHearWhatIsToldAndWhoComesLaterTheLast) {
  std::vector<Command> commands;
  auto owned = std::make_unique<ScriptedDevice>(commands);
  ScriptedDevice& device = *owned;
  LiveFeed feed(opens(std::move(owned)));
  auto [early, early_end] = sockets();
  feed.add(std::move(early_end));
  device.tell(Status{Phase::capturing, "sweep_000001", "turn", 3, 20});
  device.tell(Guidance{Advice::slower, 1.0, 0.5, 0, 0.4, 3});
  const std::string heard = heard_until(early.get(), "guidance");
  EXPECT_THAT(heard, HasSubstr(R"(data: {"type":"status","phase":"capturing","capture":"sweep_000001","text":"turn")"));
  EXPECT_THAT(heard, HasSubstr(R"("advice":"slower")"));
  auto [late, late_end] = sockets();
  feed.add(std::move(late_end));
  EXPECT_THAT(heard_until(late.get(), "guidance"), HasSubstr(R"("phase":"capturing")"));
}

TEST(GalleryFeed, AFollowerThatDoesNotReadIsLetGo) {
  std::vector<Command> commands;
  auto owned = std::make_unique<ScriptedDevice>(commands);
  ScriptedDevice& device = *owned;
  LiveFeed feed(opens(std::move(owned)));
  auto [idle, idle_end] = sockets();
  auto [good, good_end] = sockets();
  feed.add(std::move(idle_end));
  feed.add(std::move(good_end));
  const std::string text(50'000, 'x');
  for (int i = 0; i < 20; ++i) {
    device.tell(Status{Phase::idle, "", text + std::to_string(i), 0, 0});
    ASSERT_THAT(heard_until(good.get(), text + std::to_string(i) + "\""), HasSubstr("status"));
  }
  char part[4096];
  ssize_t got = 0;
  while ((got = ::recv(idle.get(), part, sizeof part, 0)) > 0) {
  }
  EXPECT_EQ(got, 0) << "its end";
}

// A network that is not there yet, and a connection that breaks.
TEST(GalleryFeed, ADeviceThatCannotBeReachedIsTriedAgainAndSoIsOneThatBroke) {
  std::vector<Command> commands;
  std::atomic<int> tries = 0;
  std::atomic<ScriptedDevice*> present = nullptr;
  LiveFeed feed([&]() -> std::unique_ptr<StatusListener> {
    if (++tries == 1) throw std::runtime_error("there is no network");
    auto device = std::make_unique<ScriptedDevice>(commands);
    present = device.get();
    return device;
  });
  EXPECT_TRUE(feed.has_device());
  auto [follower, end] = sockets();
  feed.add(std::move(end));
  send_when_open(feed, Command::press);
  (*present).tell(Status{Phase::idle, "", "the first connection", 0, 0});
  EXPECT_THAT(heard_until(follower.get(), "the first connection"), HasSubstr("idle"));
  ScriptedDevice* const broken = present;
  broken->end();
  for (int i = 0; i < 2000 && tries < 3; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  ASSERT_EQ(tries, 3);
  send_when_open(feed, Command::cancel);
  (*present).tell(Status{Phase::idle, "", "the second connection", 0, 0});
  EXPECT_THAT(heard_until(follower.get(), "the second connection"), HasSubstr("idle"));
}

TEST_F(GalleryTest, ASweepWithAFolderInItIsLeftWholeAndSoIsItsPanorama) {
  fs::create_directories(folder_ / "sweep_000001/edited");
  for (const char* name : {"sweep_000001/capture.json", "sweep_000001/frame_000.jpg", "sweep_000001/zzz.jpg"})
    std::ofstream(folder_ / name) << "x";
  fs::copy(folder_ / "new.ldp", folder_ / "sweep_000001.ldp");
  const Folder folder(folder_);
  EXPECT_THROW(folder.remove_panorama("sweep_000001.ldp"), std::runtime_error);
  for (const char* name : {"capture.json", "frame_000.jpg", "zzz.jpg", "edited"})
    EXPECT_TRUE(fs::exists(folder_ / "sweep_000001" / name)) << name;
  EXPECT_TRUE(fs::exists(folder_ / "sweep_000001.ldp"));
}

// The service would build it again: its names have six digits and, beyond a million, more.
TEST_F(GalleryTest, ASweepBeyondAMillionGoesWithItsPanorama) {
  fs::create_directories(folder_ / "sweep_1000000");
  std::ofstream(folder_ / "sweep_1000000/capture.json") << "x";
  fs::copy(folder_ / "new.ldp", folder_ / "sweep_1000000.ldp");
  EXPECT_TRUE(Folder(folder_).remove_panorama("sweep_1000000.ldp"));
  EXPECT_FALSE(fs::exists(folder_ / "sweep_1000000"));
}

TEST_F(GalleryTest, AFileThatIsCutShortWhileItIsMappedEndsNothing) {
  read_cut_files_as_zeros();
  const std::vector<uint8_t> bytes(1 << 16, 7);
  std::ofstream(folder_ / "cut.ldp").write(reinterpret_cast<const char*>(bytes.data()), 1 << 16);
  const MappedFile mapped(folder_ / "cut.ldp");
  fs::resize_file(folder_ / "cut.ldp", 5000);
  EXPECT_EQ(mapped.bytes()[4999], 7);
  EXPECT_EQ(mapped.bytes()[30'000], 0);
  EXPECT_EQ(mapped.bytes().back(), 0);
}

// One client, over a socket of this machine.
class GalleryServer {
 public:
  explicit GalleryServer(Service service)
      : service_(std::move(service)),
        listening_(listen_on("127.0.0.1:0")),
        thread_([this](const std::stop_token& stop) { serve(listening_.get(), service_, stop); }) {}

  // What comes back until the server closes.
  std::string ask(const std::string& path) const {
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    EXPECT_EQ(::getsockname(listening_.get(), reinterpret_cast<sockaddr*>(&address), &size), 0);
    const UniqueFd client(::socket(AF_INET, SOCK_STREAM, 0));
    EXPECT_EQ(::connect(client.get(), reinterpret_cast<const sockaddr*>(&address), size), 0);
    const std::string request = "GET " + path + " HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n";
    EXPECT_EQ(::send(client.get(), request.data(), request.size(), MSG_NOSIGNAL), static_cast<ssize_t>(request.size()));
    return heard_until(client.get(), "no such words");
  }

 private:
  Service service_;
  UniqueFd listening_;
  std::jthread thread_;
};

TEST(GalleryHttp, WhatGoesWrongWithOneConnectionEndsThatAlone) {
  const GalleryServer server({[](const Asked& asked) {
                                Reply reply;
                                reply.text = "here";
                                reply.follows = asked.path == "/events";
                                return reply;
                              },
                              [](UniqueFd) { throw std::bad_alloc(); },
                              {}});
  EXPECT_THAT(server.ask("/"), HasSubstr("here"));
  for (int i = 0; i < 20; ++i) server.ask("/events");  // more than there are threads
  EXPECT_THAT(server.ask("/"), HasSubstr("here"));
}

}  // namespace
}  // namespace ldp::gallery
