// The V4L2 camera on a device that this file is: calls that would go to the kernel are answered here, buffers lie in a
// file in memory.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/videodev2.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "drivers/backends.h"
#include "drivers/interface/clocks.h"
#include "drivers/interface/unique_fd.h"
#include "drivers/v4l2/v4l2_ioctl.h"
#include "drivers/v4l2/v4l2_offers.h"

namespace ldp::v4l2 {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr size_t kBufferBytes = 1 << 16;

struct Size {
  uint32_t width, height;
  std::vector<uint32_t> rates;  // frames a second
};

struct Format {
  uint32_t code;
  std::vector<Size> sizes;
  bool stepwise = false;  // then sizes are the least and the greatest, in steps of 16 by 8
};

struct Arrival {
  std::string bytes;
  int error = 0;  // errno of DQBUF instead of a frame
  uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  timeval time = {5, 250};
};

class FakeDevice {
 public:
  FakeDevice() : memory_(memfd_create("v4l2", MFD_CLOEXEC)) {
    EXPECT_EQ(ftruncate(memory_.get(), 6 * kBufferBytes), 0);
  }

  uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::vector<Format> formats = {{V4L2_PIX_FMT_YUYV, {{64, 48, {30}}}}};
  uint32_t answered_code = 0;   // instead of the one asked for
  uint32_t bytes_per_line = 0;  // 0: two a pixel
  bool tells_bytes_per_line = true;
  uint32_t answered_rate = 0;  // frames a second; 0 = no choice of rate
  std::map<uint32_t, int32_t> controls;
  uint32_t buffers_given = 6;
  std::deque<Arrival> arrivals;
  unsigned long failing = 0;  // the call that is refused with EBUSY

  std::deque<uint32_t> queued;
  bool streams = false;
  v4l2_pix_format set_format{};
  std::vector<std::pair<uint32_t, int32_t>> written;  // controls, in order

  std::string url(const std::string& options = "") const {
    return "v4l2:/proc/self/fd/" + std::to_string(memory_.get()) + options;
  }
  bool is_multiplanar() const { return (capabilities & V4L2_CAP_VIDEO_CAPTURE_MPLANE) != 0; }

  int answer(unsigned long request, void* argument) {
    if (request == failing) return refuse(EBUSY);
    switch (request) {
      case VIDIOC_QUERYCAP:
        return query(*static_cast<v4l2_capability*>(argument));
      case VIDIOC_ENUM_FMT:
        return enumerate(*static_cast<v4l2_fmtdesc*>(argument));
      case VIDIOC_ENUM_FRAMESIZES:
        return enumerate(*static_cast<v4l2_frmsizeenum*>(argument));
      case VIDIOC_ENUM_FRAMEINTERVALS:
        return enumerate(*static_cast<v4l2_frmivalenum*>(argument));
      case VIDIOC_S_FMT:
        return set(*static_cast<v4l2_format*>(argument));
      case VIDIOC_S_PARM:
        return set(*static_cast<v4l2_streamparm*>(argument));
      case VIDIOC_REQBUFS:
        queued.clear();
        if (auto& wish = *static_cast<v4l2_requestbuffers*>(argument); wish.count > 0) wish.count = buffers_given;
        return 0;
      case VIDIOC_QUERYBUF:
        return place(*static_cast<v4l2_buffer*>(argument));
      case VIDIOC_QBUF:
        queued.push_back(static_cast<v4l2_buffer*>(argument)->index);
        return 0;
      case VIDIOC_DQBUF:
        return deliver(*static_cast<v4l2_buffer*>(argument));
      case VIDIOC_STREAMON:
        return streams = true, 0;
      case VIDIOC_STREAMOFF:
        return streams = false, 0;
      case VIDIOC_G_CTRL:
        return get(*static_cast<v4l2_control*>(argument));
      case VIDIOC_S_CTRL:
        return set(*static_cast<v4l2_control*>(argument));
      default:
        return refuse(ENOTTY);
    }
  }

 private:
  static int refuse(int error) { return errno = error, -1; }

