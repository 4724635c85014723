// A proxy between client and server that does to a connection what networks do.
//
//   FaultProxy proxy(server_address, [](uint64_t connection) { return FaultPlan{...}; });
//   FitClient::Connect({proxy.address()});
//
// Faults come after counted bytes, so the same plan and the same bytes give the same fault.
#ifndef CAGEFIT_TESTS_SUPPORT_FAULT_PROXY_H_
#define CAGEFIT_TESTS_SUPPORT_FAULT_PROXY_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/fault_plan.h"

namespace cagefit::testing {

class FaultProxy {
 public:
  // Connections are counted from 0. Called on the proxy's own thread.
  using PlanFn = std::function<FaultPlan(uint64_t connection)>;

  // `server` is HOST:PORT (HOST an IPv4 address) or unix:PATH. Throws std::runtime_error without a
  // socket to listen on.
  FaultProxy(const std::string& server, PlanFn plan);
  // Resets what is still connected.
  ~FaultProxy();
  FaultProxy(const FaultProxy&) = delete;
  FaultProxy& operator=(const FaultProxy&) = delete;

  const std::string& address() const { return address_; }  // 127.0.0.1:PORT
  uint64_t connections() const { return connections_; }
  uint64_t faults() const { return faults_; }  // that have begun

 private:
  class Connection;
  void Run();
  void Accept();

  const std::string server_;
  const PlanFn plan_;
  std::string address_;
  int listener_ = -1;
  int stop_ = -1;  // an eventfd: readable when the thread is to end
  std::atomic<uint64_t> connections_{0}, faults_{0};
  std::vector<std::unique_ptr<Connection>> open_;  // of the thread
  std::thread thread_;
};

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SUPPORT_FAULT_PROXY_H_
