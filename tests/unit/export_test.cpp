#include "core/export/export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <span>
#include <stdexcept>

#include "core/captures/transforms.h"
#include "core/export/equirectangular.h"
#include "core/export/surface.h"
#include "core/panorama/file/ldp_file.h"
#include "core/photos/images.h"
#include "tests/golden/synthetic_panorama.h"

namespace ldp {
namespace {

using ::testing::HasSubstr;

LayeredPanorama plane_panorama(int width, int height, uint16_t disparity) {
  LayeredPanorama panorama = synthetic_panorama({width, height, 0, 1});
  DisparityMap map(width, height, disparity);
  panorama.layers[0].depth = encode_depth(map, 0);
  return panorama;
}

uint32_t u32(const std::vector<uint8_t>& bytes, size_t at) {
  return uint32_t{bytes[at]} | uint32_t{bytes[at + 1]} << 8 | uint32_t{bytes[at + 2]} << 16 |
         uint32_t{bytes[at + 3]} << 24;
}

TEST(ExportFlat, RowsLieAtTheirElevation) {
  LayeredPanorama panorama = plane_panorama(64, 300, 0);
  panorama.grid.theta_pitch = panorama.grid.v_pitch = 1.0 / 150;
  panorama.grid.v_top = 1;
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 64; ++x) panorama.layers[0].colour.at(x, y) = {static_cast<uint8_t>(y * 250 / 299), 0, 0};
  const FlatPanorama flat = flatten(panorama);
  EXPECT_EQ(flat.image.height, std::lround(std::numbers::pi / 2 * 150)) << "45 degrees up to 45 degrees down";
  for (int y = 5; y < flat.image.height - 5; y += 10) {
    const double elevation = std::numbers::pi / 4 - (y + 0.5) / 150;
    const double row = (1 - std::tan(elevation)) * 150 - 0.5;
    EXPECT_NEAR(flat.image.at(3, y).r, row * 250 / 299, 1.6);
  }
  EXPECT_EQ(flat.full_width, 942);
  EXPECT_EQ(flat.full_height, 471);
  EXPECT_EQ(flat.top, std::lround(std::numbers::pi / 4 * 150));
}

// Red on one half, blue on the other, and nothing above: the turn closes between the two.
TEST(ExportFlat, WhatIsFilledOfAFullTurnClosesWithoutASeam) {
  LayeredPanorama panorama = synthetic_panorama({800, 120, 8, 1, false, Rays::pushbroom, true});
  Layer& front = panorama.layers[0];
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 800; ++x) {
      front.coverage.at(x, y) = y < 60 ? 0 : 1;
      front.colour.at(x, y) = x < 400 ? Rgb{250, 0, 0} : Rgb{0, 0, 250};
    }
  const RgbImage flat = flatten(panorama).image;
  ASSERT_EQ(flat.width, 800);
  const auto step = [&](int left, int right) { return std::abs(flat.at(left, 2).r - flat.at(right, 2).r); };
  EXPECT_LE(step(799, 0), 2 * step(399, 400) + 2);
  EXPECT_NEAR(flat.at(0, 2).r, 125, 15) << "as much of the one as of the other";
}

// The border cuts what is near as well as what is far: beyond it both go on.
TEST(ExportFlat, BeyondTheBorderAllGoesOn) {
  LayeredPanorama panorama = plane_panorama(120, 60, 3000);
  Layer& front = panorama.layers[0];
  DisparityMap depth(120, 60, 3000);
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 120; ++x) {
      if (x >= 60) depth.at(x, y) = 500;
      front.colour.at(x, y) = x < 60 ? Rgb{250, 0, 0} : Rgb{0, 0, 250};
      front.coverage.at(x, y) = y < 30 || x >= 60 ? 1 : 0;
    }
  front.depth = encode_depth(depth, 8);
  const RgbImage flat = flatten(panorama).image;
  EXPECT_GT(flat.at(5, flat.height / 2 + 4).r, 150) << "what is near goes on, though something far lies to the right";
  EXPECT_GT(flat.at(55, flat.height - 4).b, 200);
}

