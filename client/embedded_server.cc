#include "client/embedded_server.h"

#include <filesystem>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/private_folder.h"
#include "core/base/status.h"
#include "server/log.h"
#include "server/server.h"

namespace cagefit::client {

struct EmbeddedServer::Parts {
  PrivateFolder folder;  // outlives the server, whose socket is in it
  std::unique_ptr<server::Server> server;
  std::string address;
};

absl::StatusOr<std::unique_ptr<EmbeddedServer>> EmbeddedServer::Start(int threads,
                                                                      const std::string& store) {
  ASSIGN_OR_RETURN(PrivateFolder folder, PrivateFolder::Create());
  server::ServerOptions options;
  const std::string address = absl::StrCat("unix:", folder.path(), "/socket");
  options.listen = {address};
  options.threads = threads;
  options.store = store;
  std::error_code error;
  options.template_program = std::filesystem::read_symlink("/proc/self/exe", error).string();
  ASSIGN_OR_RETURN(std::unique_ptr<server::Server> server,
                   server::Server::Start(options, server::SilentLog()));
  return std::unique_ptr<EmbeddedServer>(new EmbeddedServer(
      std::make_unique<Parts>(Parts{std::move(folder), std::move(server), address})));
}

EmbeddedServer::EmbeddedServer(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
EmbeddedServer::~EmbeddedServer() = default;

const std::string& EmbeddedServer::address() const { return parts_->address; }

}  // namespace cagefit::client
