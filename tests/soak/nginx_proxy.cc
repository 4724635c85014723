#include "tests/soak/nginx_proxy.h"

#include <signal.h>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/time/clock.h"
#include "client/fit_client.h"

namespace cagefit::testing {
namespace {

constexpr char kProgram[] = "/usr/sbin/nginx";

// What the distribution's nginx.conf has around the http block's files. Its workers have to reach
// sockets that only this user may use.
std::string MainConfig(const std::string& folder) {
  return absl::StrReplaceAll(
      R"(daemon off;
user root;
pid FOLDER/pid;
error_log FOLDER/error.log warn;
worker_processes 1;
events { worker_connections 1024; }
http {
  access_log off;
  client_body_temp_path FOLDER/body;
  proxy_temp_path FOLDER/proxy;
  fastcgi_temp_path FOLDER/fastcgi;
  uwsgi_temp_path FOLDER/uwsgi;
  scgi_temp_path FOLDER/scgi;
  include cagefit.conf;
}
)",
      {{"FOLDER", folder}});
}

}  // namespace

NginxProxy::NginxProxy(const std::vector<std::string>& replicas)
    : address_(absl::StrCat("unix:", folder_.path(), "/socket")) {
  std::string servers;
  for (const std::string& replica : replicas) {
    absl::StrAppend(&servers, "server ", replica, " max_fails=0;\n");
  }
  WriteText(folder_.path() + "/cagefit_replicas.conf", servers);
  WriteText(folder_.path() + "/nginx.conf", MainConfig(folder_.path()));
  WriteText(folder_.path() + "/cagefit.conf",
            absl::StrReplaceAll(ReadText(CAGEFIT_NGINX_CONF),
                                {{"listen 50051", absl::StrCat("listen ", address_)}}));
}

NginxProxy::~NginxProxy() {
  if (running_ == nullptr) return;
  running_->Signal(SIGTERM);  // the master ends its workers
  running_->Wait();
}

absl::Status NginxProxy::Start() {
  running_ = std::make_unique<RunningProgram>(
      kProgram, std::vector<std::string>{"-p", folder_.path(), "-c", folder_.path() + "/nginx.conf",
                                         "-e", folder_.path() + "/error.log"});
  if (client::FitClient::Connect({address_, absl::Seconds(5)}).ok()) return absl::OkStatus();
  return absl::UnavailableError(
      absl::StrCat("nginx does not start: ", ReadText(folder_.path() + "/error.log")));
}

}  // namespace cagefit::testing
