// URLs, timers, debouncing, mode choice and the simulated devices.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>

#include <filesystem>
#include <fstream>

#include "core/base/files.h"
#include "core/photos/images.h"
#include "drivers/backends.h"
#include "drivers/debouncer.h"
#include "drivers/interface/clocks.h"
#include "drivers/interface/ticker.h"
#include "drivers/interface/url.h"
#include "drivers/v4l2_modes.h"
#include "sim/devices.h"

namespace ldp {
namespace {

using testing::HasSubstr;

template <typename Call>
std::string complaint(Call call) {
  try {
    call();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

bool wait_readable(int fd, int timeout_ms = 5000) {
  pollfd entry{fd, POLLIN, 0};
  return poll(&entry, 1, timeout_ms) == 1;
}

class Folder {
 public:
  Folder() {
    std::string name = testing::TempDir() + "ldp_devices_XXXXXX";
    path_ = mkdtemp(name.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  std::string text() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

TEST(Url, SchemePathAndOptionsAreTakenApart) {
  const Url url("v4l2:/dev/video0?width=1280&fps=29.5&raw");
  EXPECT_EQ(url.scheme(), "v4l2");
  EXPECT_EQ(url.path(), "/dev/video0");
  EXPECT_EQ(url.integer("width", 0, {1, 9999}), 1280);
  EXPECT_EQ(url.number("fps", 30, {1, 100}), 29.5);
  EXPECT_TRUE(url.flag("raw", false));
  EXPECT_EQ(url.integer("height", 720, {1, 9999}), 720);
}

TEST(Url, AWrongValueNamesTheUrlTheOptionAndTheRange) {
  const Url url("v4l2:/dev/video0?width=wide&fps=-1&height=7.5");
  EXPECT_THAT(complaint([&] {
                url.integer("width", 0, {1, 10});
              }),
              testing::AllOf(HasSubstr("/dev/video0"), HasSubstr("width is 'wide'"), HasSubstr("1 to 10")));
  EXPECT_THAT(complaint([&] { url.number("fps", 0, {1, 10}); }), HasSubstr("fps is '-1'"));
  EXPECT_THAT(complaint([&] { url.integer("height", 0, {1, 10}); }), HasSubstr("whole number"));
}

TEST(Url, AnUnknownOptionIsNamedWithTheKnownOnes) {
  EXPECT_THAT(complaint([] { Url("folder:x?speed=3").allow_only("fps hold"); }),
              testing::AllOf(HasSubstr("'speed'"), HasSubstr("fps hold")));
  EXPECT_THAT(complaint([] { Url("no scheme here"); }), HasSubstr("no scheme"));
}

TEST(LcmUrl, IsRefusedForItsTextAloneInTheWordsOfWhatIsWrong) {
  for (const char* const good :
       {"lcm:", "lcm:udpm://", "lcm:udpm://239.255.76.67", "lcm:udpm://224.0.0.1:1?ttl=255&recv_buf_size=9",
        "lcm:mpudpm://239.255.76.67:65535", "lcm:memq://", "lcm:tcpq://localhost:7700", "lcm:file:///a/log?mode=w"}) {
    EXPECT_EQ(complaint([&] { check_lcm(Url(good)); }), "") << good;
  }
  const std::pair<const char*, const char*> wrong[] = {
      {"lcm:udpm", "expected PROVIDER://NETWORK"},
      {"lcm:239.255.76.67:7667", "expected PROVIDER://NETWORK"},
      {"lcm:upd://239.255.76.67:7667", "no provider 'upd'; known: udpm"},
      {"lcm:udpm://garbage", "'garbage' is no multicast"},
      {"lcm:udpm://:7667", "'' is no multicast"},
      {"lcm:udpm://240.0.0.0:7667", "'240.0.0.0' is no multicast"},
      {"lcm:mpudpm://10.0.0.1:7667", "'10.0.0.1' is no multicast"},
      {"lcm:udpm://239.255.76.67:", "'' is no port"},
      {"lcm:udpm://239.255.76.67:0", "'0' is no port"},
      {"lcm:udpm://239.255.76.67:65536", "'65536' is no port"},
      {"lcm:udpm://239.255.76.67:76x7", "'76x7' is no port"},
      {"lcm:udpm://239.255.76.67:7667?tll=0", "unknown option 'tll'"},
      {"lcm:udpm://239.255.76.67:7667?ttl=256", "ttl is '256'"}};
  for (const auto& [url, what] : wrong)
    EXPECT_THAT(complaint([&, text = url] { check_lcm(Url(text)); }), testing::AllOf(HasSubstr(what), HasSubstr(url)));
}

TEST(Url, OfACameraIsCheckedWithoutTheCamera) {
  EXPECT_EQ(complaint([] { wish_from(Url("v4l2:/nowhere?width=640&format=nv12")); }), "");
  EXPECT_EQ(wish_from(Url("v4l2:/nowhere?format=nv12")).format, PixelFormat::nv12);
  EXPECT_THAT(complaint([] { wish_from(Url("v4l2:/nowhere?format=tiff")); }), HasSubstr("format is 'tiff'"));
  EXPECT_EQ(complaint([] { check_folder_camera(Url("folder:/nowhere?fps=5")); }), "");
  EXPECT_THAT(complaint([] { check_folder_camera(Url("folder:/nowhere?fps=0")); }), HasSubstr("fps is '0'"));
  EXPECT_THAT(complaint([] { check_scene_camera(Url("scene:room?width=3")); }), HasSubstr("width is '3'"));
  EXPECT_THAT(complaint([] { check_scene_camera(Url("scene:room?hold=maybe")); }), HasSubstr("hold is 'maybe'"));
  EXPECT_EQ(complaint([] { check_script_button(Url("script:/nowhere")); }), "");
  EXPECT_THAT(complaint([] { check_script_button(Url("script:/nowhere?a")); }), HasSubstr("'a'"));
  EXPECT_THAT(complaint([] { check_keyboard_button(Url("keyboard:?a")); }), HasSubstr("'a'"));
}

TEST(Debouncer, ACleanPressIsReportedOnceItHasSettledAndDatedAtItsEdge) {
  Debouncer debouncer(false, 20);
  EXPECT_FALSE(debouncer.deadline_ns());
  debouncer.edge(100);
  EXPECT_EQ(debouncer.deadline_ns(), 120);
  EXPECT_FALSE(debouncer.settle(true, 119));
  const auto event = debouncer.settle(true, 120);
  ASSERT_TRUE(event);
  EXPECT_TRUE(event->pressed);
  EXPECT_EQ(event->time_ns, 100);
  EXPECT_FALSE(debouncer.deadline_ns());
}

TEST(Debouncer, BouncesOfOneToTwentyMillisecondsMakeOnePressAndOneRelease) {
  constexpr int64_t kMs = 1'000'000;
  for (int64_t bounce_ms = 1; bounce_ms <= 20; ++bounce_ms) {
    Debouncer debouncer(false, 30 * kMs);
    int64_t now_ns = 0;
    int events = 0;
    for (const bool target : {true, false}) {
      bool level = target;
      for (int edge = 0; edge < 7; ++edge, now_ns += bounce_ms * kMs) {
        if (debouncer.settle(!level, now_ns)) ++events;  // asked too early, between the edges
        debouncer.edge(now_ns);
        level = edge % 2 == 0 ? target : !target;
      }
      now_ns += 30 * kMs;
      const auto event = debouncer.settle(target, now_ns);
      ASSERT_TRUE(event) << bounce_ms;
      EXPECT_EQ(event->pressed, target);
    }
    EXPECT_EQ(events, 0) << bounce_ms;
  }
}

TEST(Debouncer, ASpikeThatFallsBackIsNothing) {
  Debouncer debouncer(false, 20);
  debouncer.edge(100);
  debouncer.edge(103);
  EXPECT_FALSE(debouncer.settle(false, 150));
  debouncer.edge(200);
  const auto press = debouncer.settle(true, 250);  // had the spike counted, this would be nothing new
  ASSERT_TRUE(press);
  EXPECT_EQ(press->time_ns, 200);
}

TEST(V4l2Modes, TheNearestSizeWinsThenMjpegThenTheRate) {
  const CameraMode offers[] = {{PixelFormat::yuyv, 1280, 720, 10, 0},
                               {PixelFormat::mjpeg, 1280, 720, 30, 0},
                               {PixelFormat::yuyv, 640, 480, 30, 0},
                               {PixelFormat::mjpeg, 1920, 1080, 30, 0}};
  EXPECT_EQ(choose_mode(offers, {})->format, PixelFormat::mjpeg);
  EXPECT_EQ(choose_mode(offers, {})->width, 1280);
  ModeWish raw;
  raw.format = PixelFormat::yuyv;
  EXPECT_EQ(choose_mode(offers, raw)->width, 640) << "10 frames a second are too slow for a sweep";
  ModeWish none;
  none.format = PixelFormat::nv12;
  EXPECT_FALSE(choose_mode(offers, none));
}

TEST(V4l2Modes, ASlowModeIsBetterThanNone) {
  const CameraMode offers[] = {{PixelFormat::yuyv, 1280, 720, 5, 0}};
  EXPECT_EQ(choose_mode(offers, {})->width, 1280);
}

TEST(ScriptButton, PressesAndReleasesComeInTime) {
  const Folder folder;
  std::ofstream(folder / "script") << "press wait 20  # a short one\nrelease\nwait 10\npress\n";
  const int64_t before_ns = monotonic_now_ns();
  const auto button = open_script_button(Url("script:" + (folder / "script").string()));
  std::vector<ButtonEvent> events;
  while (events.size() < 3) {
    ASSERT_TRUE(wait_readable(button->fd()));
    while (const auto event = button->read()) events.push_back(*event);
  }
  EXPECT_TRUE(events[0].pressed);
  EXPECT_FALSE(events[1].pressed);
  EXPECT_TRUE(events[2].pressed);
  EXPECT_EQ(events[1].time_ns - events[0].time_ns, 20'000'000);
  EXPECT_EQ(events[2].time_ns - events[0].time_ns, 30'000'000);
  EXPECT_GE(events[0].time_ns, before_ns);
  EXPECT_GE(monotonic_now_ns(), events[2].time_ns) << "an event came before its time";
  EXPECT_FALSE(wait_readable(button->fd(), 0));
}

TEST(ScriptButton, AWrongWordIsNamedWithItsLine) {
  const Folder folder;
  std::ofstream(folder / "script") << "press\nwait long\n";
  EXPECT_THAT(complaint([&] { open_script_button(Url("script:" + (folder / "script").string())); }),
              testing::AllOf(HasSubstr(":2:"), HasSubstr("'wait'")));
  EXPECT_THAT(complaint([] { open_script_button(Url("script:/nowhere")); }), HasSubstr("'/nowhere': check its name"));
  EXPECT_THAT(complaint([] { open_script_button(Url("script:/dev/null")); }), HasSubstr("is empty: a pipe"));
  std::ofstream(folder / "empty").close();
  EXPECT_THAT(complaint([&] { open_script_button(Url("script:" + (folder / "empty").string())); }),
              testing::EndsWith("is empty"));
}

TEST(ScriptButton, WaitsBeyondAnyClockAndScriptsWithoutEndAreRefused) {
  const Folder folder;
  const std::string url = "script:" + (folder / "script").string();
  std::ofstream endless(folder / "script");
  for (int i = 0; i < 10'000; ++i) endless << "wait 999999999\n";  // more nanoseconds than 64 bits count
  endless << "press\n" << std::flush;
  EXPECT_THAT(complaint([&] { open_script_button(Url(url)); }),
              testing::AllOf(HasSubstr("script:11:"), HasSubstr("longer than four months in all")));
  for (const char* const wrong : {"wait -1", "wait 1e11", "wait nan", "wait", "wait inf"}) {
    std::ofstream(folder / "script") << "press\n" << wrong << "\n";
    EXPECT_THAT(complaint([&] { open_script_button(Url(url)); }), HasSubstr("script:2:")) << wrong;
  }
  std::ofstream(folder / "script") << "press wait 1e10\nrelease\n";
  EXPECT_EQ(complaint([&] { open_script_button(Url(url)); }), "");
  std::ofstream(folder / "script") << std::string(1 << 20, '\n');
  EXPECT_EQ(complaint([&] { open_script_button(Url(url)); }), "");
  std::ofstream(folder / "script", std::ios::app) << '\n';
  EXPECT_THAT(complaint([&] { open_script_button(Url(url)); }), HasSubstr("longer than a megabyte"));
}

struct PictureFolder : Folder {
  PictureFolder() {
    for (int i = 0; i < 3; ++i) {
      jpegs.push_back(encode_jpeg(RgbImage(40, 30, Rgb{static_cast<uint8_t>(40 * i), 100, 100}), 90));
      write_file(*this / ("frame_" + std::to_string(i) + ".jpg"), jpegs.back());
    }
  }
  std::vector<std::vector<uint8_t>> jpegs;
};

TEST(FolderCamera, JpegFilesPassThroughByteByByteAndTheLastIsHeld) {
  const PictureFolder folder;
  const auto camera = open_folder_camera(Url("folder:" + folder.text() + "?fps=500"));
  EXPECT_EQ(camera->mode().width, 40);
  camera->start();
  for (int i = 0; i < 5; ++i) {
    std::optional<CameraFrame> frame;
    while (!frame) {
      ASSERT_TRUE(wait_readable(camera->fd()));
      frame = camera->read();
    }
    const auto& expected = folder.jpegs[static_cast<size_t>(std::min(i, 2))];
    EXPECT_EQ(std::vector<uint8_t>(frame->planes[0].bytes, frame->planes[0].bytes + frame->planes[0].size), expected);
    EXPECT_EQ(frame->sequence, i);
  }
  camera->stop();
  EXPECT_FALSE(wait_readable(camera->fd(), 20));
}

TEST(FolderCamera, ItCanBeUnplugged) {
  const PictureFolder folder;
  const auto camera = open_folder_camera(Url("folder:" + folder.text() + "?fps=500&lost_after=1"));
  camera->start();
  ASSERT_TRUE(wait_readable(camera->fd()));
  EXPECT_TRUE(camera->read());
  ASSERT_TRUE(wait_readable(camera->fd()));
  EXPECT_THROW(camera->read(), CameraLost);
}

TEST(FolderCamera, ShowsThePhotosThatABuildWouldTake) {
  const PictureFolder folder;
  const std::filesystem::path capture = folder.text(), frames = capture / "frames";
  std::vector<std::filesystem::path> photos;
  for (const auto& entry : std::filesystem::directory_iterator(capture)) photos.push_back(entry.path());
  std::filesystem::create_directory(frames);
  for (const auto& photo : photos) std::filesystem::rename(photo, frames / photo.filename());
  EXPECT_EQ(open_folder_camera(Url("folder:" + folder.text()))->mode().width, 40);
}

TEST(FolderCamera, AnEmptyOrMissingFolderIsRefusedInWords) {
  const Folder folder;
  EXPECT_THAT(complaint([&] { open_folder_camera(Url("folder:" + folder.text())); }), HasSubstr("no .jpg or .png"));
  EXPECT_EQ(complaint([] { open_folder_camera(Url("folder:/nowhere")); }),
            "/nowhere: there is no such folder: check the name");
  const std::filesystem::path loop = folder / "loop";
  std::filesystem::create_symlink(loop, loop);
  EXPECT_THAT(complaint([&] { open_folder_camera(Url("folder:" + loop.string())); }),
              HasSubstr("loop: cannot be looked at ("));
}

TEST(SceneCamera, AnUnknownSceneIsNamedWithTheKnownOnes) {
  EXPECT_THAT(complaint([] { open_scene_camera(Url("scene:moon")); }), HasSubstr("garden"));
}

TEST(SceneCamera, ItsRenderingIsGivenUpBetweenTwoFramesAndGoesOnThere) {
  const auto camera = open_scene_camera(Url("scene:room?fps=1000&width=32&height=24&frames=5"));
  int asked = 0;
  EXPECT_FALSE(camera->prepare([&] { return ++asked == 3; }));
  EXPECT_EQ(asked, 3);
  EXPECT_TRUE(camera->prepare([&] { return ++asked == 100; }));
  EXPECT_EQ(asked, 6) << "two frames were there, and three are rendered";
  camera->start();
  ASSERT_TRUE(wait_readable(camera->fd()));
  EXPECT_TRUE(camera->read());
}

TEST(SceneCamera, WithoutPreparationTheStartRenders) {
  const auto camera = open_scene_camera(Url("scene:room?fps=1000&width=32&height=24&frames=2"));
  camera->start();
  ASSERT_TRUE(wait_readable(camera->fd()));
  EXPECT_EQ(camera->read()->width, 32);
}

}  // namespace
}  // namespace ldp
