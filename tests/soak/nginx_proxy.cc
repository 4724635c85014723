#include "tests/soak/nginx_proxy.h"

#include <signal.h>

#include <cstdlib>
#include <filesystem>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/time/clock.h"
#include "client/fit_client.h"

namespace cagefit::testing {
namespace {

constexpr char kProgram[] = "/usr/sbin/nginx";

std::string NewFolder() {
  std::string path = (std::filesystem::temp_directory_path() / "cagefit_nginx.XXXXXX").string();
  return mkdtemp(path.data()) != nullptr ? path : "/nowhere";
}

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
    : folder_(NewFolder()), address_(absl::StrCat("unix:", folder_, "/socket")) {
  std::string servers;
  for (const std::string& replica : replicas) {
    absl::StrAppend(&servers, "server ", replica, " max_fails=0;\n");
  }
  WriteText(folder_ + "/cagefit_replicas.conf", servers);
  WriteText(folder_ + "/nginx.conf", MainConfig(folder_));
  WriteText(folder_ + "/cagefit.conf",
            absl::StrReplaceAll(ReadText(CAGEFIT_NGINX_CONF),
                                {{"listen 50051", absl::StrCat("listen ", address_)}}));
}

NginxProxy::~NginxProxy() {
  if (running_ != nullptr) {
    running_->Signal(SIGTERM);  // the master ends its workers
    running_->Wait();
  }
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

absl::Status NginxProxy::Start() {
  running_ = std::make_unique<RunningProgram>(
      kProgram, std::vector<std::string>{"-p", folder_, "-c", folder_ + "/nginx.conf", "-e",
                                         folder_ + "/error.log"});
  if (client::FitClient::Connect({address_, absl::Seconds(5)}).ok()) return absl::OkStatus();
  return absl::UnavailableError(
      absl::StrCat("nginx does not start: ", ReadText(folder_ + "/error.log")));
}

}  // namespace cagefit::testing
