#include <stdexcept>

#include "device/tool/exr/exr_view.h"
#include "device/tool/session.h"

namespace ldp {

void check_exr_is_built() {
  throw BadInput("--exr: this program was built without OpenEXR: use --depth, which writes depths as .pfm");
}

std::vector<uint8_t> encode_exr(const View& /*view*/) { throw std::logic_error("encode_exr: built without OpenEXR"); }

}  // namespace ldp
