// Cameras and buttons without hardware: ordinary back-ends of drivers/interface/camera.h and button.h.
#pragma once

#include <memory>
#include <span>

#include "drivers/interface/back_end.h"
#include "drivers/interface/button.h"
#include "drivers/interface/camera.h"
#include "drivers/interface/url.h"

namespace ldp {

std::span<const BackEnd<CameraDevice>> simulated_cameras();
std::span<const BackEnd<Button>> simulated_buttons();

// Each opens what a URL names; its check refuses what is wrong with the URL's text alone.
void check_folder_camera(const Url& url);
void check_scene_camera(const Url& url);
void check_script_button(const Url& url);
void check_keyboard_button(const Url& url);

// folder:DIR?fps=30&hold=yes&lost_after=N&stall_after=N
// The photos of DIR that a build would take, in its order (core/captures/folder_frames.h), one per tick of a real
// clock; the last one is repeated for ever (hold=yes, an arm at rest) or followed by CameraLost (hold=no). JPEG files
// pass through byte by byte. Faults: lost_after=N throws CameraLost instead of frame N (counted from 0); stall_after=N
// gives nothing from frame N on.
std::unique_ptr<CameraDevice> open_folder_camera(const Url& url);

// scene:NAME?frames=20&arc=180&width=800&height=600&noise=0&seed=1 and the options above: a sweep through a synthetic
// scene. All frames are rendered by `prepare`, which takes about a second of a core each and is given up between two.
std::unique_ptr<CameraDevice> open_scene_camera(const Url& url);

// script:FILE: words press, release and wait MILLISECONDS, played once from opening on.
std::unique_ptr<Button> open_script_button(const Url& url);

// keyboard: every space or Enter typed on standard input is a press followed by a release.
std::unique_ptr<Button> open_keyboard_button(const Url& url);

}  // namespace ldp
