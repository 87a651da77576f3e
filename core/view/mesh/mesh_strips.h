// The mesh of a panorama in strips of columns, each made when a view first needs it.
//
// Takes a panorama and what a view may see; gives tiles. A strip is cut out with as many columns beside it as what is
// made up of its surfaces depends on; smoothing depends on more, by far less than shows.
#pragma once

#include <atomic>
#include <cstddef>
#include <deque>
#include <mutex>
#include <vector>

#include "core/base/job.h"
#include "core/panorama/panorama.h"
#include "core/view/mesh/mesh.h"
#include "core/view/raster/view_frustum.h"

namespace ldp::view {

enum class BeyondFrames { nothing, surfaces };  // frame_extension.h

class MeshStrips {
 public:
  // The panorama must outlive it, its layers only until all strips are made. Strips of so many tiles across.
  MeshStrips(const LayeredPanorama& panorama, int tiles_across, BeyondFrames beyond);

  const PanoramaGrid& grid() const { return panorama_.grid; }
  ViewFrustum frustum(const Camera& camera) const;

  // Makes the strips of which a camera may see anything, where they are not made already, and tells their places. From
  // any number of threads at the same time.
  std::vector<size_t> make_seen(const ViewFrustum& frustum, const Window& window, const Job& job);
  void make_all(const Job& job);  // likewise
  bool all_made() const;

  // Lets go of all others; not while any are made.
  void forget_unseen(const ViewFrustum& frustum, const Window& window);

  // Of strips that are made: of the first `layers` layers, or with all of them of everything made up besides; layer by
  // layer.
  std::vector<const MeshTile*> tiles(const std::vector<size_t>& places, int layers) const;

 private:
  // Quads whose left columns are [begin, end), from columns [from, to), which may go on past the ends of a panorama
  // that wraps.
  struct Strip {
    int begin, end, from, to;
    float w_min, w_max;  // inverse depths of its surfaces lie between
    std::mutex making;
    std::atomic<bool> is_made = false;
    Mesh mesh;  // once it is made
  };

  Mesh made(const Strip& strip, const Job& job) const;
  void make(const std::vector<size_t>& places, const Job& job);
  bool sees(const ViewFrustum& frustum, const Window& window, const Strip& strip) const;

  const LayeredPanorama& panorama_;
  int layers_, rows_beyond_ = 0;
  BeyondFrames beyond_;
  std::deque<Strip> strips_;
};

}  // namespace ldp::view
