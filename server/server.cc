#include "server/server.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "core/base/status.h"
#include "server/housekeeping.h"
#include "server/server_access.h"
#include "server/session/template_process.h"
#include "server/store/open_journal.h"
#include "server/transport/record_convert.h"
#include "server/transport/service.h"

namespace cagefit::server {
namespace {

constexpr int kMaxMessageBytes = 4 << 20;
// The last line against floods of headers; admission is by the limits of the options.
constexpr size_t kNetworkQuotaBytes = size_t{256} << 20;
constexpr int kKeepaliveMs = 30'000, kKeepaliveTimeoutMs = 10'000, kMinPingIntervalMs = 10'000;

double Milliseconds() {
  return std::chrono::duration<double, std::milli>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

int Threads(const ServerOptions& options) {
  if (options.threads > 0) return static_cast<int>(options.threads);
  return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

Scheduler::Options SchedulerOptions(const ServerOptions& options) {
  const int threads = Threads(options);
  Scheduler::Options scheduler;
  scheduler.fit_threads =
      options.fits > 0 ? static_cast<int>(options.fits) : std::max(1, threads / 2);
  scheduler.decode_threads = std::max(1, threads / 2);
  scheduler.query_threads = std::max(1, threads / 4);
  return scheduler;
}

SessionStore::Limits StoreLimits(const ServerOptions& options) {
  SessionStore::Limits limits;
  limits.max_sessions = options.max_sessions;
  limits.session.decode.max_points = options.max_points;
  limits.session.max_frame_bytes = options.max_frame_mib << 20;
  limits.session.max_control_vertices = static_cast<int32_t>(options.max_control_vertices);
  limits.session.max_frames = options.max_frames;
  limits.session.max_history_bytes = options.max_history_mib << 20;
  return limits;
}

std::string TemplateProgram(const ServerOptions& options) {
  if (!options.template_program.empty()) return options.template_program;
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  return (self.parent_path() / "cagefit").string();
}

// AddressSanitizer, which the child then has too, maps terabytes of address space.
int64_t TemplateMemoryBytes(const ServerOptions& options) {
#ifdef __SANITIZE_ADDRESS__
  static_cast<void>(options);
  return 0;
#else
  return options.template_memory_mib << 20;
#endif
}

void Configure(grpc::ServerBuilder* builder) {
  builder->SetMaxReceiveMessageSize(kMaxMessageBytes);
  builder->SetMaxSendMessageSize(kMaxMessageBytes);
  // A message is inflated before its size is checked: a small one could take a gigabyte.
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  builder->SetResourceQuota(grpc::ResourceQuota("cagefitd").Resize(kNetworkQuotaBytes));
  // Otherwise two servers share a port without a word.
  builder->AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveMs);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepaliveTimeoutMs);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder->AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS,
                              kMinPingIntervalMs);
}

// Of one server: gRPC's own switch turns it on for all servers of a process.
class ReflectionOption : public grpc::ServerBuilderOption {
 public:
  void UpdateArguments(grpc::ChannelArguments*) override {}
  void UpdatePlugins(std::vector<std::unique_ptr<grpc::ServerBuilderPlugin>>* plugins) override {
    plugins->push_back(std::make_unique<grpc::reflection::ProtoServerReflectionPlugin>());
  }
};

std::string WithPort(const std::string& address, int port) {
  if (absl::StartsWith(address, "unix:")) return address;
  return absl::StrCat(address.substr(0, address.rfind(':') + 1), port);
}

}  // namespace

