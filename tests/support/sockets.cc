#include "tests/support/sockets.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <stdexcept>

namespace cagefit::testing {
namespace {

constexpr char kUnix[] = "unix:";

[[noreturn]] void Fail(const std::string& what) {
  throw std::runtime_error(what + ": " + std::strerror(errno));
}

sockaddr_un PathAddress(const std::string& path) {
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof(address.sun_path) - 1);
  return address;
}

template <typename Address>
const sockaddr* AsSockaddr(const Address& address) {
  return reinterpret_cast<const sockaddr*>(&address);
}

int NewSocket(int family) {
  const int fd = socket(family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) Fail("socket");
  return fd;
}

template <typename Address>
int Listen(const Address& address, int family) {
  const int fd = NewSocket(family);
  if (bind(fd, AsSockaddr(address), sizeof(address)) != 0) Fail("bind");
  if (listen(fd, 128) != 0) Fail("listen");
  return fd;
}

template <typename Address>
int ConnectTo(const Address& address, int family, const std::string& name) {
  const int fd = NewSocket(family);
  if (connect(fd, AsSockaddr(address), sizeof(address)) == 0) return fd;
  close(fd);
  Fail(name);
}

}  // namespace

int ListenOnFreePort(std::string* address) {
  sockaddr_in any = {};
  any.sin_family = AF_INET;
  any.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int fd = Listen(any, AF_INET);
  socklen_t size = sizeof(any);
  getsockname(fd, reinterpret_cast<sockaddr*>(&any), &size);
  *address = "127.0.0.1:" + std::to_string(ntohs(any.sin_port));
  return fd;
}

int ListenOnPath(const std::string& path) { return Listen(PathAddress(path), AF_UNIX); }

int Connect(const std::string& address) {
  if (address.rfind(kUnix, 0) == 0) {
    return ConnectTo(PathAddress(address.substr(sizeof(kUnix) - 1)), AF_UNIX, address);
  }
  const size_t colon = address.rfind(':');
  sockaddr_in to = {};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(colon + 1))));
  if (inet_pton(AF_INET, address.substr(0, colon).c_str(), &to.sin_addr) != 1) Fail(address);
  const int fd = ConnectTo(to, AF_INET, address);
  const int one = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &one, sizeof(one));
  return fd;
}

void Reset(int socket) {
  const linger at_once = {1, 0};
  setsockopt(socket, SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
  close(socket);
}

}  // namespace cagefit::testing
