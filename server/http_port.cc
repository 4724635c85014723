#include "server/http_port.h"

#include <errno.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "core/base/status.h"

namespace cagefit::server {
namespace {

constexpr int kPollMs = 200;  // how late a time-out may be

struct HostPort {
  std::string host, port;
};

absl::StatusOr<HostPort> Split(const std::string& address) {
  const size_t colon = address.rfind(':');
  int port = -1;
  if (colon == std::string::npos || colon == 0 ||
      !absl::SimpleAtoi(address.substr(colon + 1), &port) || port < 0 || port > 65535) {
    return absl::InvalidArgumentError(absl::StrCat("\"", address, "\" is not HOST:PORT"));
  }
  std::string host = address.substr(0, colon);
  if (host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  return HostPort{std::move(host), absl::StrCat(port)};
}

// A socket that listens, or -1 with errno set.
int ListenAt(const addrinfo& info) {
  const int fd = socket(info.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd < 0) return -1;
  const int on = 1;
  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));  // after a restart
  if (bind(fd, info.ai_addr, info.ai_addrlen) == 0 && listen(fd, SOMAXCONN) == 0) return fd;
  const int error = errno;
  close(fd);
  errno = error;
  return -1;
}

absl::StatusOr<int> Listen(const std::string& address) {
  ASSIGN_OR_RETURN(const HostPort parts, Split(address));
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(parts.host.c_str(), parts.port.c_str(), &hints, &found);
  if (error != 0) {
    return absl::UnavailableError(
        absl::StrCat("cannot listen on ", address, ": ", gai_strerror(error)));
  }
  int fd = -1;
  for (const addrinfo* info = found; info != nullptr && fd < 0; info = info->ai_next) {
    fd = ListenAt(*info);
  }
  const int listen_error = errno;
  freeaddrinfo(found);
  if (fd >= 0) return fd;
  return absl::UnavailableError(
      absl::StrCat("cannot listen on ", address, ": ", strerror(listen_error)));
}

int BoundPort(int fd) {
  sockaddr_storage bound = {};
  socklen_t size = sizeof(bound);
  getsockname(fd, reinterpret_cast<sockaddr*>(&bound), &size);
  // The port stands at the same place in both families.
  return ntohs(reinterpret_cast<const sockaddr_in&>(bound).sin_port);
}

}  // namespace

struct HttpPort::Connection {
  int fd;
  absl::Time deadline;
  std::string request = {}, response = {};  // the latter once the former is complete
  size_t sent = 0;
};

absl::StatusOr<std::unique_ptr<HttpPort>> HttpPort::Open(const std::string& address, Page page) {
  ASSIGN_OR_RETURN(const int listener, Listen(address));
  const std::string bound =
      absl::StrCat(address.substr(0, address.rfind(':') + 1), BoundPort(listener));
  return std::unique_ptr<HttpPort>(
      new HttpPort(listener, eventfd(0, EFD_CLOEXEC), bound, std::move(page)));
}

HttpPort::HttpPort(int listener, int stop, std::string address, Page page)
    : listener_(listener),
      stop_(stop),
      address_(std::move(address)),
      page_(std::move(page)),
      thread_([this] { Serve(); }) {}

HttpPort::~HttpPort() {
  eventfd_write(stop_, 1);
  thread_.join();
  for (const Connection& connection : connections_) close(connection.fd);
  close(listener_);
  close(stop_);
}

void HttpPort::Serve() {
  for (;;) {
    std::vector<pollfd> ready = {{stop_, POLLIN, 0}};
    for (const Connection& c : connections_) {
      const bool reading = c.response.empty();
      ready.push_back({c.fd, static_cast<short>(reading ? POLLIN : POLLOUT), 0});
    }
    if (connections_.size() < kMaxConnections) ready.push_back({listener_, POLLIN, 0});
    poll(ready.data(), ready.size(), connections_.empty() ? -1 : kPollMs);
    if (ready[0].revents != 0) return;
    const bool accept = ready.back().fd == listener_ && ready.back().revents != 0;
    const absl::Time now = absl::Now();
    std::vector<Connection> kept;
    for (size_t k = 0; k < connections_.size(); ++k) {
      Connection& c = connections_[k];
      const bool keep = now < c.deadline && (ready[k + 1].revents == 0 || MoveOn(&c));
      if (keep) {
        kept.push_back(std::move(c));
      } else {
        close(c.fd);
      }
    }
    connections_ = std::move(kept);
    if (accept) Accept();
  }
}

void HttpPort::Accept() {
  const int fd = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (fd >= 0) {
    connections_.push_back({fd, absl::Now() + kTimeout});
  } else if (errno == EMFILE || errno == ENFILE) {
    absl::SleepFor(absl::Milliseconds(50));  // it stays ready: do not ask without a pause
  }
}

bool HttpPort::MoveOn(Connection* connection) const {
  Connection& c = *connection;
  if (c.response.empty()) {
    char buffer[1024];
    const ssize_t got = recv(c.fd, buffer, sizeof(buffer), 0);
    if (got <= 0) return got < 0 && (errno == EAGAIN || errno == EINTR);
    c.request.append(buffer, static_cast<size_t>(got));
    if (c.request.size() > kMaxRequestBytes) return false;
    if (absl::StrContains(c.request, "\r\n\r\n")) c.response = Respond(c.request);
    return true;
  }
  const ssize_t put =
      send(c.fd, c.response.data() + c.sent, c.response.size() - c.sent, MSG_NOSIGNAL);
  if (put < 0) return errno == EAGAIN || errno == EINTR;
  c.sent += static_cast<size_t>(put);
  return c.sent < c.response.size();
}

std::string HttpPort::Respond(const std::string& request) const {
  const auto response = [](const char* status, const std::string& type, const std::string& body) {
    return absl::StrCat("HTTP/1.1 ", status, "\r\nContent-Type: ", type,
                        "\r\nContent-Length: ", body.size(), "\r\nConnection: close\r\n\r\n", body);
  };
  if (!absl::StartsWith(request, "GET ")) {
    return response("405 Method Not Allowed", "text/plain", "GET only\n");
  }
  const std::string target = request.substr(4, request.find_first_of(" \r", 4) - 4);
  if (target.substr(0, target.find('?')) != page_.path) {
    return response("404 Not Found", "text/plain", absl::StrCat("there is ", page_.path, "\n"));
  }
  return response("200 OK", page_.content_type, page_.make());
}

}  // namespace cagefit::server
