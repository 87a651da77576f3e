// The gallery's pages and files: what every request is answered with.
//
//   /                             the page; its scripts /gallery.js /viewer.js /worker.js
//   /panoramas.json               all of them, newest first, and what the gallery can do
//   /view/NAME.ldp                the viewer
//   /panoramas/NAME.ldp .jpg .glb the file, and converted (core/export)
//   /thumbnails/NAME.ldp          a JPEG
//   /sweeps/SWEEP/FRAME           a frame of a sweep that is being taken
//   /events                       the live feed
//   POST /device/press ...        a word to the device } only with "Authorization: Bearer TOKEN", where a token is
//   DELETE /panoramas/NAME.ldp                         } configured
//
// Files have ETags and ranges; what does not change is not sent again. Any thread.
#pragma once

#include <string>

#include "device/gallery/cards.h"
#include "device/gallery/conversions.h"
#include "device/gallery/folder.h"
#include "device/gallery/live_feed.h"
#include "device/gallery/reply.h"

namespace ldp::gallery {

constexpr size_t kShortestToken = 16;  // characters

struct GalleryOptions {
  std::string token;  // empty: nothing can be changed
  ConversionLimits conversions;
};

class Gallery {
 public:
  // Throws std::invalid_argument for a token that is too short.
  Gallery(const Folder& folder, LiveFeed& feed, const GalleryOptions& options, const Job& job);

  Reply answer(const Asked& asked);

 private:
  Reply look_at(const Asked& asked);
  Reply change(const Asked& asked);
  Reply list(const Asked& asked);
  Reply show(const Asked& asked, const std::string& name);
  Reply panorama(const Asked& asked, const std::string& name);
  Reply converted(const Asked& asked, const std::string& stem, const std::string& ending);
  Reply thumbnail(const Asked& asked, const std::string& name);
  Reply frame(const Asked& asked, const std::string& sweep_and_name);
  bool may_change(const Asked& asked) const;

  const Folder& folder_;
  LiveFeed& feed_;
  GalleryOptions options_;
  Cards cards_;
  Conversions conversions_;
};

}  // namespace ldp::gallery
