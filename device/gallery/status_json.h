// What a device tells (drivers/interface/status.h), as JSON.
#pragma once

#include <nlohmann/json.hpp>

#include "drivers/interface/status.h"

namespace ldp::gallery {

// With "type": "status", "progress", "guidance" or "result".
nlohmann::ordered_json json_from(const StatusMessage& message);

}  // namespace ldp::gallery
