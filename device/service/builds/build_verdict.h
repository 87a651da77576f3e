// What a build's report says of the sweep's quality, for those who wait for the result.
#pragma once

#include <filesystem>

#include "drivers/interface/status.h"

namespace ldp {

// Adds the verdict of report.json to the result; nothing where there is none that can be read.
void add_verdict(const std::filesystem::path& report, Result& result);

}  // namespace ldp
