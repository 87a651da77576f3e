// The commands of ldp-device.

#include "device/tool/commands.h"

namespace ldp {

void add_commands(Program& program) {
  add_capture(program);
  add_serve(program);
  add_watch(program);
}

}  // namespace ldp
