#include "drivers/backends.h"
#include "drivers/hardware.h"

namespace ldp {
namespace {

constexpr BackEnd<StatusChannel> kStatuses[] = {{"console", check_console_status, open_console_status}};

}  // namespace

std::span<const BackEnd<CameraDevice>> hardware_cameras() { return {}; }
std::span<const BackEnd<Button>> hardware_buttons() { return {}; }
std::span<const BackEnd<StatusChannel>> hardware_statuses() { return kStatuses; }
std::span<const BackEnd<StatusListener>> hardware_listeners() { return {}; }

}  // namespace ldp