TEST(ExportFlat, HolesShowWhatLiesBehindAndElseWhatIsFarthestBesideThem) {
  LayeredPanorama panorama = plane_panorama(120, 60, 3000);
  Layer& front = panorama.layers[0];
  Layer behind = front;
  DisparityMap depth(120, 60, 3000);
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 120; ++x) {
      const bool near = x < 50;
      if (!near) depth.at(x, y) = 500;
      front.colour.at(x, y) = near ? Rgb{250, 0, 0} : Rgb{0, 0, 250};
      front.coverage.at(x, y) = x < 40 || x >= 60 || y < 4 || y >= 56 ? 1 : 0;
      behind.colour.at(x, y) = {0, 250, 0};
      behind.coverage.at(x, y) = x >= 40 && x < 60 && y < 30 ? 1 : 0;
    }
  front.depth = encode_depth(depth, 8);
  panorama.layers.push_back(behind);
  const RgbImage flat = flatten(panorama).image;
  const int low = flat.height * 7 / 8, high = flat.height / 8;
  EXPECT_EQ(flat.at(20, low), (Rgb{250, 0, 0}));
  EXPECT_EQ(flat.at(50, high), (Rgb{0, 250, 0}));
  for (const int x : {41, 50, 58}) EXPECT_LT(flat.at(x, low).r, 10) << "the near side does not go on, " << x;
  EXPECT_GT(flat.at(55, low).b, 200);
}

TEST(ExportFlat, SpecksBeyondTheBorderGo) {
  LayeredPanorama panorama = plane_panorama(120, 60, 1000);
  Layer& front = panorama.layers[0];
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 120; ++x) {
      const bool speck = x >= 100 && x < 104 && y >= 30 && y < 34;
      front.coverage.at(x, y) = x < 90 || speck ? 1 : 0;
      front.colour.at(x, y) = speck ? Rgb{255, 0, 0} : Rgb{0, 0, 250};
    }
  for (const Rgb& c : flatten(panorama).image.samples) ASSERT_LT(c.r, 2);
}

TEST(ExportFlat, JpegAndPngCarryGpanoThatFitsTheImage) {
  for (const bool wraps : {false, true}) {
    LayeredPanorama panorama = synthetic_panorama({400, 90, 0, 2, false, Rays::pushbroom, wraps});
    panorama.metadata["software"] = "a <\"&\"> b";
    const FlatPanorama flat = flatten(panorama);
    EXPECT_LE(flat.left + flat.image.width, flat.full_width);
    EXPECT_LE(flat.top + flat.image.height, flat.full_height);
    EXPECT_EQ(flat.image.width == flat.full_width, wraps);
    for (const char* name : {"a.jpg", "a.PNG"}) {
      const std::vector<uint8_t> file = export_as(name, panorama, {});
      const std::string text(file.begin(), file.end());
      EXPECT_THAT(text, HasSubstr("GPano:CroppedAreaImageWidthPixels=\"" + std::to_string(flat.image.width) + "\""));
      EXPECT_THAT(text, HasSubstr("GPano:FullPanoWidthPixels=\"" + std::to_string(flat.full_width) + "\""));
      EXPECT_THAT(text, HasSubstr("a &lt;&quot;&amp;&quot;> b"));
      EXPECT_EQ(image_size(file, name), (ImageSize{flat.image.width, flat.image.height}));
    }
  }
}

// The value or offset of a tag in a directory of an EXIF block (little-endian TIFF); 0 = there is none.
uint32_t exif_entry(const std::vector<uint8_t>& tiff, size_t directory, uint32_t tag) {
  const uint32_t entries = u32(tiff, directory) & 0xFFFF;
  for (uint32_t i = 0; i < entries; ++i) {
    const size_t at = directory + 2 + size_t{12} * i;
    if ((u32(tiff, at) & 0xFFFF) == tag) return u32(tiff, at + 8);
  }
  return 0;
}

