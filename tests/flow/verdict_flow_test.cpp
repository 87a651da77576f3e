// The verdict on a sweep as the program `ldp` tells it.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/flow/flow.h"

namespace ldp {
namespace {

// As a camera that turns while its shutter is open takes it.
void smear(const std::string& file) {
  constexpr int kLength = 40;
  const RgbImage sharp = read_image(file);
  RgbImage smeared = sharp;
  for (int y = 0; y < sharp.height; ++y)
    for (int x = 0; x < sharp.width; ++x) {
      int r = 0, g = 0, b = 0;
      for (int i = 0; i < kLength; ++i) {
        const Rgb& c = sharp.at(std::min(sharp.width - 1, x + i), y);
        r += c.r, g += c.g, b += c.b;
      }
      const auto mean = [](int sum) { return static_cast<uint8_t>(sum / kLength); };
      smeared.at(x, y) = {mean(r), mean(g), mean(b)};
    }
  write_file(file, encode_png(smeared));
}

TEST_F(Flow, InfoTellsTheVerdictByTheContractsNames) {
  const std::string file = panorama(capture());
  const Outcome info = ldp({"info", file, "--json"});
  ASSERT_EQ(info.status, 0) << info.err;
  const auto quality = nlohmann::json::parse(info.out).at("quality");
  EXPECT_THAT(quality.at("verdict").get<std::string>(), testing::AnyOf("good", "fair"));
  EXPECT_TRUE(quality.at("reasons").is_array());
  const double expected = quality.at("expected_view_psnr_db"), back = quality.at("photos_back_psnr_db");
  EXPECT_GT(expected, 18);
  EXPECT_GT(back, expected);
  EXPECT_LT(quality.at("unexplained_share"), 0.1);
  ASSERT_GE(quality.at("by_direction").size(), 4U);
  for (const auto& direction : quality.at("by_direction")) EXPECT_GT(direction.at("to_deg"), direction.at("from_deg"));
}

TEST_F(Flow, StrictRefusesASmearedSweepAndKeepsItsFile) {
  const std::string from = capture();
  for (const auto& entry : fs::directory_iterator(from + "/frames"))
    if (entry.path().extension() == ".png") smear(entry.path().string());
  const std::vector<std::string> build{"build", from, "-o", path("a.ldp"), "--cameras", from + "/transforms.json"};
  const Outcome told = ldp(build);
  EXPECT_EQ(told.status, 0) << told.err;
  EXPECT_THAT(told.out, HasSubstr("sweep again"));
  std::vector<std::string> strictly = build;
  strictly.emplace_back("--strict");
  const Outcome refused = ldp(strictly);
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("are blurred: turn more slowly there"));
  const auto quality = nlohmann::json::parse(ldp({"info", path("a.ldp"), "--json"}).out).at("quality");
  EXPECT_EQ(quality.at("verdict"), "sweep_again");
  EXPECT_EQ(quality.at("reasons").at(0).at("code"), "blurred");
}

TEST_F(Flow, StrictLetsAGoodSweepPass) {
  const std::string from = capture();
  const Outcome built = ldp({"build", from, "-o", path("a.ldp"), "--cameras", from + "/transforms.json", "--strict"});
  EXPECT_EQ(built.status, 0) << built.out << built.err;
}

}  // namespace
}  // namespace ldp
