// A client of HTTP that is as small as can be.
#ifndef CAGEFIT_TESTS_SERVER_HTTP_GET_H_
#define CAGEFIT_TESTS_SERVER_HTTP_GET_H_

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>

#include "absl/strings/numbers.h"

namespace cagefit::server::testing {

// A connection to 127.0.0.1:PORT.
inline int Dial(const std::string& address) {
  int port = 0;
  EXPECT_TRUE(absl::SimpleAtoi(address.substr(address.rfind(':') + 1), &port));
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in to = {};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<uint16_t>(port));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(connect(fd, reinterpret_cast<sockaddr*>(&to), sizeof(to)), 0);
  return fd;
}

inline bool Say(int fd, const std::string& text) {
  return send(fd, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
}

inline std::string ReadToEnd(int fd) {
  std::string all;
  char buffer[4096];
  for (ssize_t got; (got = read(fd, buffer, sizeof(buffer))) > 0;) all.append(buffer, got);
  return all;
}

// The whole response.
inline std::string HttpGet(const std::string& address, const std::string& path) {
  const int fd = Dial(address);
  EXPECT_TRUE(Say(fd, "GET " + path + " HTTP/1.0\r\n\r\n"));
  const std::string response = ReadToEnd(fd);
  close(fd);
  return response;
}

}  // namespace cagefit::server::testing

#endif  // CAGEFIT_TESTS_SERVER_HTTP_GET_H_
