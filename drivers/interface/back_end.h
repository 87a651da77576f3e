// Back-ends by the scheme of their URL: one row each, checked and opened through it.
#pragma once

#include <memory>

#include "drivers/interface/url.h"

namespace ldp {

// `check` refuses, in the same words, what opening would refuse for the URL's text alone, and needs no device, network
// or file.
template <typename Device>
struct BackEnd {
  const char* scheme;
  void (*check)(const Url&);
  std::unique_ptr<Device> (*open)(const Url&);
};

}  // namespace ldp
