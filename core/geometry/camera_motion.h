// What kind of motion a sweep is.
#pragma once

namespace ldp {

enum class Motion { arc, straight, rotation };  // round a circle; along a line; on the spot

}  // namespace ldp
