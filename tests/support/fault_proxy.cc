#include "tests/support/fault_proxy.h"

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "tests/support/faulty_pipe.h"
#include "tests/support/sockets.h"

namespace cagefit::testing {
namespace {

using Clock = FaultyPipe::Clock;

FaultPlan PlanFor(const FaultPlan& plan, Direction direction) {
  return plan.direction == direction ? plan : FaultPlan();
}

int PollMilliseconds(Clock::time_point until, Clock::time_point now) {
  if (until == Clock::time_point::max()) return -1;
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - now).count();
  return static_cast<int>(std::clamp<int64_t>(left, 0, 60'000));
}

}  // namespace

class FaultProxy::Connection {
 public:
  Connection(int client, int server, const FaultPlan& plan)
      : client_(client),
        server_(server),
        to_server_(client, server, PlanFor(plan, Direction::kToServer)),
        to_client_(server, client, PlanFor(plan, Direction::kToClient)) {}
  ~Connection() {
    if (client_ >= 0) Reset(client_);
    if (server_ >= 0) Reset(server_);
  }

  // An entry for each socket; returns when Step is to be called at the latest.
  Clock::time_point AddPolls(Clock::time_point now, std::vector<pollfd>* polls) const {
    polls->push_back(Poll(to_server_, to_client_, now));
    polls->push_back(Poll(to_client_, to_server_, now));
    return std::min(to_server_.NextTime(now), to_client_.NextTime(now));
  }

  // False when the connection is over. `faults` counts those that begin.
  bool Step(Clock::time_point now, std::atomic<uint64_t>* faults) {
    bool over = false;
    int ended = 0;
    for (FaultyPipe* pipe : {&to_server_, &to_client_}) {
      const bool begun = pipe->fault_began();
      const FaultyPipe::State state = pipe->Step(now);
      if (pipe->fault_began() && !begun) ++*faults;
      if (state == FaultyPipe::State::kEnded) ++ended;
      if (state == FaultyPipe::State::kTruncated) End(pipe->to());
      over = over || state == FaultyPipe::State::kTruncated || state == FaultyPipe::State::kReset;
    }
    if (ended == 2) {
      End(client_);
      End(server_);
    }
    return !over && ended < 2;
  }

 private:
  // A socket of which nothing is wanted is left out: poll would report its errors over and over.
  static pollfd Poll(const FaultyPipe& from, const FaultyPipe& to, Clock::time_point now) {
    const int events = (from.wants_bytes() ? POLLIN : 0) | (to.wants_room(now) ? POLLOUT : 0);
    return {events != 0 ? from.from() : -1, static_cast<short>(events), 0};
  }

  // Closes in order. Unread bytes would turn that into a reset.
  void End(int socket) {
    (socket == client_ ? client_ : server_) = -1;
    char ignored[4096];
    while (recv(socket, ignored, sizeof(ignored), MSG_DONTWAIT) > 0) {
    }
    close(socket);
  }

  int client_, server_;
  FaultyPipe to_server_, to_client_;
};

FaultProxy::FaultProxy(const std::string& server, PlanFn plan)
    : server_(server), plan_(std::move(plan)) {
  listener_ = ListenOnFreePort(&address_);
  stop_ = eventfd(0, EFD_CLOEXEC);
  thread_ = std::thread([this] { Run(); });
}

FaultProxy::~FaultProxy() {
  eventfd_write(stop_, 1);
  thread_.join();
  close(listener_);
  close(stop_);
}

void FaultProxy::Accept() {
  const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
  if (client < 0) return;
  const int one = 1;
  setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &one, sizeof(one));
  const uint64_t number = connections_++;
  try {
    open_.push_back(std::make_unique<Connection>(client, Connect(server_), plan_(number)));
  } catch (const std::runtime_error&) {
    Reset(client);  // as if the client had reached no server
  }
}

void FaultProxy::Run() {
  for (;;) {
    const Clock::time_point now = Clock::now();
    Clock::time_point until = Clock::time_point::max();
    std::vector<pollfd> polls = {{stop_, POLLIN, 0}, {listener_, POLLIN, 0}};
    for (const auto& connection : open_) until = std::min(until, connection->AddPolls(now, &polls));
    poll(polls.data(), polls.size(), PollMilliseconds(until, now));
    if (polls[0].revents != 0) break;
    const auto is_over = [this, now = Clock::now()](const std::unique_ptr<Connection>& connection) {
      return !connection->Step(now, &faults_);
    };
    open_.erase(std::remove_if(open_.begin(), open_.end(), is_over), open_.end());
    if (polls[1].revents != 0) Accept();
  }
  open_.clear();
}

}  // namespace cagefit::testing
