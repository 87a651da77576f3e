#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include "device/gallery/http/server.h"

namespace ldp::gallery {
namespace {

constexpr int kBacklog = 512;  // clients that come at once

struct Address {
  std::string host, port;
};

// getaddrinfo would take 70000 for 4464.
bool is_port(std::string_view text) {
  constexpr unsigned kMost = 65535;
  unsigned port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc() && end == text.data() + text.size() && port <= kMost;
}

Address parts_of(const std::string& text) {
  const size_t colon = text.rfind(':');
  if (colon == std::string::npos || !is_port(std::string_view(text).substr(colon + 1)))
    throw std::runtime_error("'" + text + "' is no address to listen on: HOST:PORT, such as 127.0.0.1:8080");
  Address address{text.substr(0, colon), text.substr(colon + 1)};
  if (address.host.size() > 1 && address.host.front() == '[' && address.host.back() == ']')
    address.host = address.host.substr(1, address.host.size() - 2);
  return address;
}

UniqueFd listen_at(const addrinfo& found) {
  UniqueFd fd(::socket(found.ai_family, found.ai_socktype | SOCK_CLOEXEC | SOCK_NONBLOCK, found.ai_protocol));
  const int on = 1;
  if (!fd.is_open() || ::setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0 ||
      ::bind(fd.get(), found.ai_addr, found.ai_addrlen) != 0 || ::listen(fd.get(), kBacklog) != 0)
    return {};
  return fd;
}

}  // namespace

UniqueFd listen_on(const std::string& text) {
  const Address address = parts_of(text);
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  wanted.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error =
      ::getaddrinfo(address.host.empty() ? nullptr : address.host.c_str(), address.port.c_str(), &wanted, &found);
  if (error != 0) throw std::runtime_error("cannot listen on " + text + ": " + ::gai_strerror(error));
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owner(found, ::freeaddrinfo);
  UniqueFd fd;
  for (const addrinfo* one = found; one != nullptr && !fd.is_open(); one = one->ai_next) fd = listen_at(*one);
  if (!fd.is_open())
    throw std::system_error(errno, std::generic_category(), "cannot listen on " + text + ": choose another port");
  return fd;
}

UniqueFd inherited_socket() {
  constexpr int kFirst = 3;
  const char* const process = std::getenv("LISTEN_PID");
  const char* const count = std::getenv("LISTEN_FDS");
  if (process == nullptr || count == nullptr || std::atol(process) != ::getpid() || std::atoi(count) < 1) return {};
  return UniqueFd(kFirst);
}

std::string address_of(int listening) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  char host[NI_MAXHOST], port[NI_MAXSERV];
  if (::getsockname(listening, reinterpret_cast<sockaddr*>(&address), &size) != 0 ||
      ::getnameinfo(reinterpret_cast<sockaddr*>(&address), size, host, sizeof host, port, sizeof port,
                    NI_NUMERICHOST | NI_NUMERICSERV) != 0)
    return {};
  std::string text = "http://";
  text.append(address.ss_family == AF_INET6 ? "[" : "").append(host).append(address.ss_family == AF_INET6 ? "]:" : ":");
  return text.append(port).append("/");
}

}  // namespace ldp::gallery
