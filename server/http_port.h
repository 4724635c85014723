// One page over HTTP, for scrapers: GET, one request a connection.
//
// prometheus-cpp's own server (civetweb) cannot start a thread here: its stacks of 100 KiB are
// smaller than the thread-local storage of this process's libraries (OpenBLAS, glog, METIS).
#ifndef CAGEFIT_SERVER_HTTP_PORT_H_
#define CAGEFIT_SERVER_HTTP_PORT_H_

#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"

namespace cagefit::server {

class HttpPort {
 public:
  struct Page {
    std::string path;  // such as /metrics
    std::string content_type;
    std::function<std::string()> make;  // called on the port's thread
  };
  static constexpr size_t kMaxConnections = 16;  // others wait to be accepted
  static constexpr size_t kMaxRequestBytes = 8192;
  static constexpr absl::Duration kTimeout = absl::Seconds(5);  // of a connection, in all

  // Serves at HOST:PORT (port 0: any free one) when it returns. INVALID_ARGUMENT for another
  // address, UNAVAILABLE naming one that cannot be listened on.
  static absl::StatusOr<std::unique_ptr<HttpPort>> Open(const std::string& address, Page page);
  // Closes all connections. Returns once the page is not being made any more.
  ~HttpPort();

  const std::string& address() const { return address_; }  // as given, with the port bound

 private:
  struct Connection;

  HttpPort(int listener, int stop, std::string address, Page page);

  void Serve();
  void Accept();
  // Goes on with a connection that is ready; false when it is to be closed.
  bool MoveOn(Connection* connection) const;
  std::string Respond(const std::string& request) const;

  const int listener_, stop_;  // the latter is readable when the thread is to end
  const std::string address_;
  const Page page_;
  std::vector<Connection> connections_;
  std::thread thread_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_HTTP_PORT_H_
