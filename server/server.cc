#include "server/server.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/status.h"
#include "server/housekeeping.h"
#include "server/machine_memory.h"
#include "server/metrics_port.h"
#include "server/network.h"
#include "server/process_memory.h"
#include "server/server_access.h"
#include "server/session/metrics.h"
#include "server/session/readiness.h"
#include "server/session/template_process.h"
#include "server/store/open_journal.h"
#include "server/transport/health_service.h"
#include "server/transport/record_convert.h"
#include "server/transport/service.h"

namespace cagefit::server {
namespace {

// The last line against floods of headers; admission is by the limits of the options.
constexpr int64_t kNetworkQuotaBytes = int64_t{256} << 20;
// What a process takes that counts nothing: code, stacks, tables, connections.
constexpr int64_t kBaseBytes = int64_t{96} << 20;

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

int64_t MaxMemoryBytes(const ServerOptions& options) {
  if (options.max_memory_mib > 0) return options.max_memory_mib << 20;
  return std::max(MachineMemoryBytes() / 5 * 4, int64_t{256} << 20);
}

int64_t QuotaBytes(const ServerOptions& options) {
  return std::min(kNetworkQuotaBytes, MaxMemoryBytes(options) / 8);
}

// What is counted may take: connections have theirs, and the allocator holds some between.
int64_t CountedBytes(const ServerOptions& options) {
  return (MaxMemoryBytes(options) - QuotaBytes(options) - kBaseBytes) / 20 * 17;
}

SessionStore::Limits StoreLimits(const ServerOptions& options, MemoryAccount* memory) {
  SessionStore::Limits limits;
  limits.memory = memory;
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

const RecordCodec* Codec() {
  static const ProtoRecordCodec* const codec = new ProtoRecordCodec;
  return codec;
}

}  // namespace

struct Server::Parts {
  Parts(const ServerOptions& options, ServerAccess access_of_options,
        std::shared_ptr<spdlog::logger> log)
      : access(std::move(access_of_options)),
        threads(tbb::global_control::max_allowed_parallelism, Threads(options)),
        templates(TemplateProgram(options),
                  {options.template_memory_mib << 20, absl::Seconds(options.template_seconds)}),
        resident(CountedBytes(options) + kBaseBytes),
        memory("memory of the server", CountedBytes(options),
               [this](int64_t bytes) { resident.MakeRoom(bytes); }),
        session_memory("memory of sessions", memory.limit() / 4 * 3, &memory),
        budget("bytes in flight of all calls",
               std::min(options.max_buffered_mib << 20, memory.limit() / 2), &memory),
        streams(options.max_streams),
        log(std::move(log)) {}

  absl::Status OpenStore(const ServerOptions& options);
  absl::Status Listen(const ServerOptions& options);
  void KeepHouse(const ServerOptions& options);

  ServerAccess access;
  Readiness readiness;
  Metrics metrics;
  tbb::global_control threads;
  TemplateProcess templates;
  std::unique_ptr<Journal> journal;
  ResidentLimit resident;
  // Neither can take all: frames can arrive whatever sessions hold, and the other way round.
  MemoryAccount memory, session_memory, budget;
  std::optional<SessionStore> store;
  std::optional<Auth> auth;
  StreamRegistry streams;
  std::shared_ptr<spdlog::logger> log;
  std::optional<Scheduler> scheduler;  // ends before the network does its last call
  std::optional<FittingService> service;
  HealthService health{&readiness}, plain_health{&readiness};
  Network network, health_network;  // the latter, where asked for, serves plain_health alone
  std::unique_ptr<HttpPort> metrics_port;
  std::optional<Housekeeping> housekeeping;
  std::once_flag shut_down;
};

absl::Status Server::Parts::OpenStore(const ServerOptions& options) {
  ASSIGN_OR_RETURN(journal, OpenJournal(options.store, Codec(), &metrics.store_seconds));
  store.emplace(StoreLimits(options, &session_memory), journal.get(), &templates, BusyMilliseconds);
  auth.emplace(&*store, access.tokens.get());
  return absl::OkStatus();
}

absl::Status Server::Parts::Listen(const ServerOptions& options) {
  const ServiceState state = {
      &*auth,  &scheduler.emplace(SchedulerOptions(options)), &budget, &streams, Milliseconds, log,
      &metrics};
  service.emplace(state);
  std::vector<Listener> listeners;
  for (const std::string& address : options.listen) {
    listeners.push_back({address, access.CredentialsFor(address)});
  }
  const int64_t quota_bytes = QuotaBytes(options);
  ASSIGN_OR_RETURN(network,
                   Serve(listeners, {&*service, &health},
                         options.reflection ? Reflection::kOn : Reflection::kOff, quota_bytes));
  if (!options.health_listen.empty()) {
    ASSIGN_OR_RETURN(health_network,
                     Serve({{options.health_listen, grpc::InsecureServerCredentials()}},
                           {&plain_health}, Reflection::kOff, quota_bytes));
  }
  if (!options.metrics_listen.empty()) {
    ASSIGN_OR_RETURN(metrics_port,
                     OpenMetricsPort(options.metrics_listen, state, readiness,
                                     [this] { return journal->Count().value_or(0); }));
  }
  return absl::OkStatus();
}

void Server::Parts::KeepHouse(const ServerOptions& options) {
  Housekeeping::Options housekeeping_options;
  if (options.session_ttl_seconds > 0) {
    housekeeping_options.time_to_live = absl::Seconds(options.session_ttl_seconds);
  }
  const auto see_store = [this](const absl::Status& status) {
    status.ok() ? readiness.Clear("store") : readiness.Set("store");
  };
  housekeeping.emplace(housekeeping_options, journal.get(), &*store, see_store, log);
}

absl::StatusOr<std::unique_ptr<Server>> Server::Start(const ServerOptions& options,
                                                      std::shared_ptr<spdlog::logger> log) {
  RETURN_IF_ERROR(options.Validate());
  ASSIGN_OR_RETURN(ServerAccess access, ServerAccess::Open(options, log));
  std::unique_ptr<Server> server(
      new Server(std::make_unique<Parts>(options, std::move(access), std::move(log))));
  Parts& parts = *server->parts_;
  RETURN_IF_ERROR(parts.OpenStore(options));
  parts.KeepHouse(options);
  RETURN_IF_ERROR(parts.Listen(options));
  return server;
}

Server::Server(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

Server::~Server() { Shutdown(absl::ZeroDuration()); }

const std::vector<std::string>& Server::addresses() const { return parts_->network.addresses; }

const std::vector<std::string>& Server::health_addresses() const {
  return parts_->health_network.addresses;
}

std::optional<std::string> Server::metrics_address() const {
  if (parts_->metrics_port == nullptr) return std::nullopt;
  return parts_->metrics_port->address();
}

void Server::StopBeingReady() { parts_->readiness.Set("draining"); }

void Server::Shutdown(absl::Duration drain) {
  std::call_once(parts_->shut_down, [this, drain] {
    StopBeingReady();
    parts_->streams.DrainAll();
    parts_->health.EndWatches();
    parts_->network.End(drain);
    parts_->metrics_port.reset();  // it reads the scheduler
    parts_->scheduler.reset();
    parts_->housekeeping.reset();
    parts_->plain_health.EndWatches();
    parts_->health_network.End(absl::ZeroDuration());
  });
}

}  // namespace cagefit::server