TEST(ExportFlat, ExifPointsToTheDirectoryOfTheTimeItWasTaken) {
  const std::vector<uint8_t> file = export_as("a.jpg", synthetic_panorama({}), {});
  const std::string text(file.begin(), file.end());
  const size_t tiff_at = text.find(std::string("Exif\0\0", 6)) + 6;
  ASSERT_LT(tiff_at, text.size());
  const std::vector<uint8_t> tiff(file.begin() + static_cast<std::ptrdiff_t>(tiff_at), file.end());
  const uint32_t taken = exif_entry(tiff, u32(tiff, 4), 0x8769);
  ASSERT_GT(taken, 8U);
  const uint32_t time = exif_entry(tiff, taken, 0x9003);
  ASSERT_GT(time, taken);
  EXPECT_EQ(text.substr(tiff_at + time, 19), "2026:01:02 03:04:05");
}

TEST(ExportFlat, ExifHoldsTimeAndDevice) {
  const std::vector<uint8_t> file = export_as("a.jpg", synthetic_panorama({}), {});
  const std::string text(file.begin(), file.end());
  EXPECT_THAT(text, HasSubstr("2026:01:02 03:04:05"));
  EXPECT_THAT(text, HasSubstr("synthetic"));
}

TEST(ExportSurface, APlainWallTakesFewTriangles) {
  const LayeredPanorama panorama = plane_panorama(129, 65, 255 * 7);
  const Surface surface = make_surface(panorama, 0, {0, 129, 1});
  EXPECT_EQ(surface.triangles.size() / 3, 2u * 4 * 2);
}

// The cells of a layer without tears cover its grid exactly once; with tears, more than none of it twice as much.
TEST(ExportSurface, CoversEveryPlaceOfADenseLayer) {
  for (const int step : {1, 2, 4}) {
    const LayeredPanorama panorama = synthetic_panorama({151, 77, 8, 1});
    const Surface surface = make_surface(panorama, 0, {0, 151, step});
    double area = 0;
    for (size_t i = 0; i < surface.triangles.size(); i += 3) {
      const SurfaceVertex& a = surface.vertices[surface.triangles[i]];
      const SurfaceVertex& b = surface.vertices[surface.triangles[i + 1]];
      const SurfaceVertex& c = surface.vertices[surface.triangles[i + 2]];
      const double twice =
          double{b.x_px - a.x_px} * double{c.y_px - a.y_px} - double{c.x_px - a.x_px} * double{b.y_px - a.y_px};
      EXPECT_LE(twice, 0) << "every triangle turns the same way";
      area -= twice / 2;
    }
    EXPECT_GE(area, 150 * 76 * 0.999);
    EXPECT_LT(area, 150 * 76 * 1.2);
  }
}

TEST(ExportSurface, TearsBetweenNearAndFar) {
  LayeredPanorama panorama = plane_panorama(40, 40, 0);
  DisparityMap map(40, 40, 0);
  for (int y = 0; y < 40; ++y)
    for (int x = 20; x < 40; ++x) map.at(x, y) = 255 * 12;
  panorama.layers[0].depth = encode_depth(map, 0);
  const Surface surface = make_surface(panorama, 0, {0, 40, 1});
  for (size_t i = 0; i < surface.triangles.size(); i += 3)
    for (size_t k = 1; k < 3; ++k)
      EXPECT_EQ(surface.vertices[surface.triangles[i]].disparity, surface.vertices[surface.triangles[i + k]].disparity);
}

