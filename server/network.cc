#include "server/network.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/resource_quota.h>

#include <algorithm>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"

namespace cagefit::server {
namespace {

constexpr int kMaxMessageBytes = 4 << 20;
// gRPC parses what it receives, and two bytes may become eighty.
constexpr int kMaxReceivedBytes = 5 << 18;
// Of a stream, sent but not read: frames wait at the client, where its memory is. 10 MB a second
// over a way of 50 ms.
constexpr int kWindowBytes = 1 << 19;
constexpr int kKeepaliveMs = 30'000, kKeepaliveTimeoutMs = 10'000, kMinPingIntervalMs = 10'000;

void SetLimits(int64_t quota_bytes, grpc::ServerBuilder* builder) {
  builder->SetMaxReceiveMessageSize(kMaxReceivedBytes);
  builder->SetMaxSendMessageSize(kMaxMessageBytes);
  // A message is inflated before its size is checked: a small one could take a gigabyte.
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  builder->SetResourceQuota(
      grpc::ResourceQuota("cagefitd").Resize(static_cast<size_t>(quota_bytes)));
  // Probing would let the window grow to 16 MiB for every client that sends without being asked.
  builder->AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  builder->AddChannelArgument(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, kWindowBytes);
  // Otherwise two servers share a port without a word.
  builder->AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveMs);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepaliveTimeoutMs);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder->AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS,
                              kMinPingIntervalMs);
}

// Linking gRPC's reflection turns it on for all servers of a process.
class WithoutReflection : public grpc::ServerBuilderOption {
 public:
  void UpdateArguments(grpc::ChannelArguments*) override {}
  void UpdatePlugins(std::vector<std::unique_ptr<grpc::ServerBuilderPlugin>>* plugins) override {
    const std::string name = grpc::reflection::ProtoServerReflectionPlugin().name();
    plugins->erase(std::remove_if(plugins->begin(), plugins->end(),
                                  [&name](const auto& plugin) { return plugin->name() == name; }),
                   plugins->end());
  }
};

std::string WithPort(const std::string& address, int port) {
  if (absl::StartsWith(address, "unix:")) return address;
  return absl::StrCat(address.substr(0, address.rfind(':') + 1), port);
}

}  // namespace

void Network::End(absl::Duration drain) const {
  if (server != nullptr) server->Shutdown(absl::ToChronoTime(absl::Now() + drain));
}

absl::StatusOr<Network> Serve(const std::vector<Listener>& listeners,
                              const std::vector<grpc::Service*>& services, Reflection reflection,
                              int64_t quota_bytes) {
  grpc::ServerBuilder builder;
  SetLimits(quota_bytes, &builder);
  if (reflection == Reflection::kOff) builder.SetOption(std::make_unique<WithoutReflection>());
  for (grpc::Service* service : services) builder.RegisterService(service);
  std::vector<int> ports(listeners.size(), 0);
  for (size_t k = 0; k < ports.size(); ++k) {
    builder.AddListeningPort(listeners[k].address, listeners[k].credentials, &ports[k]);
  }
  Network network;
  network.server = builder.BuildAndStart();
  if (network.server == nullptr) {
    const auto failed = std::find(ports.begin(), ports.end(), 0) - ports.begin();
    return absl::UnavailableError(
        absl::StrCat("cannot listen on ", listeners[failed % ports.size()].address,
                     ": it is in use, not an address of this machine, or not allowed"));
  }
  for (size_t k = 0; k < ports.size(); ++k) {
    network.addresses.push_back(WithPort(listeners[k].address, ports[k]));
  }
  return network;
}

}  // namespace cagefit::server
