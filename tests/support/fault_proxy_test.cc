#include "tests/support/fault_proxy.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <random>
#include <string>
#include <thread>
#include <utility>

#include "tests/support/sockets.h"
#include "tests/support/temp_folder.h"

namespace cagefit::testing {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

std::string SomeBytes(size_t count) {
  std::mt19937 random(7);
  std::string bytes(count, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random());
  return bytes;
}

struct Listener {
  int socket;
  std::string address;
};

Listener AnyListener() {
  Listener listener;
  listener.socket = ListenOnFreePort(&listener.address);
  return listener;
}

// One connection through a proxy, both ends in this process.
class Ends {
 public:
  explicit Ends(const FaultPlan& plan, const Listener& listener = AnyListener())
      : proxy_(listener.address, [plan](uint64_t) { return plan; }) {
    client_ = Connect(proxy_.address());
    server_ = accept(listener.socket, nullptr, nullptr);
    close(listener.socket);
    const timeval patience = {20, 0};
    for (const int end : {client_, server_}) {
      setsockopt(end, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
    }
  }
  ~Ends() {
    close(client_);
    close(server_);
  }

  int client() const { return client_; }
  int server() const { return server_; }
  FaultProxy& proxy() { return proxy_; }

 private:
  FaultProxy proxy_;
  int client_ = -1, server_ = -1;
};

void SendAll(int socket, const std::string& bytes) {
  for (size_t at = 0; at < bytes.size();) {
    const ssize_t sent = send(socket, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
    if (sent < 0) return;  // the fault that is tested
    at += sent;
  }
}

// Up to `count` bytes; fewer at the end of the connection, whose errno (0: in order) goes to *end.
std::string ReceiveUpTo(int socket, size_t count, int* end = nullptr) {
  std::string bytes(count, '\0');
  size_t at = 0;
  if (end != nullptr) *end = 0;
  while (at < count) {
    const ssize_t got = recv(socket, bytes.data() + at, count - at, 0);
    if (got < 0 && end != nullptr) *end = errno;
    if (got <= 0) break;
    at += got;
  }
  bytes.resize(at);
  return bytes;
}

bool HasBytes(int socket, int wait_ms) {
  pollfd entry = {socket, POLLIN, 0};
  return poll(&entry, 1, wait_ms) == 1;
}

FaultPlan Plan(Fault fault, int64_t after_bytes, milliseconds time = milliseconds(0),
               Direction direction = Direction::kToServer) {
  FaultPlan plan;
  plan.fault = fault;
  plan.direction = direction;
  plan.after_bytes = after_bytes;
  plan.time = time;
  return plan;
}

TEST(FaultProxyTest, WithoutAFaultAllBytesPassBothWays) {
  Ends ends{FaultPlan()};
  const std::string bytes = SomeBytes(1 << 20);
  for (const auto& [from, to] :
       {std::pair(ends.client(), ends.server()), std::pair(ends.server(), ends.client())}) {
    std::thread sender([from = from, &bytes] { SendAll(from, bytes); });
    EXPECT_TRUE(ReceiveUpTo(to, bytes.size()) == bytes);
    sender.join();
  }
  EXPECT_EQ(ends.proxy().connections(), 1u);
  EXPECT_EQ(ends.proxy().faults(), 0u);
}

TEST(FaultProxyTest, TheEndOfOneSideIsPassedOnAndTheOtherSideStillAnswers) {
  Ends ends{FaultPlan()};
  SendAll(ends.client(), "question");
  shutdown(ends.client(), SHUT_WR);
  EXPECT_EQ(ReceiveUpTo(ends.server(), 100), "question");
  SendAll(ends.server(), "answer");
  shutdown(ends.server(), SHUT_WR);
  EXPECT_EQ(ReceiveUpTo(ends.client(), 100), "answer");
}

TEST(FaultProxyTest, WorksInFrontOfAUnixSocket) {
  const std::string path = cagefit::testing::TempFolder() + "fault_proxy";
  Ends ends(FaultPlan(), {ListenOnPath(path), "unix:" + path});
  SendAll(ends.client(), "hello");
  EXPECT_EQ(ReceiveUpTo(ends.server(), 5), "hello");
  std::filesystem::remove(path);
}

TEST(FaultProxyTest, TruncateEndsTheReceiverAfterExactlySoManyBytes) {
  Ends ends(Plan(Fault::kTruncate, 1000));
  const std::string bytes = SomeBytes(5000);
  SendAll(ends.client(), bytes);
  int end = -1;
  EXPECT_TRUE(ReceiveUpTo(ends.server(), 5000, &end) == bytes.substr(0, 1000));
  EXPECT_EQ(end, 0);
  EXPECT_EQ(ends.proxy().faults(), 1u);
}

TEST(FaultProxyTest, ResetIsAnErrorOnBothSides) {
  Ends ends(Plan(Fault::kReset, 1000));
  SendAll(ends.client(), SomeBytes(1000));
  EXPECT_TRUE(ReceiveUpTo(ends.server(), 1000) == SomeBytes(1000));
  SendAll(ends.client(), "x");
  int end = 0;
  EXPECT_EQ(ReceiveUpTo(ends.server(), 1, &end), "");
  EXPECT_EQ(end, ECONNRESET);
  EXPECT_EQ(ReceiveUpTo(ends.client(), 1, &end), "");
  EXPECT_EQ(end, ECONNRESET);
}

TEST(FaultProxyTest, HoldPassesNothingForAWhileAndThenEverything) {
  Ends ends(Plan(Fault::kHold, 10, milliseconds(200)));
  const Clock::time_point start = Clock::now();
  SendAll(ends.client(), SomeBytes(5000));
  EXPECT_TRUE(ReceiveUpTo(ends.server(), 10) == SomeBytes(10));
  EXPECT_FALSE(HasBytes(ends.server(), 50));
  EXPECT_TRUE(ReceiveUpTo(ends.server(), 4990) == SomeBytes(5000).substr(10));
  EXPECT_GE(Clock::now() - start, milliseconds(200));
}

TEST(FaultProxyTest, DelayMakesEveryBlockLate) {
  Ends ends(Plan(Fault::kDelay, 1, milliseconds(100)));
  for (const char* block : {"ab", "c"}) {
    const Clock::time_point start = Clock::now();
    SendAll(ends.client(), block);
    EXPECT_EQ(ReceiveUpTo(ends.server(), std::string(block).size()), block);
    EXPECT_GE(Clock::now() - start, milliseconds(100));
  }
}

TEST(FaultProxyTest, TricklePassesSoManyBytesATick) {
  FaultPlan plan = Plan(Fault::kTrickle, 0, milliseconds(20));
  plan.trickle_bytes = 3;
  Ends ends(plan);
  const Clock::time_point start = Clock::now();
  SendAll(ends.client(), "0123456789");
  EXPECT_EQ(ReceiveUpTo(ends.server(), 10), "0123456789");
  EXPECT_GE(Clock::now() - start, milliseconds(4 * 20));
}

TEST(FaultProxyTest, HalfOpenDropsOneDirectionAndKeepsTheOther) {
  Ends ends(Plan(Fault::kHalfOpen, 4));
  SendAll(ends.client(), "keptdropped");
  EXPECT_EQ(ReceiveUpTo(ends.server(), 4), "kept");
  SendAll(ends.client(), SomeBytes(1 << 20));  // goes nowhere, and blocks nobody
  shutdown(ends.client(), SHUT_WR);
  EXPECT_FALSE(HasBytes(ends.server(), 50));
  SendAll(ends.server(), "back");
  EXPECT_EQ(ReceiveUpTo(ends.client(), 4), "back");
}

TEST(FaultProxyTest, HalfOpenForATimeEndsWithAReset) {
  Ends ends(Plan(Fault::kHalfOpen, 0, milliseconds(50)));
  SendAll(ends.client(), "dropped");
  int end = 0;
  ReceiveUpTo(ends.server(), 1, &end);
  EXPECT_EQ(end, ECONNRESET);
}

TEST(FaultProxyTest, AFaultOfOneDirectionCountsTheBytesOfThatDirection) {
  Ends ends(Plan(Fault::kTruncate, 3, milliseconds(0), Direction::kToClient));
  const std::string bytes = SomeBytes(5000);
  SendAll(ends.client(), bytes);
  EXPECT_TRUE(ReceiveUpTo(ends.server(), 5000) == bytes);
  SendAll(ends.server(), "answer");
  EXPECT_EQ(ReceiveUpTo(ends.client(), 6), "ans");
}

TEST(FaultProxyTest, WithoutAServerTheClientIsReset) {
  std::string nobody;
  close(ListenOnFreePort(&nobody));
  FaultProxy proxy(nobody, [](uint64_t) { return FaultPlan(); });
  const int client = Connect(proxy.address());
  int end = 0;
  EXPECT_EQ(ReceiveUpTo(client, 1, &end), "");
  EXPECT_EQ(end, ECONNRESET);
  close(client);
}

TEST(FaultPlanTest, FollowsFromTheSeed) {
  const auto text = [](const FaultPlan& plan) {
    return std::to_string(static_cast<int>(plan.direction)) + " " +
           std::to_string(plan.after_bytes) + " " + std::to_string(plan.time.count());
  };
  EXPECT_EQ(text(RandomPlan(Fault::kReset, 1, 2)), text(RandomPlan(Fault::kReset, 1, 2)));
  EXPECT_NE(text(RandomPlan(Fault::kReset, 1, 2)), text(RandomPlan(Fault::kReset, 2, 2)));
  EXPECT_NE(text(RandomPlan(Fault::kReset, 1, 2)), text(RandomPlan(Fault::kReset, 1, 3)));
}

TEST(FaultPlanTest, FaultsAreFoundByName) {
  for (const Fault fault : kFaults) EXPECT_EQ(FaultNamed(NameOf(fault)), fault);
  EXPECT_EQ(FaultNamed("slow"), std::nullopt);
}

}  // namespace
}  // namespace cagefit::testing
