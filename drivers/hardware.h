// The back-ends that drive hardware or a network, as rows by scheme; none of those but the console where the project is
// built without drivers.
#pragma once

#include <span>

#include "drivers/interface/back_end.h"
#include "drivers/interface/button.h"
#include "drivers/interface/camera.h"
#include "drivers/interface/status.h"

namespace ldp {

std::span<const BackEnd<CameraDevice>> hardware_cameras();
std::span<const BackEnd<Button>> hardware_buttons();
std::span<const BackEnd<StatusChannel>> hardware_statuses();
std::span<const BackEnd<StatusListener>> hardware_listeners();

}  // namespace ldp
