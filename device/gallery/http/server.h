// HTTP/1.1 over sockets: accepts connections, hands requests to a function, sends its replies.
//
// Requests are read and replies written by cpp-httplib, connections are not: its own loop knows no time by which a
// request must be there, no bound of its head, no socket of a service manager (decisions.md). Bounds: server_tuning.h.
#pragma once

#include <functional>
#include <stop_token>
#include <string>

#include "device/gallery/reply.h"
#include "drivers/interface/unique_fd.h"

namespace ldp::gallery {

// "127.0.0.1:8080", "[::]:8080", ":8080" for every address. Throws std::runtime_error naming it.
UniqueFd listen_on(const std::string& address);

// The socket of a service manager (sd_listen_fds(3)); none where there is none.
UniqueFd inherited_socket();

// "http://127.0.0.1:8080/"
std::string address_of(int listening);

struct Service {
  std::function<Reply(const Asked&)> answer;  // from several threads
  std::function<void(UniqueFd)> follow;       // takes a connection that follows the live feed
  std::function<void()> ready;                // called once all is there to serve with; may be empty
};

// Until the token is triggered; connections that are open then are ended. Throws std::system_error.
void serve(int listening, const Service& service, const std::stop_token& stop);

}  // namespace ldp::gallery