  int query(v4l2_capability& to) const {
    std::strcpy(reinterpret_cast<char*>(to.card), "Fake");
    to.capabilities = capabilities | V4L2_CAP_DEVICE_CAPS;
    to.device_caps = capabilities;
    return 0;
  }
  int enumerate(v4l2_fmtdesc& to) const {
    if (to.index >= formats.size()) return refuse(EINVAL);
    to.pixelformat = formats[to.index].code;
    return 0;
  }
  const Format* of(uint32_t code) const {
    const auto found = std::find_if(formats.begin(), formats.end(), [&](const Format& f) { return f.code == code; });
    return found == formats.end() ? nullptr : &*found;
  }
  int enumerate(v4l2_frmsizeenum& to) const {
    const Format* const format = of(to.pixel_format);
    if (format->stepwise) {
      if (to.index > 0) return refuse(EINVAL);
      const Size &least = format->sizes[0], &most = format->sizes[1];
      to.type = V4L2_FRMSIZE_TYPE_STEPWISE;
      to.stepwise = {least.width, most.width, 16, least.height, most.height, 8};
      return 0;
    }
    if (to.index >= format->sizes.size()) return refuse(EINVAL);
    to.type = V4L2_FRMSIZE_TYPE_DISCRETE;
    to.discrete = {format->sizes[to.index].width, format->sizes[to.index].height};
    return 0;
  }
  int enumerate(v4l2_frmivalenum& to) const {
    const Format* const format = of(to.pixel_format);
    if (format->stepwise) {
      to.type = V4L2_FRMIVAL_TYPE_STEPWISE;
      to.stepwise = {{1, format->sizes[1].rates[0]}, {1, format->sizes[0].rates[0]}, {1, 1000}};
      return 0;
    }
    for (const Size& size : format->sizes) {
      if (size.width != to.width || size.height != to.height) continue;
      if (to.index >= size.rates.size()) return refuse(EINVAL);
      to.type = V4L2_FRMIVAL_TYPE_DISCRETE;
      to.discrete = {1, size.rates[to.index]};
      return 0;
    }
    return refuse(EINVAL);
  }
  int set(v4l2_format& to) {
    if (is_multiplanar()) {
      set_format.width = to.fmt.pix_mp.width;
      set_format.height = to.fmt.pix_mp.height;
      set_format.pixelformat = to.fmt.pix_mp.pixelformat;
      to.fmt.pix_mp.plane_fmt[0].bytesperline = answered_bytes_per_line();
      return 0;
    }
    set_format = to.fmt.pix;
    if (answered_code != 0) to.fmt.pix.pixelformat = answered_code;
    to.fmt.pix.bytesperline = answered_bytes_per_line();
    return 0;
  }
  uint32_t answered_bytes_per_line() const {
    if (!tells_bytes_per_line) return 0;
    return bytes_per_line > 0 ? bytes_per_line : 2 * set_format.width;
  }
  int set(v4l2_streamparm& to) const {
    if (answered_rate == 0) return refuse(ENOTTY);
    to.parm.capture.timeperframe = {1, answered_rate};
    return 0;
  }
  int place(v4l2_buffer& to) const {
    const auto offset = static_cast<uint32_t>(to.index * kBufferBytes);
    if (is_multiplanar())
      to.m.planes->length = kBufferBytes, to.m.planes->m.mem_offset = offset;
    else
      to.length = kBufferBytes, to.m.offset = offset;
    return 0;
  }
  int deliver(v4l2_buffer& to) {
    if (arrivals.empty()) return refuse(EAGAIN);
    const Arrival arrival = arrivals.front();
    arrivals.pop_front();
    if (arrival.error != 0) return refuse(arrival.error);
    if (queued.empty()) return refuse(EAGAIN);
    to.index = queued.front();
    queued.pop_front();
    EXPECT_EQ(
        pwrite(memory_.get(), arrival.bytes.data(), arrival.bytes.size(), static_cast<off_t>(to.index * kBufferBytes)),
        static_cast<ssize_t>(arrival.bytes.size()));
    const auto used = static_cast<uint32_t>(arrival.bytes.size());
    if (is_multiplanar())
      to.m.planes->bytesused = used;
    else
      to.bytesused = used;
    to.flags = arrival.flags;
    to.timestamp = arrival.time;
    to.sequence = sequence_++;
    return 0;
  }
  int get(v4l2_control& to) const {
    const auto found = controls.find(to.id);
    if (found == controls.end()) return refuse(EINVAL);
    to.value = found->second;
    return 0;
  }
  int set(const v4l2_control& to) {
    if (!controls.contains(to.id)) return refuse(EINVAL);
    controls[to.id] = to.value;
    written.emplace_back(to.id, to.value);
    return 0;
  }

  UniqueFd memory_;
  uint32_t sequence_ = 0;
};

FakeDevice* device_in_use = nullptr;

class V4l2 : public testing::Test {
 protected:
  V4l2() { device_in_use = &device; }
  ~V4l2() override { device_in_use = nullptr; }

