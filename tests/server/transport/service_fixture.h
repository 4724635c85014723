// The service on a Unix socket, with every part at hand. (gRPC's in-process channel buffers
// nothing: a write there waits for the read.)
#ifndef CAGEFIT_TESTS_SERVER_TRANSPORT_SERVICE_FIXTURE_H_
#define CAGEFIT_TESTS_SERVER_TRANSPORT_SERVICE_FIXTURE_H_

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ringbuffer_sink.h>

#include <chrono>
#include <future>
#include <memory>
#include <string>

#include "core/base/private_folder.h"
#include "server/transport/service.h"
#include "server/transport/status_convert.h"
#include "tests/server/session/session_fixture.h"

namespace cagefit::server::testing {

struct ServiceLimits {
  SessionStore::Limits store;
  Scheduler::Options scheduler;
  int64_t budget_bytes = int64_t{1} << 30;
  int64_t max_streams = 100;
};

struct TestService {
  explicit TestService(const ServiceLimits& limits = ServiceLimits())
      : store(limits.store, &journal, &templates, NoTime),
        budget("bytes in flight of all calls", limits.budget_bytes),
        streams(limits.max_streams),
        scheduler(limits.scheduler),
        service({&auth, &scheduler, &budget, &streams, NoTime,
                 std::make_shared<spdlog::logger>("", log), &metrics}) {
    grpc::ServerBuilder builder;
    const std::string address = "unix:" + folder.path() + "/socket";
    builder.AddListeningPort(address, grpc::InsecureServerCredentials());
    builder.RegisterService(&service);
    network = builder.BuildAndStart();
    stub = v1::Fitting::NewStub(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
  }
  ~TestService() { network->Shutdown(std::chrono::system_clock::now()); }

  // The id of a new session with a cage.
  std::string CreateSession() {
    return (*store.Create(Principal(), CageConfig(), absl::UnixEpoch()))->id();
  }

  // Returns once the fits that are queued for a session, and what they hold, are gone.
  void WaitForFits(const std::string& session_id) {
    std::promise<void> reached;
    ASSERT_TRUE(scheduler.fits.Run(session_id, [&reached] { reached.set_value(); }).ok());
    reached.get_future().wait();
  }

  std::shared_ptr<spdlog::sinks::ringbuffer_sink_mt> log =
      std::make_shared<spdlog::sinks::ringbuffer_sink_mt>(1000);
  PrivateFolder folder = PrivateFolder::Create().value();
  FakeTemplates templates;
  MemoryJournal journal;
  SessionStore store;
  Auth auth{&store, /*tokens=*/nullptr};
  MemoryAccount budget;
  StreamRegistry streams;
  Scheduler scheduler;
  Metrics metrics;
  FittingService service;
  std::unique_ptr<grpc::Server> network;
  std::unique_ptr<v1::Fitting::Stub> stub;
};

// A context that fails the test instead of letting it hang.
struct BoundedContext : grpc::ClientContext {
  BoundedContext() { set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(30)); }
};

// Of a call that has ended.
inline v1::ErrorDetail DetailOf(const grpc::ClientContext& context) {
  v1::ErrorDetail detail;
  const auto& trailers = context.GetServerTrailingMetadata();
  const auto found = trailers.find(kErrorDetailTrailer);
  if (found != trailers.end()) {
    detail.ParseFromArray(found->second.data(), static_cast<int>(found->second.size()));
  }
  return detail;
}

}  // namespace cagefit::server::testing

#endif  // CAGEFIT_TESTS_SERVER_TRANSPORT_SERVICE_FIXTURE_H_