// Half a radius of the eye's way opens a step of so many pixels of parallax by half as many; up to 6 it is a slope, and
// up to 24 between pixels that look alike.
TEST(ExportSurface, TearsWhereViewsDo) {
  LayeredPanorama panorama = plane_panorama(40, 40, 0);
  const PanoramaGrid& grid = panorama.grid;
  const double steps_of_px = grid.v_pitch / grid.arc.radius / (grid.w_near - grid.w_far) * kDisparitySteps;
  const auto steps_across = [&](double px) {
    DisparityMap map(40, 40, 0);
    for (int y = 0; y < 40; ++y)
      for (int x = 24; x < 40; ++x) map.at(x, y) = static_cast<uint16_t>(std::lround(px * steps_of_px));
    panorama.layers[0].depth = encode_depth(map, 8);
    const Surface surface = make_surface(panorama, 0, {0, 40, 1});
    std::set<float> across;  // steps inside triangles
    for (size_t i = 0; i < surface.triangles.size(); i += 3)
      for (size_t k = 1; k < 3; ++k)
        across.insert(std::abs(surface.vertices[surface.triangles[i]].disparity -
                               surface.vertices[surface.triangles[i + k]].disparity));
    return across.size();
  };
  const auto paint_right = [&](uint8_t level) {
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x) panorama.layers[0].colour.at(x, y) = x < 24 ? Rgb{100, 90, 80} : Rgb{100, 90, level};
  };
  paint_right(90);
  EXPECT_EQ(steps_across(4), 2U) << "one surface";
  EXPECT_EQ(steps_across(12), 1U) << "two";
  paint_right(88);
  EXPECT_EQ(steps_across(12), 2U) << "nothing that one sees: they look alike";
  EXPECT_EQ(steps_across(32), 1U) << "two, however alike";
}

TEST(ExportGlb, IsAWellFormedContainer) {
  const std::vector<uint8_t> file =
      export_as("a.glb", synthetic_panorama({300, 90, 8, 3, true, Rays::central, true}), {});
  EXPECT_EQ(std::memcmp(file.data(), "glTF", 4), 0);
  EXPECT_EQ(u32(file, 4), 2u);
  EXPECT_EQ(u32(file, 8), file.size());
  const size_t json_bytes = u32(file, 12);
  EXPECT_EQ(json_bytes % 4, 0u);
  EXPECT_EQ(20 + json_bytes + 8 + u32(file, 20 + json_bytes), file.size());
  const std::string json(file.begin() + 20, file.begin() + 20 + static_cast<std::ptrdiff_t>(json_bytes));
  EXPECT_THAT(json, HasSubstr("KHR_materials_unlit"));
  EXPECT_THAT(json, HasSubstr("layer 3"));
}

// One mesh of a .glb as a reader has it in memory.
struct ReadMesh {
  std::vector<std::array<float, 3>> positions;
  std::vector<std::array<uint16_t, 2>> places;
  std::vector<uint32_t> triangles;
};

class GlbReader {
 public:
  explicit GlbReader(const std::vector<uint8_t>& file) : file_(file) {
    const size_t json_bytes = u32(file, 12);
    json_ = nlohmann::json::parse(file.begin() + 20, file.begin() + 20 + static_cast<std::ptrdiff_t>(json_bytes));
    binary_ = 28 + json_bytes;
  }

  const nlohmann::json& json() const { return json_; }

  std::vector<ReadMesh> meshes() const {
    std::vector<ReadMesh> meshes;
    for (const auto& mesh : json_["meshes"])
      for (const auto& primitive : mesh["primitives"])
        meshes.push_back({values<std::array<float, 3>>(primitive["attributes"]["POSITION"]),
                          values<std::array<uint16_t, 2>>(primitive["attributes"]["TEXCOORD_0"]),
                          values<uint32_t>(primitive["indices"])});
    return meshes;
  }

  std::vector<uint8_t> bytes_of_view(size_t index) const {
    const auto& view = json_["bufferViews"][index];
    if (!view.contains("extensions")) return stored(view);
    return unpacked(view["extensions"]["EXT_meshopt_compression"]);
  }

 private:
  std::vector<uint8_t> stored(const nlohmann::json& place) const {
    EXPECT_EQ(place["buffer"], 0);
    const auto begin = file_.begin() + static_cast<std::ptrdiff_t>(binary_ + place["byteOffset"].get<size_t>());
    return {begin, begin + place["byteLength"].get<std::ptrdiff_t>()};
  }

