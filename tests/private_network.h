// A multicast network of this machine that no other run of the tests uses at the same time, and whether there can be
// one.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <random>
#include <string>

#include "drivers/interface/unique_fd.h"

namespace ldp {

// An address for LCM: a random group and port, whose datagrams do not leave the machine.
inline std::string private_network() {
  std::random_device random;
  const auto below = [&](unsigned end) { return std::to_string(random() % end); };
  return "udpm://239.255." + below(256) + "." + below(256) + ":" + std::to_string(20'000 + random() % 10'000) +
         "?ttl=0";
}

// Why no datagram to a group comes back on this machine; empty: it does. By plain sockets: a fault of ours must not
// look like a machine without multicast.
inline std::string why_no_multicast() {
  const auto failed = [](const char* what) {
    return std::string("no multicast here (ip route add 224.0.0.0/4 dev lo): ") + what + ": " + std::strerror(errno);
  };
  const UniqueFd fd(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!fd.is_open()) return failed("socket");
  sockaddr_in address{};
  address.sin_family = AF_INET;
  socklen_t size = sizeof address;
  auto* const plain = reinterpret_cast<sockaddr*>(&address);
  if (::bind(fd.get(), plain, size) != 0 || ::getsockname(fd.get(), plain, &size) != 0) return failed("bind");
  ip_mreq group{};
  ::inet_pton(AF_INET, "239.255.76.68", &group.imr_multiaddr);
  if (::setsockopt(fd.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) != 0)
    return failed("joining a group");
  const uint8_t ttl = 0;
  ::setsockopt(fd.get(), IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
  address.sin_addr = group.imr_multiaddr;
  if (::sendto(fd.get(), "x", 1, 0, plain, size) != 1) return failed("sending");
  pollfd entry{fd.get(), POLLIN, 0};
  return ::poll(&entry, 1, 5000) == 1 ? "" : "multicast does not come back here";
}

}  // namespace ldp

// In the body of a test, or its SetUp.
#define NEEDS_MULTICAST() \
  if (const std::string lacks = ldp::why_no_multicast(); !lacks.empty()) GTEST_SKIP() << lacks
