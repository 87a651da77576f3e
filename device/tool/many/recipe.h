// What a panorama was made from and how, in sixteen digits that its file keeps: by them `ldp build --if-needed` knows
// what it has made already.
#pragma once

#include <optional>
#include <string>

#include "core/base/job.h"
#include "core/panorama/file/ldp_file.h"
#include "device/tool/build_setup.h"

namespace ldp {

constexpr const char* kRecipe = "made_from";  // of the file's metadata

// Of every option that results depend on, the program's version, the cameras given, and the photos' names and sizes in
// bytes. Where the capture and the cameras lie plays no part, nor do threads.
std::string recipe_of(const BuildSetup& setup, const PreparedBuild& prepared);

// What is in the file at `output` if a build would make it again: it is sound, of this recipe, and no photo, notes or
// cameras are newer than it.
std::optional<LdpDescription> made_already(const std::string& output, const std::string& recipe,
                                           const BuildSetup& setup, const PreparedBuild& prepared, const Job& job);

}  // namespace ldp