  std::vector<uint8_t> unpacked(const nlohmann::json& packing) const {
    const std::vector<uint8_t> coded = stored(packing);
    const size_t count = packing["count"], stride = packing["byteStride"];
    std::vector<uint8_t> bytes(count * stride);
    const bool is_vertices = packing["mode"] == "ATTRIBUTES";
    EXPECT_EQ(is_vertices ? meshopt_decodeVertexBuffer(bytes.data(), count, stride, coded.data(), coded.size())
                          : meshopt_decodeIndexBuffer(bytes.data(), count, stride, coded.data(), coded.size()),
              0);
    if (packing.contains("filter")) meshopt_decodeFilterExp(bytes.data(), count, stride);
    return bytes;
  }

  template <typename Value>
  std::vector<Value> values(size_t accessor) const {
    const auto& description = json_["accessors"][accessor];
    const std::vector<uint8_t> bytes = bytes_of_view(description["bufferView"]);
    std::vector<Value> values(description["count"].get<size_t>());
    EXPECT_EQ(bytes.size(), values.size() * sizeof(Value));
    std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
  }

  const std::vector<uint8_t>& file_;
  nlohmann::json json_;
  size_t binary_ = 0;
};

// Every triangle by the places of its corners, in no order: those of torn places have some in common.
std::multiset<std::array<std::array<uint16_t, 2>, 3>> triangles_of(const ReadMesh& mesh) {
  std::multiset<std::array<std::array<uint16_t, 2>, 3>> triangles;
  for (size_t i = 0; i < mesh.triangles.size(); i += 3) {
    std::array<std::array<uint16_t, 2>, 3> corners;
    for (size_t k = 0; k < 3; ++k) corners[k] = mesh.places[mesh.triangles[i + k]];
    std::sort(corners.begin(), corners.end());
    triangles.insert(corners);
  }
  return triangles;
}

TEST(ExportGlb, PackedAndPlainAreTheSameSurfaceToAThirdOfAPixel) {
  const LayeredPanorama panorama = synthetic_panorama({300, 90, 8, 3});
  const std::vector<uint8_t> plain = export_glb(panorama, {.plain = true}), packed = export_glb(panorama, {});
  EXPECT_LT(packed.size(), plain.size() / 2);
  const GlbReader plain_reader(plain), packed_reader(packed);
  const std::vector<ReadMesh> expected = plain_reader.meshes(), found = packed_reader.meshes();
  ASSERT_EQ(found.size(), expected.size());
  for (size_t m = 0; m < found.size(); ++m) {
    EXPECT_EQ(triangles_of(found[m]), triangles_of(expected[m]));
    ASSERT_EQ(found[m].positions.size(), expected[m].positions.size());
    std::map<std::array<uint16_t, 2>, std::vector<std::array<float, 3>>> at_place;
    for (size_t i = 0; i < expected[m].places.size(); ++i)
      at_place[expected[m].places[i]].push_back(expected[m].positions[i]);
    for (size_t i = 0; i < found[m].places.size(); ++i) {
      const Eigen::Vector3f p(found[m].positions[i].data());
      float nearest = 1;
      for (const auto& q : at_place[found[m].places[i]])
        nearest = std::min(nearest, (p - Eigen::Vector3f(q.data())).norm() / p.norm());
      EXPECT_LT(nearest, 1.0F / 2300);
    }
  }
}

