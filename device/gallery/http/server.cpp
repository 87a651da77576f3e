#include "device/gallery/http/server.h"

#include <fcntl.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "device/gallery/http/connection.h"
#include "device/gallery/http/lobby.h"

namespace ldp::gallery {
namespace {

constexpr size_t kPiece = 65'536;

// The connection whose request this thread works on: cpp-httplib does not tell its handlers.
thread_local Connection* current = nullptr;

bool write_piece_of(int file, uint64_t at, size_t length, httplib::DataSink& sink) {
  char piece[kPiece];
  const ssize_t got = ::pread(file, piece, std::min(length, sizeof piece), static_cast<off_t>(at));
  return got > 0 && sink.write(piece, static_cast<size_t>(got));  // none: the file was cut short meanwhile
}

void put_body(const Reply& reply, httplib::Response& response) {
  const uint64_t begin = reply.range.begin;
  const auto length = static_cast<size_t>(reply.range.end - begin);
  if (length == 0 || (!reply.file && !reply.bytes)) return response.set_content(reply.text, reply.type);
  if (reply.file)
    return response.set_content_provider(
        length, reply.type, [file = reply.file, begin](size_t offset, size_t left, httplib::DataSink& sink) {
          return write_piece_of(file->get(), begin + offset, left, sink);
        });
  response.set_content_provider(
      length, reply.type, [bytes = reply.bytes, begin](size_t offset, size_t left, httplib::DataSink& sink) {
        return sink.write(reinterpret_cast<const char*>(bytes->data()) + begin + offset, left);
      });
}

void put_head(const Reply& reply, httplib::Response& response) {
  response.status = reply.status;
  for (const auto& [name, value] : reply.headers) response.set_header(name, value);
  response.set_header("X-Content-Type-Options", "nosniff");
  response.set_header("Referrer-Policy", "no-referrer");
  response.set_header("Content-Security-Policy",
                      "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' blob: data:; "
                      "worker-src 'self' blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
}

// cpp-httplib as the reader of requests and writer of replies alone.
class Http : public httplib::Server {
 public:
  Http(const Service& service, int listening) : service_(service) {
    svr_sock_ = listening;  // it takes itself for stopped otherwise
    set_keep_alive_max_count(kMostRequests);
    set_keep_alive_timeout(kHeadWithin_ms / 1000);
    set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      put(service_.answer(asked(request)), response);
      return HandlerResponse::Handled;
    });
  }

  // One request. False: the connection is at its end.
  bool serve_request(Connection& connection, bool is_last) {
    current = &connection;
    connection.begin_request();
    bool closed = false, has_body = false;
    const auto look = [&has_body](httplib::Request& request) {
      request.ranges.clear();  // the reply has its part already
      has_body = request.has_header("Transfer-Encoding") ||
                 request.get_header_value("Content-Length", 0).find_first_not_of('0') != std::string::npos;
    };
    const bool went_well = process_request(connection, is_last, closed, look);
    return went_well && !closed && !has_body && !connection.was_given_away();
  }

 private:
  static Asked asked(const httplib::Request& request) {
    return {request.method, request.path,
            [&request](const std::string& name) { return request.get_header_value(name); }};
  }

  void put(const Reply& reply, httplib::Response& response) {
    put_head(reply, response);
    if (!reply.follows) return put_body(reply, response);
    response.set_content_provider(reply.type, [this](size_t, httplib::DataSink&) {
      service_.follow(current->give_away());
      return false;
    });
  }

  const Service& service_;
};

// Requests that wait, and the threads that answer them.
class Counter {
 public:
  // Goes on with the threads that the system has room for; throws where that is none.
  Counter(const Service& service, int listening, Lobby& lobby) : http_(service, listening), lobby_(lobby) {
    threads_.reserve(kServers);
    try {
      for (int i = 0; i < kServers; ++i) threads_.emplace_back([this] { work(); });
    } catch (const std::exception&) {  // no memory is as good a reason: those that run would end the program
      if (threads_.empty()) throw;
    }
  }

  ~Counter() {
    {
      const std::lock_guard lock(mutex_);
      closing_ = true;
    }
    changed_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  void take(UniqueFd connection) {
    {
      const std::lock_guard lock(mutex_);
      if (waiting_.size() >= kMostWaiting) return;
      waiting_.push_back(std::move(connection));
    }
    changed_.notify_one();
  }

 private:
  void work() {
    for (;;) {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return closing_ || !waiting_.empty(); });
      if (closing_) return;
      Connection connection(std::move(waiting_.front()));
      waiting_.pop_front();
      lock.unlock();
      try {
        serve_connection(connection);
      } catch (const std::exception&) {
        // No memory, say: this connection ends, and no other.
      }
    }
  }

  void serve_connection(Connection& connection) {
    for (int i = 0; i < kMostRequests; ++i) {
      if (!http_.serve_request(connection, i + 1 == kMostRequests)) return connection.say_goodbye();
      if (!connection.has_more()) return lobby_.admit(connection.give_away());
    }
    connection.say_goodbye();
  }

  Http http_;
  Lobby& lobby_;
  std::mutex mutex_;  // of what follows
  std::condition_variable changed_;
  bool closing_ = false;
  std::deque<UniqueFd> waiting_;
  std::vector<std::thread> threads_;
};

}  // namespace

void serve(int listening, const Service& service, const std::stop_token& stop) {
  ::fcntl(listening, F_SETFL, ::fcntl(listening, F_GETFL) | O_NONBLOCK);
  const UniqueFd end(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
  if (!end.is_open()) throw std::system_error(errno, std::generic_category(), "cannot make an event descriptor");
  const std::stop_callback on_stop(stop, [&end] {
    const uint64_t one = 1;
    [[maybe_unused]] const ssize_t put = ::write(end.get(), &one, sizeof one);
  });
  Lobby lobby(listening, end.get());
  Counter counter(service, listening, lobby);
  if (service.ready) service.ready();
  while (!lobby.has_ended())
    for (UniqueFd& connection : lobby.next()) counter.take(std::move(connection));
}

}  // namespace ldp::gallery
