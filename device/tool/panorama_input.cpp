#include "device/tool/panorama_input.h"

#include "core/base/files.h"
#include "core/panorama/file/ldp_file.h"
#include "core/photos/images.h"
#include "device/tool/output.h"
#include "device/tool/session.h"

namespace ldp {

LayeredPanorama read_panorama(const std::string& file, const Job& job) {
  check_input_file(file);
  try {
    const MappedFile mapped(file);
    return decode_ldp(mapped.bytes(), {}, job);
  } catch (const LdpError& error) {
    throw BadInput(file + ": " + error.what() + ": copy the file again, or see ldp verify");
  }
}

}  // namespace ldp