TEST(ExportGlb, PackedFilesSayWhatTheirReadersMustKnow) {
  const std::vector<uint8_t> packed = export_glb(synthetic_panorama({}), {});
  const GlbReader reader(packed);
  const nlohmann::json& json = reader.json();
  EXPECT_EQ(json["extensionsRequired"], (nlohmann::json{"EXT_meshopt_compression", "EXT_texture_webp"}));
  ASSERT_EQ(json["buffers"].size(), 2U);
  EXPECT_TRUE(json["buffers"][1]["extensions"]["EXT_meshopt_compression"]["fallback"]);
  const size_t room = json["buffers"][1]["byteLength"];
  for (const auto& view : json["bufferViews"]) {
    const size_t end = view["byteOffset"].get<size_t>() + view["byteLength"].get<size_t>();
    EXPECT_LE(end, view["buffer"] == 1 ? room : packed.size());
  }
  for (const auto& image : json["images"]) {
    EXPECT_EQ(image["mimeType"], "image/webp");
    const std::vector<uint8_t> bytes = reader.bytes_of_view(image["bufferView"]);
    EXPECT_EQ(std::string(bytes.begin() + 8, bytes.begin() + 12), "WEBP");
  }
  for (const ReadMesh& mesh : reader.meshes()) {
    for (const uint32_t index : mesh.triangles) ASSERT_LT(index, mesh.positions.size());
  }
}

TEST(ExportGlb, PlainFilesNeedNoExtension) {
  const std::vector<uint8_t> plain = export_glb(synthetic_panorama({}), {.plain = true});
  const GlbReader reader(plain);
  EXPECT_FALSE(reader.json().contains("extensionsRequired"));
  EXPECT_EQ(reader.json()["buffers"].size(), 1U);
}

TEST(ExportGlb, BoundsAreThoseOfWhatReadersUnpack) {
  const std::vector<uint8_t> packed = export_glb(synthetic_panorama({}), {});
  const GlbReader reader(packed);
  const std::vector<ReadMesh> meshes = reader.meshes();
  const auto& primitive = reader.json()["meshes"][0]["primitives"][0];
  const auto& accessor = reader.json()["accessors"][primitive["attributes"]["POSITION"].get<size_t>()];
  for (size_t i = 0; i < 3; ++i) {
    const auto less = [i](const auto& a, const auto& b) { return a[i] < b[i]; };
    const auto& p = meshes[0].positions;
    EXPECT_EQ((*std::min_element(p.begin(), p.end(), less))[i], accessor["min"][i].get<float>());
    EXPECT_EQ((*std::max_element(p.begin(), p.end(), less))[i], accessor["max"][i].get<float>());
  }
}

constexpr size_t kMostOfViewer = 57'000;  // bytes of a page, beside 1.25 times its panorama

TEST(ExportHtml, NeedsNoNetwork) {
  const std::string page = export_html(encode_ldp(synthetic_panorama({}), {}));
  EXPECT_EQ(page.find("http:"), std::string::npos);
  EXPECT_EQ(page.find("https:"), std::string::npos);
  for (const char* mark : {"@SCRIPTS@", "@START@", "@PANORAMA@"}) EXPECT_EQ(page.find(mark), std::string::npos);
  EXPECT_THAT(page, ::testing::EndsWith("</html>\n"));
}

TEST(ExportHtml, HoldsTheFileItselfAndTheViewerIsSmall) {
  const std::vector<uint8_t> file = {0xAB, 'L', 'D', 'P', 0xFF};
  EXPECT_THAT(export_html(file), HasSubstr(">X%YoXrr</script>"));
  EXPECT_THAT(export_html(std::span(file).first(4)), HasSubstr(">X%YoX</script>"));
  EXPECT_THAT(export_html(std::span(file).first(3)), HasSubstr(">X%Yn</script>"));
  std::vector<uint8_t> steps;
  for (int i = 0; i < 250; i += 7) steps.push_back(static_cast<uint8_t>(i));
  EXPECT_THAT(export_html(steps), HasSubstr(">!!`uK*$Zpf3'Tl,v*NgGE-HbbN0B^(W3vYC`66T^i90P$</script>"));
  EXPECT_LT(export_html({}).size(), kMostOfViewer);
}