  std::unique_ptr<CameraDevice> open(const std::string& options = "") const {
    return open_v4l2_camera(Url(device.url(options)));
  }
  std::string refusal(const std::string& options = "") const {
    try {
      open(options);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "opened";
  }

  FakeDevice device;
};

std::string frame_of(char fill) { return std::string(64 * 48 * 2, fill); }

TEST_F(V4l2, TheModeNearestToTheWishIsSet) {
  device.formats = {{V4L2_PIX_FMT_YUYV, {{640, 480, {30, 15}}, {1280, 720, {10}}}},
                    {V4L2_PIX_FMT_H264, {{1280, 720, {30}}}},
                    {V4L2_PIX_FMT_MJPEG, {{640, 480, {30}}, {1280, 720, {60, 24, 30}}}}};
  const auto camera = open("?width=1300&height=730&fps=25");
  EXPECT_EQ(device.set_format.pixelformat, V4L2_PIX_FMT_MJPEG);
  EXPECT_EQ(device.set_format.width, 1280U);
  EXPECT_EQ(device.set_format.height, 720U);
  EXPECT_EQ(camera->name(), "Fake");
  const CameraMode mode = camera->mode();
  EXPECT_EQ(mode.format, PixelFormat::mjpeg);
  EXPECT_EQ(mode.width, 1280);
  EXPECT_EQ(mode.height, 720);
  EXPECT_EQ(mode.fps, 24) << "the nearest rate at that size";
  EXPECT_GT(mode.settle_s, 0);
  EXPECT_EQ(open("?format=yuyv")->mode().width, 640) << "10 a second at the wished size are too slow";
}

TEST_F(V4l2, OfSizesInStepsTheNearestIsTaken) {
  device.formats = {{V4L2_PIX_FMT_NV12, {{160, 120, {5}}, {1920, 1080, {60}}}, true}};
  const CameraMode mode = open("?width=645&height=487&fps=30")->mode();
  EXPECT_EQ(mode.width, 640);
  EXPECT_EQ(mode.height, 480);
  EXPECT_EQ(mode.fps, 30);
  const CameraMode fastest = open("?width=9000&height=9000&fps=200")->mode();
  EXPECT_EQ(fastest.width, 1920);
  EXPECT_EQ(fastest.height, 1080);
  EXPECT_EQ(fastest.fps, 60);
  EXPECT_EQ(open("?width=16&height=16&fps=1")->mode().fps, 5);
  device.formats[0].sizes[0].rates[0] = device.formats[0].sizes[1].rates[0] = 1;
  EXPECT_EQ(open("?width=640&height=480")->mode().fps, 1);
}

TEST_F(V4l2, ADeviceThatListsNoSizesOrRatesIsAskedForTheWish) {
  device.formats = {{V4L2_PIX_FMT_YUYV, {}}};
  device.answered_rate = 20;
  const CameraMode mode = open("?width=320&height=200")->mode();
  EXPECT_EQ(mode.width, 320);
  EXPECT_EQ(mode.height, 200);
  EXPECT_EQ(mode.fps, 20) << "what it answers holds";
}

TEST_F(V4l2, WhatIsNoCameraIsRefused) {
  device.formats = {{V4L2_PIX_FMT_H264, {{640, 480, {30}}}}};
  EXPECT_THAT(refusal(), HasSubstr("(Fake) offers none of MJPEG, YUYV, NV12, RGB"));
  device.formats = {{V4L2_PIX_FMT_YUYV, {{64, 48, {30}}}}};
  EXPECT_THAT(refusal("?format=nv12"), HasSubstr("offers no mode of that format"));
  device.answered_code = V4L2_PIX_FMT_H264;
  EXPECT_THAT(refusal(), HasSubstr("insists on a pixel format that is not known here"));
  device.capabilities = V4L2_CAP_VIDEO_CAPTURE;
  EXPECT_THAT(refusal(), HasSubstr("cannot stream into mapped memory"));
  device.capabilities = V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_STREAMING;
  EXPECT_THAT(refusal(), HasSubstr("does not capture video; try another /dev/video number"));
  try {
    open_v4l2_camera(Url("v4l2:/nowhere/video0"));
    FAIL();
  } catch (const std::system_error& error) {
    EXPECT_EQ(error.code(), std::errc::no_such_file_or_directory);
    EXPECT_STREQ(error.what(),
                 "cannot open the camera '/nowhere/video0': No such file or directory: 'ls /dev/video*' lists those "
                 "connected");
  }
}

TEST_F(V4l2, EveryCallThatFailsIsTold) {
  device.failing = VIDIOC_QUERYCAP;
  EXPECT_THAT(refusal(), HasSubstr("is not a V4L2 device"));
  device.failing = VIDIOC_S_FMT;
  EXPECT_THAT(refusal(), HasSubstr("cannot set the video mode of"));
  device.failing = 0;
  const auto camera = open();
  const std::pair<unsigned long, const char*> calls[] = {{VIDIOC_REQBUFS, "cannot get buffers"},
                                                         {VIDIOC_QUERYBUF, "cannot query a buffer"},
                                                         {VIDIOC_QBUF, "cannot queue a buffer"},
                                                         {VIDIOC_STREAMON, "cannot start streaming"}};
  for (const auto& [call, says] : calls) {
    device.failing = call;
    try {
      camera->start();
      ADD_FAILURE() << says;
    } catch (const CameraLost& lost) {
      EXPECT_THAT(lost.what(), HasSubstr(std::string(says) + ": Device or resource busy"));
    }
  }
}

TEST_F(V4l2, AFrameIsReadWhereItLiesAndGivesItsBufferBack) {
  const auto camera = open();
  camera->start();
  EXPECT_TRUE(device.streams);
  EXPECT_THAT(device.queued, ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_FALSE(camera->read());
  device.arrivals = {{frame_of('a')}, {frame_of('b')}};
  auto first = camera->read(), second = camera->read();
  ASSERT_TRUE(first && second);
  EXPECT_FALSE(camera->read());
  EXPECT_EQ(first->sequence, 0);
  EXPECT_EQ(second->sequence, 1);
  EXPECT_EQ(first->time_ns, 5'000'250'000);
  EXPECT_EQ(first->width, 64);
  EXPECT_EQ(first->height, 48);
  ASSERT_EQ(second->planes.size(), 1U);
  EXPECT_EQ(second->planes[0].stride, 128);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(second->planes[0].bytes), second->planes[0].size), frame_of('b'));
  EXPECT_THAT(device.queued, ElementsAre(2, 3, 4, 5));
  first.reset();
  EXPECT_THAT(device.queued, ElementsAre(2, 3, 4, 5, 0));
  camera->stop();
  EXPECT_FALSE(device.streams);
  second.reset();
  EXPECT_THAT(device.queued, ElementsAre(2, 3, 4, 5, 0)) << "a stopped camera takes none";
}

TEST_F(V4l2, AFrameOutlivesItsCamera) {
  auto camera = open();
  camera->start();
  device.arrivals = {{frame_of('c')}};
  const auto frame = camera->read();
  ASSERT_TRUE(frame);
  camera->start();  // anew, with other buffers
  EXPECT_TRUE(device.streams);
  camera.reset();
  EXPECT_EQ(frame->planes[0].bytes[64 * 48 * 2 - 1], 'c');
}

TEST_F(V4l2, DamagedFramesArePassedOver) {
  const auto camera = open();
  camera->start();
  Arrival broken{frame_of('x')};
  broken.flags |= V4L2_BUF_FLAG_ERROR;
  device.arrivals = {broken, {""}, {frame_of('x').substr(1)}, {frame_of('d')}};
  const auto frame = camera->read();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->planes[0].bytes[0], 'd');
  EXPECT_THAT(device.queued, ElementsAre(4, 5, 0, 1, 2));
}

// Else a frame cut short would be taken for whole, and read beyond its end.
TEST_F(V4l2, ADriverThatTellsNoLengthOfRowsHasRowsWithoutGaps) {
  device.tells_bytes_per_line = false;
  const std::string whole(2 * 64 * 48, 'y');
  const auto camera = open("");
  camera->start();
  device.arrivals = {{whole.substr(1)}, {whole}};
  const auto frame = camera->read();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->sequence, 1);
  EXPECT_EQ(frame->planes[0].stride, 128);
}

