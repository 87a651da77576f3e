// What tests of what the program `ldp` writes share: a small panorama, a path through it, and a stand-in for ffmpeg.
#pragma once

#include <fstream>
#include <string>
#include <vector>

#include "tests/flow/flow.h"

namespace ldp {

class Outputs : public Flow {
 protected:
  // Four tiny photos and their panorama.
  std::string small_panorama() const {
    const Outcome made =
        ldp({"scene", "room", "-o", path("capture"), "--size", "96x72", "--frames", "4", "--arc", "30", "--no-novel"});
    EXPECT_EQ(made.status, 0) << made.err;
    const Outcome built = ldp({"build", path("capture"), "-o", path("a.ldp"), "--cameras",
                               path("capture/transforms.json"), "--layers", "1", "--labels", "2"});
    EXPECT_EQ(built.status, 0) << built.err;
    return path("a.ldp");
  }
  // A program called ffmpeg that does `what` with the film's name in $film, before all others on the path.
  std::vector<std::string> with_ffmpeg(const std::string& what) const {
    const fs::path folder = room_ / "bin";
    fs::create_directories(folder);
    std::ofstream(folder / "ffmpeg") << "#!/bin/bash\nfilm=\"${@: -1}\"\n" << what << "\n";
    fs::permissions(folder / "ffmpeg", fs::perms::owner_all);
    return {"env", "PATH=" + folder.string() + ":/usr/bin:/bin"};
  }
  std::vector<std::string> render_path(const std::string& file, const std::string& to, int frames) const {
    return {"render", file, "--path", "sway", "--frames", std::to_string(frames), "--size", "64x48", "-o", to};
  }
};

}  // namespace ldp
