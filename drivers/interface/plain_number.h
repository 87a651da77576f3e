// A number as people write it and as every reader of numbers reads it back the same: 1000000, 0.75, 1234.567.
#pragma once

#include <string>

namespace ldp {

// The fewest digits that tell it from every other one; with an exponent from 1e15 on and below 1e-6 alone.
std::string plain_number(double value);

}  // namespace ldp