TEST_F(V4l2, PlanesOfEachFormatLieWhereItsRowsEnd) {
  const std::string rows(100 * 48, 'y'), chroma(100 * 24, 'c');
  device.formats = {{V4L2_PIX_FMT_NV12, {{64, 48, {30}}}}, {V4L2_PIX_FMT_MJPEG, {{64, 48, {30}}}}};
  device.bytes_per_line = 100;
  const auto camera = open("?format=nv12");
  camera->start();
  device.arrivals = {{rows + chroma.substr(1)}, {rows + chroma}};
  const auto frame = camera->read();
  ASSERT_TRUE(frame && frame->planes.size() == 2);
  EXPECT_EQ(frame->sequence, 1);
  EXPECT_EQ(frame->planes[0].size, rows.size());
  EXPECT_EQ(frame->planes[1].size, chroma.size());
  EXPECT_EQ(frame->planes[1].bytes[0], 'c');
  EXPECT_EQ(frame->planes[1].stride, 100);
  const auto jpeg = open("?format=mjpeg");
  jpeg->start();
  device.arrivals = {{"no JPEG"}, {"\xFF\xD8\xFF"}, {"\xFF\xD8 a file"}};
  const auto file = jpeg->read();
  ASSERT_TRUE(file && file->planes.size() == 1);
  EXPECT_EQ(file->planes[0].size, 9U);
  EXPECT_EQ(file->planes[0].stride, 0);
}

