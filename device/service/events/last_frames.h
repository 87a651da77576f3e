// The end of a session: what is queued to be stored is stored first.
#pragma once

#include <functional>

#include "device/capture/frame_writer.h"
#include "device/service/events/end_request.h"
#include "device/service/events/service_notice.h"

namespace ldp {

struct LastFrames {
  FrameWriter& writer;
  EndRequest& end_request;
  ServiceNotice& notice;  // is asked for the time that it takes
  bool leaves_when_asked_again = false;
  std::function<void()> serve_writer;  // takes what the writer has done
};

// Waits as long as frames reach the disk, however slowly; not for ever where it does not answer, nor when asked again.
// What is left then is told on the log, and the writer left to itself.
void wait_for_last_frames(const LastFrames& last);

}  // namespace ldp
