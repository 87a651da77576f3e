// What the scripts that install and build do before they begin: nothing of the user's is touched, words they do not
// know are refused. They run from a copy whose toolchain/setup only leaves a note and fails.

#include <cstdlib>

#include "tests/flow/flow.h"

namespace ldp {
namespace {

class Scripts : public Flow {
 protected:
  void SetUp() override {
    Flow::SetUp();
    fs::create_directory(room_ / "toolchain");
    for (const char* script : {"demo", "check", "package"})
      fs::copy_file(fs::path(LDP_SOURCE) / "toolchain" / script, room_ / "toolchain" / script);
    std::ofstream(room_ / "toolchain/setup") << "#!/bin/bash\ntouch " << (room_ / "began") << "\nexit 9\n";
    fs::permissions(room_ / "toolchain/setup", fs::perms::owner_all);
  }
  // Of a script with these words; 9: it would have begun to install.
  int status_of(const std::string& words) {
    fs::remove(room_ / "began");
    const std::string line = "cd " + path("") + " && " + (room_ / "toolchain").string() + "/" + words + " >" +
                             (room_ / "stdout").string() + " 2>" + (room_ / "stderr").string();
    const int status = std::system(line.c_str());
    EXPECT_EQ(fs::exists(room_ / "began"), WEXITSTATUS(status) == 9) << words;
    return WEXITSTATUS(status);
  }
};

TEST_F(Scripts, TheDemoTakesOnlyAFolderThatIsNewEmptyOrItsOwn) {
  photo("photos/a.jpg");
  fs::create_directory(path("empty"));
  EXPECT_EQ(status_of("demo photos"), 2);
  EXPECT_THAT(text_of(room_ / "stderr"), HasSubstr("holds something that is not of a demo"));
  EXPECT_EQ(status_of("demo photos/a.jpg"), 2);
  EXPECT_EQ(status_of("demo photos empty"), 2);
  EXPECT_TRUE(fs::exists(path("photos/a.jpg")));
  EXPECT_EQ(status_of("demo new"), 9);
  EXPECT_EQ(status_of("demo empty"), 9);
  std::ofstream(path("photos/.ldp-demo"));
  EXPECT_EQ(status_of("demo photos"), 9);
}

TEST_F(Scripts, TheDemoRemovesOnlyWhatADemoMakes) {
  photo("mine/a.jpg");
  photo("mine/views/a.jpg");
  std::ofstream(path("mine/.ldp-demo"));
  std::ofstream(room_ / "toolchain/setup") << "#!/bin/bash\nexit 0\n";
  fs::create_directories(room_ / "bin");
  for (const char* program : {"cmake", "ldp", "ldpd"}) {  // nothing is built; the sweep fails
    std::ofstream(room_ / "bin" / program) << "#!/bin/bash\n[ " << program << " = cmake ]\n";
    fs::permissions(room_ / "bin" / program, fs::perms::owner_all);
  }
  const std::string demo = "PATH=" + (room_ / "bin").string() + ":$PATH " + (room_ / "toolchain/demo").string() + " " +
                           path("mine") + " >" + (room_ / "stdout").string() + " 2>&1";
  EXPECT_EQ(WEXITSTATUS(std::system(demo.c_str())), 1) << text_of(room_ / "stdout");
  EXPECT_TRUE(fs::exists(path("mine/a.jpg")));
  EXPECT_FALSE(fs::exists(path("mine/views")));
}

TEST_F(Scripts, HelpIsPrintedAndUnknownWordsAreRefusedBeforeAnythingIsInstalled) {
  for (const char* script : {"demo", "check", "package"}) {
    EXPECT_EQ(status_of(std::string(script) + " --help"), 0) << script;
    EXPECT_THAT(text_of(room_ / "stdout"), HasSubstr("toolchain/" + std::string(script))) << script;
    EXPECT_EQ(status_of(std::string(script) + " -h"), 0) << script;
    EXPECT_EQ(status_of(std::string(script) + " --wide"), 2) << script;
  }
  EXPECT_EQ(status_of("package"), 2);
  EXPECT_EQ(status_of("check Solve"), 2);
  EXPECT_EQ(status_of("check -R"), 2);
  EXPECT_EQ(status_of("check -R Solve -V"), 9);
}

TEST_F(Scripts, AnInstallationUnderAnotherPrefixRunsItsOwnServiceAndHasItsManPages) {
  const fs::path prefix = room_ / "prefix";
  if (!fs::exists(fs::path(LDP_PROGRAM).parent_path() / "ldpd")) GTEST_SKIP() << "built without the service";
  if (std::system("cmake --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "no cmake here";
  const std::string line = "cmake --install " LDP_BUILD " --prefix " + prefix.string() + " >/dev/null";
  ASSERT_EQ(std::system(line.c_str()), 0);
  const std::string unit = text_of(prefix / "lib/systemd/system/ldpd.service");
  EXPECT_THAT(unit, HasSubstr("ExecStart=" + (prefix / "bin/ldpd").string() + "\n"));
  for (const char* page : {"man1/ldp.1", "man1/ldp-device.1", "man8/ldpd.8"})
    EXPECT_TRUE(fs::exists(prefix / "share/man" / page)) << page;
}

}  // namespace
}  // namespace ldp
