// A multicast network of this machine that no other run of the tests uses at the same time.
#pragma once

#include <random>
#include <string>

namespace ldp {

// An address for LCM: a random group and port, whose datagrams do not leave the machine.
inline std::string private_network() {
  std::random_device random;
  const auto below = [&](unsigned end) { return std::to_string(random() % end); };
  return "udpm://239.255." + below(256) + "." + below(256) + ":" + std::to_string(20'000 + random() % 10'000) +
         "?ttl=0";
}

}  // namespace ldp
