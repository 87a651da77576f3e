#include "device/tool/intake/zip_archive.h"
#include "device/tool/session.h"

namespace ldp {

void unpack_photos(const std::filesystem::path& archive, const UnpackedFolder& /*to*/, const Job& /*job*/) {
  throw BadInput(archive.string() +
                 ": this program was built without libarchive: unpack the archive, and give the folder of its photos");
}

}  // namespace ldp
