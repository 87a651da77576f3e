// What `ldp build --estimate` does.
#pragma once

#include <string>

#include "device/tool/build_setup.h"
#include "device/tool/session.h"

namespace ldp {

// Prints what building these photos to `output` will take; returns the exit status. Writes nothing.
int tell_estimate(const BuildSetup& setup, const std::string& output, const Session& session);

}  // namespace ldp
