// Plain stream sockets by address: 127.0.0.1:PORT (any IPv4 address) or unix:PATH.
#ifndef CAGEFIT_TESTS_SUPPORT_SOCKETS_H_
#define CAGEFIT_TESTS_SUPPORT_SOCKETS_H_

#include <string>

namespace cagefit::testing {

// A socket that listens on a free port of 127.0.0.1; its address goes to *address. Throws
// std::runtime_error, as the next two do.
int ListenOnFreePort(std::string* address);
int ListenOnPath(const std::string& path);

// Connected, blocking.
int Connect(const std::string& address);

// Closes so that the other side sees a reset.
void Reset(int socket);

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SUPPORT_SOCKETS_H_