TEST_F(V4l2, ADeviceOfSeveralPlanesIsReadTheSame) {
  device.capabilities = V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING;
  const auto camera = open();
  EXPECT_EQ(device.set_format.width, 64U);
  camera->start();
  device.arrivals = {{frame_of('e')}};
  const auto frame = camera->read();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->planes[0].bytes[17], 'e');
  EXPECT_EQ(frame->planes[0].stride, 128);
}

TEST_F(V4l2, WithoutAMonotonicTimeAFrameIsOfNow) {
  const auto camera = open();
  camera->start();
  Arrival arrival{frame_of('f')};
  arrival.flags = V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN;
  device.arrivals = {arrival};
  const int64_t before = monotonic_now_ns();
  const auto frame = camera->read();
  ASSERT_TRUE(frame);
  EXPECT_GE(frame->time_ns, before);
  EXPECT_LE(frame->time_ns, monotonic_now_ns());
}

TEST_F(V4l2, AFewErrorsAreBorneAndMoreAreTheEnd) {
  const auto camera = open();
  camera->start();
  const Arrival error{"", EIO};
  device.arrivals = {error, error, error, error, {frame_of('g')}, error, error, error, error};
  EXPECT_TRUE(camera->read());
  EXPECT_FALSE(camera->read());
  device.arrivals = {error};
  EXPECT_THROW(camera->read(), CameraLost);
}

TEST_F(V4l2, WhatWasUnpluggedIsLost) {
  const auto camera = open();
  camera->start();
  device.arrivals = {{"", ENODEV}};
  try {
    camera->read();
    FAIL();
  } catch (const CameraLost& lost) {
    EXPECT_THAT(lost.what(), HasSubstr("it was disconnected"));
  }
  device.buffers_given = 1;
  EXPECT_THROW(camera->start(), CameraLost) << "too little memory";
}

TEST_F(V4l2, LockedExposureKeepsItsValuesAndIsLetGoAgain) {
  device.controls = {{V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_APERTURE_PRIORITY},
                     {V4L2_CID_EXPOSURE_ABSOLUTE, 156},
                     {V4L2_CID_AUTOGAIN, 1},
                     {V4L2_CID_GAIN, 7},
                     {V4L2_CID_AUTO_WHITE_BALANCE, 1},
                     {V4L2_CID_WHITE_BALANCE_TEMPERATURE, 4600},
                     {V4L2_CID_FOCUS_AUTO, 1}};
  const auto before = device.controls;
  {
    const auto camera = open();
    EXPECT_TRUE(camera->lock_exposure(true));
    EXPECT_EQ(device.controls[V4L2_CID_EXPOSURE_AUTO], V4L2_EXPOSURE_MANUAL);
    EXPECT_EQ(device.controls[V4L2_CID_FOCUS_AUTO], 0);
    using Written = std::pair<uint32_t, int32_t>;
    EXPECT_THAT(
        device.written,
        ElementsAre(Written(V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL), Written(V4L2_CID_EXPOSURE_ABSOLUTE, 156),
                    Written(V4L2_CID_AUTOGAIN, 0), Written(V4L2_CID_GAIN, 7), Written(V4L2_CID_AUTO_WHITE_BALANCE, 0),
                    Written(V4L2_CID_WHITE_BALANCE_TEMPERATURE, 4600), Written(V4L2_CID_FOCUS_AUTO, 0)));
    EXPECT_TRUE(camera->lock_exposure(false));
    EXPECT_EQ(device.controls, before);
    EXPECT_TRUE(camera->lock_exposure(true));
  }
  EXPECT_EQ(device.controls, before) << "closing the camera lets go, too";
  device.controls = {{V4L2_CID_GAIN, 7}};
  EXPECT_FALSE(open()->lock_exposure(true)) << "it cannot";
}

}  // namespace

int call(int, unsigned long request, void* argument) { return device_in_use->answer(request, argument); }

}  // namespace ldp::v4l2
