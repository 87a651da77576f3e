#include "panorama_input.h"

#include "images.h"
#include "ldp_file.h"
#include "output.h"
#include "session.h"

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
