// The C interface against the C++ behind it: the same planes, views and files, and every refusal as a status and words.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/captures/opengl_pose.h"
#include "core/panorama/file/ldp_file.h"
#include "core/view/camera_path.h"
#include "core/view/framing.h"
#include "core/view/render.h"
#include "device/library/ldp.h"
#include "tests/golden/synthetic_panorama.h"

namespace ldp {
namespace {

using testing::HasSubstr;

struct Close {
  void operator()(ldp_panorama* panorama) const { ldp_close(panorama); }
  void operator()(ldp_writer* writer) const { ldp_writer_free(writer); }
  void operator()(ldp_stop* stop) const { ldp_stop_free(stop); }
};
using Open = std::unique_ptr<ldp_panorama, Close>;
using Writer = std::unique_ptr<ldp_writer, Close>;

const SyntheticOptions kBlocks{200, 90, 12, 3, true, Rays::pushbroom, false};

std::vector<uint8_t> file_of(const SyntheticOptions& options) { return encode_ldp(synthetic_panorama(options), {}); }

Open open(const std::vector<uint8_t>& file) {
  ldp_panorama* panorama = nullptr;
  ldp_error error{};
  EXPECT_EQ(ldp_open_memory(file.data(), file.size(), nullptr, &panorama, &error), LDP_OK) << error.message;
  return Open(panorama);
}

struct Picture {
  std::vector<uint8_t> rgb, alpha;
  std::vector<float> depth;
  friend bool operator==(const Picture&, const Picture&) = default;
};

Picture picture_of(ldp_panorama& panorama, const ldp_camera& camera, int threads, int fill = LDP_FILL_NONE) {
  const auto pixels = static_cast<size_t>(camera.width) * static_cast<size_t>(camera.height);
  Picture picture{std::vector<uint8_t>(3 * pixels), std::vector<uint8_t>(pixels), std::vector<float>(pixels)};
  ldp_view view = LDP_INIT(ldp_view);
  view.threads = threads;
  view.fill = fill;
  view.rgb = picture.rgb.data(), view.alpha = picture.alpha.data(), view.depth = picture.depth.data();
  ldp_error error{};
  EXPECT_EQ(ldp_render(&panorama, &camera, &view, &error), LDP_OK) << error.message;
  return picture;
}

std::vector<ldp_camera> path_of(ldp_panorama& panorama, int frames) {
  std::vector<ldp_camera> cameras(static_cast<size_t>(frames));
  cameras[0] = LDP_INIT(ldp_camera);
  cameras[0].width = 120, cameras[0].height = 90;
  EXPECT_EQ(ldp_cameras_on_path(&panorama, "sway", frames, 1, cameras.data(), nullptr), LDP_OK);
  return cameras;
}

TEST(Library, DescribesWhatTheFileHolds) {
  const std::vector<uint8_t> file = file_of(kBlocks);
  const Open panorama = open(file);
  const LayeredPanorama truth = synthetic_panorama(kBlocks);
  ldp_description told = LDP_INIT(ldp_description);
  ASSERT_EQ(ldp_describe(panorama.get(), &told, nullptr), LDP_OK);
  EXPECT_EQ(std::tuple(told.width, told.height, told.layers, told.cameras), std::tuple(200, 90, 3, 3));
  EXPECT_EQ(told.file_bytes, file.size());
  EXPECT_EQ(told.rays, LDP_RAYS_PUSHBROOM);
  EXPECT_EQ(std::tuple(told.theta_left, told.v_pitch, told.near_inverse_depth, told.arc_radius, told.max_height),
            std::tuple(1.75, 1.0 / 64, 1.25, 0.65, 0.125));
  EXPECT_EQ(std::tuple(told.arc_centre[0], told.arc_centre[1], told.arc_centre[2]), std::tuple(0.5, -0.25, 1.625));
  ldp_camera camera = LDP_INIT(ldp_camera);
  const char* name = nullptr;
  ASSERT_EQ(ldp_get_camera(panorama.get(), 1, &camera, &name, nullptr), LDP_OK);
  EXPECT_STREQ(name, "frame_001.jpg");
  EXPECT_EQ(camera.fl_y, 64.5);
  const Eigen::Matrix4d pose = opengl_matrix(truth.cameras[1].pose);
  for (int i = 0; i < 16; ++i) EXPECT_EQ(camera.world_from_camera[i], pose(i / 4, i % 4));
  double value = 0;
  ASSERT_EQ(ldp_get_quality(panorama.get(), 1, &name, &value, nullptr), LDP_OK);
  EXPECT_EQ(std::pair(std::string(name), value), std::pair(std::string("psnr_leave_one_out_db"), 24.25));
  const char* text = nullptr;
  ASSERT_EQ(ldp_get_metadata(panorama.get(), 2, &name, &text, nullptr), LDP_OK);
  EXPECT_EQ(std::pair(std::string(name), std::string(text)), std::pair(std::string("unit"), std::string("metre")));
  const uint8_t* thumbnail = nullptr;
  size_t count = 0;
  ASSERT_EQ(ldp_get_thumbnail(panorama.get(), &thumbnail, &count, nullptr), LDP_OK);
  ASSERT_GT(count, 2U);
  EXPECT_EQ(std::pair(thumbnail[0], thumbnail[1]), std::pair(uint8_t{0xFF}, uint8_t{0xD8}));
  EXPECT_EQ(ldp_verify(panorama.get(), nullptr, nullptr), LDP_OK);
}

// A part of a layer, from a column inside a block, into rows longer than it.
TEST(Library, ReadsPlanesAsTheReaderDoes) {
  const std::vector<uint8_t> file = file_of(kBlocks);
  const LayeredPanorama truth = decode_ldp(file);
  const Open panorama = open(file);
  constexpr int kBegin = 17, kEnd = 143, kRow = 130;
  constexpr size_t kPixels = size_t{kRow} * 90;
  for (size_t l = 0; l < 3; ++l) {
    std::vector<float> depth(kPixels, -1);
    std::vector<uint16_t> disparity(kPixels, 7);
    std::vector<uint8_t> coverage(kPixels), alpha(kPixels), rgb(3 * kPixels);
    ldp_planes planes = LDP_INIT(ldp_planes);
    planes.begin = kBegin, planes.end = kEnd, planes.row_pixels = kRow, planes.threads = 2;
    planes.depth = depth.data(), planes.disparity = disparity.data(), planes.coverage = coverage.data();
    planes.alpha = alpha.data(), planes.rgb = rgb.data();
    ldp_error error{};
    ASSERT_EQ(ldp_read_planes(panorama.get(), static_cast<int>(l), &planes, &error), LDP_OK) << error.message;
    const Layer& layer = truth.layers[l];
    const DisparityMap map = decode_depth(layer.depth, layer.coverage);
    for (int y = 0; y < 90; ++y) {
      for (int x = kBegin; x < kEnd; ++x) {
        const size_t at = static_cast<size_t>(y * kRow + x - kBegin);
        ASSERT_EQ(disparity[at], map.at(x, y));
        ASSERT_EQ(coverage[at], layer.coverage.at(x, y));
        ASSERT_EQ(alpha[at], layer.alpha.at(x, y));
        ASSERT_EQ((Rgb{rgb[3 * at], rgb[3 * at + 1], rgb[3 * at + 2]}), layer.colour.at(x, y));
        const double w = 1.25 * map.at(x, y) / 3825;
        if (map.at(x, y) == kNoDisparity)
          ASSERT_EQ(depth[at], 0);
        else
          ASSERT_NEAR(depth[at] * w, 1, 1e-6);
      }
      ASSERT_EQ(depth[static_cast<size_t>(y * kRow + kEnd - kBegin)], -1) << "written beyond the part";
    }
  }
}

TEST(Library, RendersTheBytesOfTheRenderer) {
  const std::vector<uint8_t> file = file_of(kBlocks);
  const LayeredPanorama truth = decode_ldp(file);
  const Renderer renderer(truth);
  const Open panorama = open(file);
  const CameraPathOptions path{CameraPath::sway, 4, 120, 90, 1};
  const std::vector<Camera> cameras = camera_path(truth, framed_inside(truth, renderer, path));
  const std::vector<ldp_camera> same = path_of(*panorama, 4);
  for (size_t i = 0; i < cameras.size(); ++i) {
    for (const Fill fill : {Fill::none, Fill::background}) {
      const View view = renderer.render(cameras[i], {.fill = fill, .depth = true});
      const Picture picture =
          picture_of(*panorama, same[i], 2, fill == Fill::none ? LDP_FILL_NONE : LDP_FILL_BACKGROUND);
      EXPECT_EQ(std::memcmp(picture.rgb.data(), view.colour.samples.data(), picture.rgb.size()), 0);
      EXPECT_EQ(std::memcmp(picture.alpha.data(), view.alpha.samples.data(), picture.alpha.size()), 0);
      EXPECT_EQ(std::memcmp(picture.depth.data(), view.depth.samples.data(), 4 * picture.depth.size()), 0);
      EXPECT_GT(std::count(picture.alpha.begin(), picture.alpha.end(), 255), 1000);
    }
  }
}

// No view asked for beforehand: all eight threads come upon a renderer that is not there yet.
TEST(Library, EightThreadsRenderFromOneFile) {
  const std::vector<uint8_t> file = file_of(kBlocks);
  const Open alone = open(file), shared = open(file);
  const std::vector<ldp_camera> cameras = path_of(*alone, 8);
  std::vector<Picture> expected, found(8);
  for (const ldp_camera& camera : cameras) expected.push_back(picture_of(*alone, camera, 1));
  {
    std::vector<std::jthread> threads;
    for (size_t t = 0; t < 8; ++t)
      threads.emplace_back([&, t] {
        found[t] = picture_of(*shared, cameras[t], 1 + static_cast<int>(t % 2));
        std::vector<uint8_t> coverage(200 * 90);
        ldp_planes planes = LDP_INIT(ldp_planes);
        planes.coverage = coverage.data();
        EXPECT_EQ(ldp_read_planes(shared.get(), static_cast<int>(t % 3), &planes, nullptr), LDP_OK);
      });
  }
  EXPECT_EQ(found, expected);
}

TEST(Library, WritesWhatItRead) {
  const std::vector<uint8_t> file = encode_ldp(synthetic_panorama(kBlocks), {101, LdpCodec::none});
  const Open panorama = open(file);
  ldp_writer* begun = nullptr;
  ASSERT_EQ(ldp_writer_from(panorama.get(), &begun, nullptr), LDP_OK);
  const Writer writer(begun);
  void* bytes = nullptr;
  size_t count = 0;
  ASSERT_EQ(ldp_writer_encode(writer.get(), 101, &bytes, &count, nullptr), LDP_OK);
  EXPECT_TRUE(std::equal(file.begin(), file.end(), static_cast<uint8_t*>(bytes), static_cast<uint8_t*>(bytes) + count));
  ldp_free(bytes);
}

// Layer by layer from planes alone, over the whole grid: depths as 4-bit codes, all else as it was.
TEST(Library, WritesAFileFromPlanes) {
  const Open panorama = open(encode_ldp(synthetic_panorama(kBlocks), {101, LdpCodec::none}));
  ldp_description told = LDP_INIT(ldp_description);
  ASSERT_EQ(ldp_describe(panorama.get(), &told, nullptr), LDP_OK);
  ldp_writer* begun = nullptr;
  ASSERT_EQ(ldp_writer_new(&told, &begun, nullptr), LDP_OK);
  const Writer writer(begun);
  std::vector<uint16_t> disparity(200 * 90), again(200 * 90);
  std::vector<uint8_t> rgb(3 * 200 * 90), alpha(200 * 90), rgb_again(3 * 200 * 90);
  ldp_planes planes = LDP_INIT(ldp_planes);
  planes.disparity = disparity.data(), planes.rgb = rgb.data(), planes.alpha = alpha.data();
  ldp_error error{};
  for (int layer = 0; layer < 3; ++layer) {
    ASSERT_EQ(ldp_read_planes(panorama.get(), layer, &planes, nullptr), LDP_OK);
    ASSERT_EQ(ldp_writer_add_layer(writer.get(), &planes, 12, &error), LDP_OK) << error.message;
  }
  ldp_camera camera = LDP_INIT(ldp_camera);
  ASSERT_EQ(ldp_get_camera(panorama.get(), 0, &camera, nullptr, nullptr), LDP_OK);
  ASSERT_EQ(ldp_writer_add_camera(writer.get(), "one.jpg", &camera, &error), LDP_OK) << error.message;
  ASSERT_EQ(ldp_writer_set_metadata(writer.get(), "device", "a test", nullptr), LDP_OK);
  ASSERT_EQ(ldp_writer_set_quality(writer.get(), "figure", 3, nullptr), LDP_OK);
  const std::string path = testing::TempDir() + "library_" + std::to_string(::getpid()) + ".ldp";
  ASSERT_EQ(ldp_writer_save(writer.get(), path.c_str(), 101, &error), LDP_OK) << error.message;
  ldp_panorama* reopened = nullptr;
  ASSERT_EQ(ldp_open_file(path.c_str(), nullptr, &reopened, &error), LDP_OK) << error.message;
  const Open written(reopened);
  std::filesystem::remove(path);
  const char* name = nullptr;
  ASSERT_EQ(ldp_get_camera(written.get(), 0, nullptr, &name, nullptr), LDP_OK);
  EXPECT_STREQ(name, "one.jpg");
  ASSERT_EQ(ldp_read_planes(panorama.get(), 1, &planes, nullptr), LDP_OK);
  planes.disparity = again.data(), planes.rgb = rgb_again.data();
  ASSERT_EQ(ldp_read_planes(written.get(), 1, &planes, nullptr), LDP_OK);
  DisparityMap map(200, 90);
  Plane<uint8_t> coverage(200, 90);
  for (size_t i = 0; i < disparity.size(); ++i) {
    map.samples[i] = disparity[i];
    coverage.samples[i] = disparity[i] == kNoDisparity ? 0 : 1;
  }
  const DisparityMap coded = decode_depth(encode_depth(map, 12), coverage);
  EXPECT_TRUE(std::equal(again.begin(), again.end(), coded.samples.begin()));
  EXPECT_EQ(rgb_again, rgb);
}

// What has been written so far, opened.
Open encoded(const Writer& writer) {
  void* bytes = nullptr;
  size_t count = 0;
  EXPECT_EQ(ldp_writer_encode(writer.get(), 101, &bytes, &count, nullptr), LDP_OK);
  const auto* const first = static_cast<uint8_t*>(bytes);
  Open written = open({first, first + count});
  ldp_free(bytes);
  return written;
}

TEST(Library, DepthsAreWrittenAsTheNearestDisparities) {
  ldp_description told = LDP_INIT(ldp_description);
  ASSERT_EQ(ldp_describe(open(file_of(kBlocks)).get(), &told, nullptr), LDP_OK);
  told.width = 4, told.height = 1;
  ldp_writer* begun = nullptr;
  ASSERT_EQ(ldp_writer_new(&told, &begun, nullptr), LDP_OK);
  const Writer writer(begun);
  const float infinity = std::numeric_limits<float>::infinity();
  std::vector<float> depth{0.8F, 0, infinity, 12}, again(4);  // the nearest there is, nothing, the farthest, label 1
  std::vector<uint8_t> rgb(12, 100);
  ldp_planes planes = LDP_INIT(ldp_planes);
  planes.depth = depth.data(), planes.rgb = rgb.data();
  ASSERT_EQ(ldp_writer_add_layer(writer.get(), &planes, 0, nullptr), LDP_OK);
  const Open written = encoded(writer);
  planes.depth = again.data();
  ASSERT_EQ(ldp_read_planes(written.get(), 0, &planes, nullptr), LDP_OK);
  EXPECT_EQ(again, depth);
}

TEST(Library, WhereTheGridHasOneDepthThatIsWritten) {
  ldp_description told = LDP_INIT(ldp_description);
  ASSERT_EQ(ldp_describe(open(file_of(kBlocks)).get(), &told, nullptr), LDP_OK);
  told.width = 4, told.height = 1;
  const float infinity = std::numeric_limits<float>::infinity();
  for (const double only : {0.0, 0.25}) {
    told.far_inverse_depth = told.near_inverse_depth = only;
    ldp_writer* begun = nullptr;
    ASSERT_EQ(ldp_writer_new(&told, &begun, nullptr), LDP_OK);
    const Writer writer(begun);
    std::vector<float> depth{infinity, 4, 0, 1}, again(4);
    std::vector<uint16_t> disparity(4);
    std::vector<uint8_t> rgb(12, 100);
    ldp_planes planes = LDP_INIT(ldp_planes);
    planes.depth = depth.data(), planes.rgb = rgb.data();
    ASSERT_EQ(ldp_writer_add_layer(writer.get(), &planes, 0, nullptr), LDP_OK);
    const Open written = encoded(writer);
    planes.depth = again.data(), planes.disparity = disparity.data();
    ASSERT_EQ(ldp_read_planes(written.get(), 0, &planes, nullptr), LDP_OK);
    const float expected = static_cast<float>(1 / only);
    EXPECT_EQ(again, (std::vector<float>{expected, expected, 0, expected}));
    EXPECT_EQ(disparity, (std::vector<uint16_t>{0, 0, LDP_NO_DISPARITY, 0}));
  }
}

class Refusals : public testing::Test {
 protected:
  void expect(ldp_status found, ldp_status status, const std::string& words) const {
    EXPECT_EQ(found, status) << error_.message;
    EXPECT_EQ(error_.status, status);
    EXPECT_THAT(error_.message, HasSubstr(words));
  }
  std::vector<uint8_t> file_ = file_of(kBlocks);
  Open panorama_ = open(file_);
  ldp_error error_{};
};

TEST_F(Refusals, OfWhatCannotBeOpened) {
  ldp_panorama* opened = nullptr;
  expect(ldp_open_file("/no/such.ldp", nullptr, &opened, &error_), LDP_NOT_READABLE, "open /no/such.ldp: ");
  expect(ldp_open_file("/dev/zero", nullptr, &opened, &error_), LDP_NOT_READABLE, "is no regular file");
  expect(ldp_open_file(nullptr, nullptr, &opened, &error_), LDP_BAD_ARGUMENT, "path is a null pointer");
  expect(ldp_open_memory("no panorama", 11, nullptr, &opened, &error_), LDP_DAMAGED, "open a panorama in memory: ");
  file_[file_.size() / 2] ^= 1;
  const Open damaged = open(file_);  // its table is sound
  expect(ldp_verify(damaged.get(), nullptr, &error_), LDP_DAMAGED, "verify a panorama: ");
  EXPECT_EQ(opened, nullptr);
}

TEST_F(Refusals, BeyondLimits) {
  ldp_panorama* opened = nullptr;
  ldp_limits limits = LDP_INIT(ldp_limits);
  limits.pixels = 200 * 90 - 1;
  expect(ldp_open_memory(file_.data(), file_.size(), &limits, &opened, &error_), LDP_BEYOND_LIMITS, "18000 pixels");
  limits.pixels = 0, limits.memory_bytes = file_.size() + 1000;
  ASSERT_EQ(ldp_open_memory(file_.data(), file_.size(), &limits, &opened, &error_), LDP_OK);
  const Open small(opened);
  std::vector<uint8_t> coverage(200 * 90);
  ldp_planes planes = LDP_INIT(ldp_planes);
  planes.coverage = coverage.data();
  expect(ldp_read_planes(small.get(), 0, &planes, &error_), LDP_BEYOND_LIMITS, "read layer 0: reading may need");
  expect(ldp_prepare(small.get(), 1, nullptr, &error_), LDP_BEYOND_LIMITS, "preparing views may need");
  limits.memory_bytes = 10;
  expect(ldp_open_memory(file_.data(), file_.size(), &limits, &opened, &error_), LDP_BEYOND_LIMITS, "allowed are 10");
}

TEST_F(Refusals, OfWhatCannotBeMeant) {
  ldp_camera camera = path_of(*panorama_, 1)[0];
  ldp_view view = LDP_INIT(ldp_view);
  ldp_planes planes = LDP_INIT(ldp_planes);
  expect(ldp_read_planes(panorama_.get(), 3, &planes, &error_), LDP_BAD_ARGUMENT, "there is no layer 3 of 3");
  planes.begin = 5, planes.end = 201;
  expect(ldp_read_planes(panorama_.get(), 0, &planes, &error_), LDP_BAD_ARGUMENT, "columns 5 to 201");
  planes.end = 50, planes.row_pixels = 44;
  expect(ldp_read_planes(panorama_.get(), 0, &planes, &error_), LDP_BAD_ARGUMENT, "row_pixels is 44");
  view.struct_bytes = 8;
  expect(ldp_render(panorama_.get(), &camera, &view, &error_), LDP_BAD_ARGUMENT, "set it by LDP_INIT");
  view = LDP_INIT(ldp_view);
  view.threads = -1;
  expect(ldp_render(panorama_.get(), &camera, &view, &error_), LDP_BAD_ARGUMENT, "threads is -1");
  view.threads = 0, view.fill = 2;
  expect(ldp_render(panorama_.get(), &camera, &view, &error_), LDP_BAD_ARGUMENT, "view->fill is 2");
  camera.width = 0;
  expect(ldp_render(panorama_.get(), &camera, &view, &error_), LDP_BAD_ARGUMENT, "0x90 pixels");
  camera.width = 120, camera.world_from_camera[12] = 0.5;
  expect(ldp_render(panorama_.get(), &camera, &view, &error_), LDP_BAD_ARGUMENT, "is it transposed?");
  camera.world_from_camera[12] = 0, camera.world_from_camera[0] += 0.5;
  expect(ldp_render(panorama_.get(), &camera, &view, &error_), LDP_BAD_ARGUMENT, "is not a rotation");
  camera.fl_x = std::nan("");
  expect(ldp_render(panorama_.get(), &camera, &view, &error_), LDP_BAD_ARGUMENT, "not finite");
  expect(ldp_cameras_on_path(panorama_.get(), "spiral", 1, 0, &camera, &error_), LDP_BAD_ARGUMENT, "spiral");
  camera.width = 0;
  expect(ldp_cameras_on_path(panorama_.get(), "sway", 1, 0, &camera, &error_), LDP_BAD_ARGUMENT,
         "width is 0; must be 1 to 16384");
  camera.width = 120;
  expect(ldp_cameras_on_path(panorama_.get(), "sway", 1, 4, &camera, &error_), LDP_BAD_ARGUMENT,
         "the field of view in radians is 4; must be 0 to 3");
  expect(ldp_describe(nullptr, nullptr, &error_), LDP_BAD_ARGUMENT, "description is a null pointer");
}

// A caller of a later version of the header, and one that sets what this version does not know.
TEST_F(Refusals, OfFieldsThatAreNotKnownYet) {
  struct Later {
    ldp_view view;
    int64_t more;
  } later{LDP_INIT(ldp_view), 0};
  later.view.struct_bytes = sizeof later;
  const ldp_camera camera = path_of(*panorama_, 1)[0];
  EXPECT_EQ(ldp_render(panorama_.get(), &camera, &later.view, &error_), LDP_OK);
  later.more = 1;
  expect(ldp_render(panorama_.get(), &camera, &later.view, &error_), LDP_BAD_ARGUMENT, "does not know");
}

TEST_F(Refusals, OnceStopped) {
  const std::unique_ptr<ldp_stop, Close> stop(ldp_stop_new());
  ldp_stop_request(stop.get());
  expect(ldp_prepare(panorama_.get(), 1, stop.get(), &error_), LDP_STOPPED, "prepare views: stopped");
  ldp_view view = LDP_INIT(ldp_view);
  view.stop = stop.get();
  const ldp_camera camera = path_of(*panorama_, 1)[0];
  expect(ldp_render(panorama_.get(), &camera, &view, &error_), LDP_STOPPED, "stopped");
  view.stop = nullptr;  // what was stopped can be done again
  EXPECT_EQ(ldp_render(panorama_.get(), &camera, &view, &error_), LDP_OK);
}

TEST_F(Refusals, OfFilesThatNoReaderWouldTake) {
  ldp_description told = LDP_INIT(ldp_description);
  ASSERT_EQ(ldp_describe(panorama_.get(), &told, nullptr), LDP_OK);
  ldp_writer* begun = nullptr;
  ldp_description wide = told;
  wide.width = 70000;
  expect(ldp_writer_new(&wide, &begun, &error_), LDP_BAD_ARGUMENT, "width is 70000");
  told.theta_pitch = std::nan("");
  ASSERT_EQ(ldp_writer_new(&told, &begun, nullptr), LDP_OK);
  const Writer writer(begun);
  void* bytes = nullptr;
  size_t count = 0;
  expect(ldp_writer_encode(writer.get(), 0, &bytes, &count, &error_), LDP_BAD_ARGUMENT, "1 to 8 layers");
  std::vector<float> depth(200 * 90, -1);
  std::vector<uint8_t> rgb(3 * 200 * 90);
  ldp_planes planes = LDP_INIT(ldp_planes);
  planes.depth = depth.data();
  expect(ldp_writer_add_layer(writer.get(), &planes, 16, &error_), LDP_BAD_ARGUMENT, "planes->rgb is a null");
  planes.rgb = rgb.data();
  expect(ldp_writer_add_layer(writer.get(), &planes, 16, &error_), LDP_BAD_ARGUMENT, "depth is negative");
  depth.assign(depth.size(), 2);
  ASSERT_EQ(ldp_writer_add_layer(writer.get(), &planes, 16, &error_), LDP_OK);
  expect(ldp_writer_encode(writer.get(), 0, &bytes, &count, &error_), LDP_BAD_ARGUMENT, "HEAD");
  expect(ldp_writer_save(writer.get(), "/no/such/folder/a.ldp", 102, &error_), LDP_BAD_ARGUMENT, "colour_quality");
  EXPECT_EQ(bytes, nullptr);
}

}  // namespace
}  // namespace ldp
