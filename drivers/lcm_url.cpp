// What LCM's addresses may say. LCM itself tells by opening one, which needs a network that is up, and ignores options
// that it does not know.
#include <arpa/inet.h>

#include <stdexcept>
#include <string>

#include "drivers/backends.h"

namespace ldp {
namespace {

constexpr const char* kExample = "as in lcm:udpm://239.255.76.67:7667?ttl=0";

[[noreturn]] void refuse(const Url& url, const std::string& why) {
  throw std::runtime_error("'" + url.text() + "': " + why + ", " + kExample);
}

bool is_port(const std::string& text) {
  return !text.empty() && text.size() <= 5 && text.find_first_not_of("0123456789") == std::string::npos &&
         std::stoi(text) >= 1 && std::stoi(text) <= 65535;
}

bool is_multicast(const std::string& text) {
  in_addr address{};
  return ::inet_pton(AF_INET, text.c_str(), &address) == 1 && IN_MULTICAST(ntohl(address.s_addr));
}

// ADDRESS:PORT; either may be left out with what follows it.
void check_group(const Url& url, const std::string& group) {
  if (group.empty()) return;
  const size_t colon = group.find(':');
  const std::string address = group.substr(0, colon);
  if (!is_multicast(address)) refuse(url, "'" + address + "' is no multicast address (224.0.0.0 to 239.255.255.255)");
  if (colon != std::string::npos && !is_port(group.substr(colon + 1)))
    refuse(url, "'" + group.substr(colon + 1) + "' is no port (1 to 65535)");
}

}  // namespace

void check_lcm(const Url& url) {
  if (url.rest().empty()) return;  // LCM's own default
  const size_t end = url.path().find("://");
  const std::string provider = url.path().substr(0, end);
  if (end == std::string::npos) refuse(url, "expected PROVIDER://NETWORK after lcm:");
  const std::string network = url.path().substr(end + 3);
  if (provider == "udpm") {
    check_group(url, network);
    url.allow_only("ttl recv_buf_size transmit_only");
    url.integer("ttl", 0, {0, 255});
  } else if (provider == "mpudpm") {
    check_group(url, network);
  } else if (provider != "tcpq" && provider != "memq" && provider != "file") {
    refuse(url, "LCM has no provider '" + provider + "'; known: udpm mpudpm tcpq memq file");
  }
}

}  // namespace ldp
