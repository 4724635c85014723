// Long sequences: what the client adds up is what the server has.
#include <gtest/gtest.h>

#include <optional>
#include <set>

#include "tests/server/running_server.h"

namespace cagefit::server {
namespace {

void ExpectTheServersBits(const v1::SessionOptions& options, uint64_t count,
                          const std::set<uint64_t>& checked) {
  const testing::RunningServer server;
  const auto client = server.Connect();
  v1::CreateSessionRequest request = testing::CageRequest();
  *request.mutable_options() = options;
  const auto session = client->CreateSession(request);
  ASSERT_TRUE(session.ok()) << session.status();
  auto stream = client->OpenStream(session->session_id());
  ASSERT_TRUE(stream.ok()) << stream.status();
  const auto frames = testing::FitMovingFrames(stream->get(), 0, count);
  uint64_t keys = 0;
  for (uint64_t number = 0; number < count; ++number) {
    ASSERT_EQ(frames[number].reply.outcome(), v1::OUTCOME_FITTED) << number;
    ASSERT_EQ(frames[number].reply.sequence_number(), number);
    keys += frames[number].reply.delta().key();
  }
  const uint64_t interval = options.quantum() > 0 ? options.key_interval() : 1;
  EXPECT_EQ(keys, (count + interval - 1) / interval);

  // Without a number: of the latest frame.
  const auto expect_the_servers = [&](uint64_t number, std::optional<uint64_t> asked) {
    v1::GetControlMeshRequest of;
    of.set_session_id(session->session_id());
    if (asked.has_value()) of.set_sequence_number(*asked);
    const auto mesh = client->GetControlMesh(of);
    ASSERT_TRUE(mesh.ok()) << mesh.status();
    EXPECT_EQ(frames[number].control_vertices, mesh->vertices()) << number;
  };
  for (const uint64_t number : checked) expect_the_servers(number, number);
  expect_the_servers(count - 1, std::nullopt);
}

TEST(SequenceTest, ReproducesTheServersVerticesOverAThousandFrames) {
  v1::SessionOptions options;
  options.set_quantum(1e-5);
  options.set_key_interval(400);
  ExpectTheServersBits(options, 1000, {0, 1, 2, 399, 400, 401, 750, 998, 999});
}

TEST(SequenceTest, ReproducesTheServersVerticesFromDraco) {
  v1::SessionOptions options;
  options.set_quantum(1e-5);
  options.set_key_interval(20);
  options.set_delta_encoding(v1::DELTA_ENCODING_DRACO);
  ExpectTheServersBits(options, 50, {0, 1, 19, 20, 33, 49});
}

TEST(SequenceTest, ReproducesTheServersVerticesWithoutAQuantum) {
  v1::SessionOptions options;
  options.set_quantum(0);
  ExpectTheServersBits(options, 50, {0, 1, 19, 20, 33, 49});
}

}  // namespace
}  // namespace cagefit::server