struct Server::Parts {
  Parts(const ServerOptions& options, ServerAccess access_of_options,
        std::unique_ptr<Journal> journal_of_options, std::shared_ptr<spdlog::logger> log)
      : access(std::move(access_of_options)),
        threads(tbb::global_control::max_allowed_parallelism, Threads(options)),
        templates(TemplateProgram(options),
                  {TemplateMemoryBytes(options), absl::Seconds(options.template_seconds)}),
        journal(std::move(journal_of_options)),
        store(StoreLimits(options), journal.get(), &templates, Milliseconds),
        auth(&store, access.tokens.get()),
        budget(options.max_buffered_mib << 20),
        streams(options.max_streams),
        service({&auth, &scheduler.emplace(SchedulerOptions(options)), &budget, &streams,
                 Milliseconds, std::move(log)}) {}

  void KeepHouse(const ServerOptions& options, std::shared_ptr<spdlog::logger> log) {
    Housekeeping::Options housekeeping_options;
    if (options.session_ttl_seconds > 0) {
      housekeeping_options.time_to_live = absl::Seconds(options.session_ttl_seconds);
    }
    housekeeping.emplace(
        housekeeping_options, journal.get(), &store,
        [this](const absl::Status& status) {
          if (!streams.CheckServing().ok()) return;
          network->GetHealthCheckService()->SetServingStatus(v1::Fitting::service_full_name(),
                                                             status.ok());
        },
        std::move(log));
  }

  ServerAccess access;
  tbb::global_control threads;
  TemplateProcess templates;
  std::unique_ptr<Journal> journal;
  SessionStore store;
  Auth auth;
  ByteBudget budget;
  StreamRegistry streams;
  std::optional<Scheduler> scheduler;  // ends before the network does its last call
  FittingService service;
  std::unique_ptr<grpc::Server> network;
  std::optional<Housekeeping> housekeeping;
  std::vector<std::string> addresses;
  std::once_flag shut_down;
};

absl::StatusOr<std::unique_ptr<Server>> Server::Start(const ServerOptions& options,
                                                      std::shared_ptr<spdlog::logger> log) {
  RETURN_IF_ERROR(options.Validate());
  static std::once_flag plugins;
  std::call_once(plugins, [] { grpc::EnableDefaultHealthCheckService(true); });
  ASSIGN_OR_RETURN(ServerAccess access, ServerAccess::Open(options, log));
  static const ProtoRecordCodec* const codec = new ProtoRecordCodec;
  ASSIGN_OR_RETURN(std::unique_ptr<Journal> journal, OpenJournal(options.store, codec));
  auto parts = std::make_unique<Parts>(options, std::move(access), std::move(journal), log);
  grpc::ServerBuilder builder;
  Configure(&builder);
  if (options.reflection) builder.SetOption(std::make_unique<ReflectionOption>());
  builder.RegisterService(&parts->service);
  std::vector<int> ports(options.listen.size(), 0);
  for (size_t k = 0; k < ports.size(); ++k) {
    builder.AddListeningPort(options.listen[k], parts->access.CredentialsFor(options.listen[k]),
                             &ports[k]);
  }
  parts->network = builder.BuildAndStart();
  for (size_t k = 0; k < ports.size(); ++k) {
    if (ports[k] == 0 || parts->network == nullptr) {
      return absl::UnavailableError(
          absl::StrCat("cannot listen on ", options.listen[k],
                       ": it is in use, not an address of this machine, or not allowed"));
    }
    parts->addresses.push_back(WithPort(options.listen[k], ports[k]));
  }
  parts->KeepHouse(options, std::move(log));
  return std::unique_ptr<Server>(new Server(std::move(parts)));
}

Server::Server(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

Server::~Server() { Shutdown(absl::ZeroDuration()); }

const std::vector<std::string>& Server::addresses() const { return parts_->addresses; }

void Server::Shutdown(absl::Duration drain) {
  std::call_once(parts_->shut_down, [this, drain] {
    parts_->network->GetHealthCheckService()->SetServingStatus(false);
    parts_->streams.DrainAll();
    parts_->network->Shutdown(absl::ToChronoTime(absl::Now() + drain));
    parts_->scheduler.reset();
    parts_->housekeeping.reset();
  });
}

}  // namespace cagefit::server
