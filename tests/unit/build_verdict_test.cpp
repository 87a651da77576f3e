// What the service reads out of a build's report.
#include "device/service/builds/build_verdict.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace ldp {
namespace {

namespace fs = std::filesystem;

class BuildVerdict : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "ldp_verdict_XXXXXX";
    folder_ = mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(folder_); }

  Result of(const std::string& report) const {
    std::ofstream(folder_ / "report.json") << report;
    Result result;
    result.capture = "sweep_000001", result.text = "built in 5 s", result.ok = true;
    add_verdict(folder_ / "report.json", result);
    return result;
  }
  static std::string report(const std::string& verdict, const std::string& reasons) {
    return R"({"quality": {"verdict": ")" + verdict + R"(", "expected_view_psnr_db": 24.5, "reasons": [)" + reasons +
           "]}}";
  }

  fs::path folder_;
};

TEST_F(BuildVerdict, EveryGradeIsToldByItsName) {
  EXPECT_EQ(of(report("good", "")).verdict, Judgement::good);
  EXPECT_EQ(of(report("fair", "")).verdict, Judgement::fair);
  EXPECT_EQ(of(report("sweep_again", "")).verdict, Judgement::sweep_again);
  EXPECT_EQ(of(report("excellent", "")).verdict, Judgement::none);
  EXPECT_EQ(of(report("", "")).verdict, Judgement::none);
}

TEST_F(BuildVerdict, ReasonsStandOneALineAndTheRestOfTheResultStays) {
  const Result none = of(report("fair", ""));
  EXPECT_EQ(none.reasons, "");
  EXPECT_EQ(none.expected_view_psnr_db, 24.5);
  EXPECT_EQ(none.capture, "sweep_000001");
  EXPECT_EQ(none.text, "built in 5 s");
  EXPECT_TRUE(none.ok);
  EXPECT_EQ(of(report("fair", R"({"text": "too dark"})")).reasons, "too dark");
  EXPECT_EQ(of(report("fair", R"({"text": "too dark", "from_deg": 3}, {"text": "blurred"}, {"text": "far"})")).reasons,
            "too dark\nblurred\nfar");
}

TEST_F(BuildVerdict, AReportOfAnotherVersionOrNoneAddsNothing) {
  const std::string wrong[] = {"",
                               "{",
                               "[]",
                               "7",
                               "{}",
                               R"({"quality": 3})",
                               R"({"quality": {}})",
                               R"({"quality": {"verdict": 1, "expected_view_psnr_db": 3, "reasons": []}})",
                               R"({"quality": {"verdict": "good", "expected_view_psnr_db": "3", "reasons": []}})",
                               R"({"quality": {"verdict": "good", "expected_view_psnr_db": 3}})",
                               report("good", R"("dark")"),
                               report("good", R"({"text": "dark"}, {"text": 5})"),
                               report("good", "").substr(0, 40)};
  for (const std::string& report : wrong) {
    const Result result = of(report);
    EXPECT_EQ(result.verdict, Judgement::none) << report;
    EXPECT_EQ(result.expected_view_psnr_db, 0) << report;
    EXPECT_EQ(result.reasons, "") << report;
    EXPECT_EQ(result.text, "built in 5 s") << report;
  }
  Result result;
  add_verdict(folder_ / "nowhere.json", result);
  EXPECT_EQ(result.verdict, Judgement::none);
}

}  // namespace
}  // namespace ldp
