#include "server/transport/health_service.h"

#include <grpcpp/grpcpp.h>

#include <optional>
#include <utility>

#include "cagefit/v1/fitting.grpc.pb.h"

namespace cagefit::server {

using grpc::health::v1::HealthCheckRequest;
using grpc::health::v1::HealthCheckResponse;

namespace {

grpc::Status ShuttingDown() {
  return {grpc::StatusCode::UNAVAILABLE, "the server is shutting down"};
}

}  // namespace

// One Watch call. Everything but the reactions runs under the service's mutex.
class HealthService::Watcher : public grpc::ServerWriteReactor<HealthCheckResponse> {
 public:
  Watcher(HealthService* service, std::string name) : service_(service), name_(std::move(name)) {}

  void TellStatus() {
    if (writing_ || finished_) return;
    const Status status = service_->StatusOf(name_);
    if (told_ != status) {
      told_ = status;
      response_.set_status(status);
      writing_ = true;
      StartWrite(&response_);
    } else if (end_.has_value()) {
      finished_ = true;
      Finish(*end_);
    }
  }

  void FinishNow(const grpc::Status& status) {
    finished_ = true;
    Finish(status);
  }

  // Once the latest status is told.
  void End(const grpc::Status& status) {
    if (!end_.has_value()) end_ = status;
    TellStatus();
  }

  void OnWriteDone(bool ok) override {
    std::lock_guard<std::mutex> lock(service_->mutex_);
    writing_ = false;
    if (ok) return TellStatus();
    FinishNow(grpc::Status(grpc::StatusCode::CANCELLED, "the client is gone"));
  }

  void OnCancel() override {
    std::lock_guard<std::mutex> lock(service_->mutex_);
    End(grpc::Status(grpc::StatusCode::CANCELLED, "cancelled"));
  }

  void OnDone() override {
    {
      std::lock_guard<std::mutex> lock(service_->mutex_);
      service_->watchers_.erase(this);
    }
    delete this;
  }

 private:
  HealthService* const service_;
  const std::string name_;
  HealthCheckResponse response_;
  std::optional<Status> told_;
  std::optional<grpc::Status> end_;
  bool writing_ = false, finished_ = false;
};

HealthService::HealthService(Readiness* readiness) : readiness_(readiness) {
  readiness->Listen([this](bool) {
    std::lock_guard<std::mutex> lock(mutex_);
    for (Watcher* watcher : watchers_) watcher->TellStatus();
  });
}

grpc::ServerUnaryReactor* HealthService::Check(grpc::CallbackServerContext* context,
                                               const HealthCheckRequest* request,
                                               HealthCheckResponse* response) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  response->set_status(StatusOf(request->service()));
  reactor->Finish(response->status() == HealthCheckResponse::SERVICE_UNKNOWN
                      ? grpc::Status(grpc::StatusCode::NOT_FOUND,
                                     "service: expected none or cagefit.v1.Fitting")
                      : grpc::Status::OK);
  return reactor;
}

grpc::ServerWriteReactor<HealthCheckResponse>* HealthService::Watch(
    grpc::CallbackServerContext*, const HealthCheckRequest* request) {
  auto* watcher = new Watcher(this, request->service());
  std::lock_guard<std::mutex> lock(mutex_);
  if (watchers_.size() >= kMaxWatches) {
    watcher->FinishNow(grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED, "too many watches"));
    return watcher;
  }
  watchers_.insert(watcher);
  if (ended_) {
    watcher->End(ShuttingDown());
  } else {
    watcher->TellStatus();
  }
  return watcher;
}

void HealthService::EndWatches() {
  std::lock_guard<std::mutex> lock(mutex_);
  ended_ = true;
  for (Watcher* watcher : watchers_) {
    watcher->End(ShuttingDown());
  }
}

HealthService::Status HealthService::StatusOf(const std::string& service) const {
  if (service.empty()) return HealthCheckResponse::SERVING;
  if (service != v1::Fitting::service_full_name()) return HealthCheckResponse::SERVICE_UNKNOWN;
  return readiness_->is_ready() ? HealthCheckResponse::SERVING : HealthCheckResponse::NOT_SERVING;
}

}  // namespace cagefit::server
