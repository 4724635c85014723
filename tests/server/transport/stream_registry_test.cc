#include "server/transport/stream_registry.h"

#include <gtest/gtest.h>

#include <vector>

#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

// Leaves the registry as soon as it is told to end, as a stream without frames does.
class FakeStream : public DrainableStream {
 public:
  explicit FakeStream(StreamRegistry* registry) : registry_(registry) {}
  void Drain(const absl::Status& status) override {
    drained.push_back(status);
    registry_->Remove(this);
  }
  std::vector<absl::Status> drained;

 private:
  StreamRegistry* const registry_;
};

TEST(StreamRegistryTest, RefusesMoreStreamsThanItsLimit) {
  StreamRegistry registry(2);
  const auto a = std::make_shared<FakeStream>(&registry),
             b = std::make_shared<FakeStream>(&registry),
             c = std::make_shared<FakeStream>(&registry);
  EXPECT_EQ(registry.Add(a), absl::OkStatus());
  EXPECT_EQ(registry.Add(b), absl::OkStatus());
  const absl::Status refused = registry.Add(c);
  EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
  EXPECT_EQ(refused.message(), "open streams is 3; the limit is 2");
  registry.Remove(a.get());
  EXPECT_EQ(registry.Add(c), absl::OkStatus());
}

TEST(StreamRegistryTest, RemovingAStreamThatWasRefusedChangesNothing) {
  StreamRegistry registry(1);
  const auto a = std::make_shared<FakeStream>(&registry),
             b = std::make_shared<FakeStream>(&registry);
  ASSERT_TRUE(registry.Add(a).ok());
  ASSERT_FALSE(registry.Add(b).ok());
  registry.Remove(b.get());
  EXPECT_FALSE(registry.Add(b).ok());
}

TEST(StreamRegistryTest, DrainingTellsEveryStreamOnceAndTakesNoMore) {
  StreamRegistry registry(10);
  const auto a = std::make_shared<FakeStream>(&registry),
             b = std::make_shared<FakeStream>(&registry);
  ASSERT_TRUE(registry.Add(a).ok());
  ASSERT_TRUE(registry.Add(b).ok());
  auto gone = std::make_shared<FakeStream>(&registry);
  ASSERT_TRUE(registry.Add(gone).ok());
  gone.reset();
  EXPECT_EQ(registry.CheckServing(), absl::OkStatus());

  registry.DrainAll();
  registry.DrainAll();

  for (const auto& stream : {a, b}) {
    ASSERT_EQ(stream->drained.size(), 1u);
    EXPECT_TRUE(absl::IsUnavailable(stream->drained[0])) << stream->drained[0];
    EXPECT_EQ(DetailOf(stream->drained[0])->reason, "DRAINING");
  }
  EXPECT_TRUE(absl::IsUnavailable(registry.CheckServing()));
  EXPECT_TRUE(absl::IsUnavailable(registry.Add(a)));
}

}  // namespace
}  // namespace cagefit::server
