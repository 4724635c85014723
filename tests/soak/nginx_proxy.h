// nginx in front of replicas, as deploy/nginx sets it up.
#ifndef CAGEFIT_TESTS_SOAK_NGINX_PROXY_H_
#define CAGEFIT_TESTS_SOAK_NGINX_PROXY_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/base/private_folder.h"
#include "tests/e2e/program.h"

namespace cagefit::testing {

class NginxProxy {
 public:
  // `replicas`: their addresses.
  explicit NginxProxy(const std::vector<std::string>& replicas);
  ~NginxProxy();  // ends it

  const std::string& address() const { return address_; }
  // Returns when it listens; UNAVAILABLE, with what nginx wrote.
  absl::Status Start();

 private:
  const PrivateFolder folder_ = PrivateFolder::Create().value();
  const std::string address_;
  std::unique_ptr<RunningProgram> running_;
};

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SOAK_NGINX_PROXY_H_