TEST(ExportJson, GivesTheCamerasBack) {
  const LayeredPanorama panorama = synthetic_panorama({});
  const std::vector<uint8_t> file = export_as("cameras.json", panorama, {});
  EXPECT_EQ(parse_transforms({reinterpret_cast<const char*>(file.data()), file.size()}, "a").size(),
            panorama.cameras.size());
}

TEST(Export, AnUnknownExtensionIsRefusedWithTheKnownOnes) {
  try {
    export_as("a.obj", synthetic_panorama({}), {});
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_STREQ(
        e.what(),
        "a.obj: cannot export to '.obj': choose .jpg, .png, .glb, .ply, .html, .json, or a folder with a slash "
        "behind its name");
  }
}

// A strict reader of what the header promises: so many points, each where its pixel's ray is at its depth.
TEST(ExportPoints, LieOnTheirRaysAtTheirDepths) {
  const LayeredPanorama panorama = synthetic_panorama({60, 40, 8, 3});

  const std::vector<uint8_t> file = export_ply(panorama);
  const std::string text(file.begin(), file.end());
  const std::string end = "end_header\n";
  const size_t body = text.find(end) + end.size();
  ASSERT_TRUE(text.starts_with("ply\nformat binary_little_endian 1.0\n"));
  const size_t count = std::stoul(text.substr(text.find("element vertex ") + 15));
  ASSERT_EQ(file.size() - body, count * 16);
  size_t expected = 0;
  for (const Layer& layer : panorama.layers)
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 60; ++x) expected += layer.coverage.at(x, y) && layer.depth.disparity(x, y) > 0 ? 1U : 0U;
  EXPECT_EQ(count, expected);
  std::array<int, 4> of_layer{};
  for (size_t i = 0; i < count; ++i) {
    const size_t at = body + 16 * i;
    Eigen::Vector3d point;
    for (size_t k = 0; k < 3; ++k) point[static_cast<int>(k)] = std::bit_cast<float>(u32(file, at + 4 * k));
    const size_t layer = file[at + 15];
    ASSERT_TRUE(layer >= 1 && layer <= 3);
    ++of_layer[layer];
    const PanoramaPosition place = locate(panorama.grid, point);
    const int x = static_cast<int>(place.x_px), y = static_cast<int>(place.y_px);
    const Layer& source = panorama.layers[layer - 1];
    ASSERT_NEAR(place.x_px, x + 0.5, 1e-3);
    ASSERT_NEAR(place.y_px, y + 0.5, 1e-3);
    ASSERT_NEAR(place.inverse_depth, panorama.grid.inverse_depth(source.depth.disparity(x, y)), 1e-5);
    ASSERT_EQ((Rgb{file[at + 12], file[at + 13], file[at + 14]}), source.colour.at(x, y));
  }
  EXPECT_GT(of_layer[2], 0);
}

TEST(ExportLayers, PicturesAndDisparitiesOfEveryLayerAreThere) {
  const LayeredPanorama panorama = synthetic_panorama({60, 40, 8, 3, true});
  const std::vector<ExportedFile> files = export_layers(panorama);
  ASSERT_EQ(files.size(), 7U);
  const auto json = nlohmann::json::parse(files.back().bytes);
  EXPECT_EQ(files.back().name, "layers.json");
  EXPECT_EQ(json["grid"]["width"], 60);
  EXPECT_EQ(json["grid"]["near_inverse_depth"], 1.25);
  EXPECT_EQ(json["cameras"]["frames"].size(), 3U);
  for (size_t layer = 0; layer < 3; ++layer) {
    EXPECT_EQ(json["layers"][layer]["image"], files[2 * layer].name);
    EXPECT_EQ(json["layers"][layer]["disparity"], files[2 * layer + 1].name);
    EXPECT_EQ(decode_image(files[2 * layer].bytes, "image"), panorama.layers[layer].colour);
    const DisparityMap map = decode_depth(panorama.layers[layer].depth, panorama.layers[layer].coverage);
    EXPECT_EQ(files[2 * layer + 1].bytes, encode_png(map));
  }
}

}  // namespace
}  // namespace ldp
