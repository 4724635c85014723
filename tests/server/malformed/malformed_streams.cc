#include <limits>

#include "absl/strings/str_cat.h"
#include "tests/server/malformed/malformed_request.h"
#include "tests/support/frames.h"

namespace cagefit::server::testing {
namespace {

using Messages = std::vector<v1::FitFramesRequest>;
using MessagesFn = std::function<Messages(const Target&)>;

constexpr size_t kMiB = 1 << 20;

MalformedRequest Stream(const std::string& name, const std::string& field, const MessagesFn& make) {
  MalformedRequest request;
  request.name = name;
  request.send = [make](const Target& target) { return EndOfStream(target, make(target)); };
  request.reason = "INVALID_FIELD";
  request.field = field;
  return request;
}

// Of a stream that is open.
MalformedRequest Opened(const std::string& name, const std::string& field, const Messages& rest) {
  return Stream(name, field, [rest](const Target& target) {
    Messages messages = {Open(target.session_id)};
    messages.insert(messages.end(), rest.begin(), rest.end());
    return messages;
  });
}

MalformedRequest Violation(MalformedRequest request) {
  request.reason = "PROTOCOL_VIOLATION";
  return request;
}

MalformedRequest WithValue(MalformedRequest request, const std::string& value) {
  request.value = value;
  return request;
}

MalformedRequest With(MalformedRequest request, absl::StatusCode code, const std::string& reason) {
  request.code = code;
  request.reason = reason;
  return request;
}

v1::FitFramesRequest Changed(v1::FitFramesRequest header,
                             const std::function<void(v1::FrameHeader*)>& change) {
  change(header.mutable_header());
  return header;
}

std::string FrameZero() {
  return cagefit::testing::FrameBytes(cagefit::testing::MovingCloud(0, 100));
}

void AddOpenings(std::vector<MalformedRequest>* requests) {
  const auto unopened = [](const Messages& messages) {
    return [messages](const Target&) { return messages; };
  };
  requests->push_back(
      WithValue(Stream("a stream without a message", "open", unopened({})), "not sent"));
  requests->push_back(
      Violation(Stream("a header first", "open", unopened({Header(0, 1), Chunk("x")}))));
  requests->push_back(Violation(Stream("a chunk first", "open", unopened({Chunk("x")}))));
  requests->push_back(
      Violation(Stream("an empty message first", "open", unopened({v1::FitFramesRequest()}))));
  for (const std::string id : {"", "nobody", "../../etc/passwd", "%00%s%n"}) {
    requests->push_back(WithValue(
        With(Stream("a stream of session \"" + id + "\"", "session_id", unopened({Open(id)})),
             absl::StatusCode::kNotFound, "NO_SESSION"),
        id));
  }
  requests->push_back(Violation(Stream("a second opening", "open", [](const Target& target) {
    return Messages{Open(target.session_id), Open(target.session_id)};
  })));
  requests->push_back(Violation(Stream("an opening within a frame", "open", [](const Target& t) {
    return Messages{Open(t.session_id), Header(1, 10), Open(t.session_id)};
  })));
}

void AddOrder(std::vector<MalformedRequest>* requests) {
  requests->push_back(Violation(Opened("an empty message", "message", {v1::FitFramesRequest()})));
  requests->push_back(Violation(Opened("a chunk without a header", "chunk", {Chunk("x")})));
  requests->push_back(
      Violation(Opened("two headers in a row", "chunk", {Header(1, 10), Header(1, 10)})));
  requests->push_back(Violation(
      Opened("a header within a frame", "chunk", {Header(1, 10), Chunk("12345"), Header(2, 5)})));
  requests->push_back(Violation(Opened("an end behind a header", "chunk", {Header(1, 10)})));
  requests->push_back(
      Violation(Opened("an end within a frame", "chunk", {Header(1, 10), Chunk("123456789")})));
}

void AddChunks(std::vector<MalformedRequest>* requests) {
  requests->push_back(WithValue(Opened("an empty chunk", "chunk.data", {Header(1, 10), Chunk("")}),
                                "0 bytes long"));
  requests->push_back(WithValue(Opened("a chunk above 1 MiB", "chunk.data",
                                       {Header(1, kMiB + 1), Chunk(std::string(kMiB + 1, 'x'))}),
                                "1048577 bytes long"));
  requests->push_back(WithValue(
      Opened("a chunk beyond the total", "chunk.data", {Header(1, 10), Chunk("0123456789A")}),
      "11 bytes in all"));
  requests->push_back(WithValue(Opened("a last chunk beyond the total", "chunk.data",
                                       {Header(1, 10), Chunk("01234567"), Chunk("89A")}),
                                "11 bytes in all"));
}

void AddHeaders(std::vector<MalformedRequest>* requests) {
  for (const uint64_t bytes : {(uint64_t{kMaxFrameMib} << 20) + 1, uint64_t{1} << 40,
                               std::numeric_limits<uint64_t>::max()}) {
    requests->push_back(WithValue(With(Opened(absl::StrCat("a frame of ", bytes, " bytes"),
                                              "header.total_bytes", {Header(1, bytes)}),
                                       absl::StatusCode::kResourceExhausted, "LIMIT_EXCEEDED"),
                                  absl::StrCat(bytes)));
  }
  for (const int encoding : {2, 99, -1}) {
    requests->push_back(WithValue(Opened(absl::StrCat("encoding ", encoding), "header.encoding",
                                         {Changed(Header(1, 10),
                                                  [encoding](v1::FrameHeader* header) {
                                                    header->set_encoding(
                                                        static_cast<v1::FrameEncoding>(encoding));
                                                  })}),
                                  absl::StrCat(encoding)));
  }
  const auto timestamp = [&](int64_t seconds, int32_t nanos) {
    requests->push_back(
        WithValue(Opened(absl::StrCat("a timestamp of ", seconds, " s and ", nanos, " ns"),
                         "header.timestamp",
                         {Changed(Header(1, 10),
                                  [seconds, nanos](v1::FrameHeader* header) {
                                    header->mutable_timestamp()->set_seconds(seconds);
                                    header->mutable_timestamp()->set_nanos(nanos);
                                  })}),
                  absl::StrCat(seconds, " s and ", nanos, " ns")));
  };
  timestamp(0, -1);
  timestamp(0, 1'000'000'000);
  timestamp(-62'135'596'801, 0);
  timestamp(253'402'300'800, 0);
  timestamp(std::numeric_limits<int64_t>::min(), 0);
  timestamp(std::numeric_limits<int64_t>::max(), 999'999'999);
}

// The session has answered frame 0.
void AddNumbers(std::vector<MalformedRequest>* requests) {
  const std::string bytes = FrameZero();
  for (const uint64_t number : {uint64_t{2}, std::numeric_limits<uint64_t>::max()}) {
    requests->push_back(WithValue(
        With(Opened(absl::StrCat("frame ", number, " where 1 is due"), "header.sequence_number",
                    {Header(number, bytes.size()), Chunk(bytes)}),
             absl::StatusCode::kOutOfRange, "SEQUENCE_GAP"),
        absl::StrCat(number)));
  }
  requests->push_back(WithValue(With(Opened("frame 0 again with other bytes",
                                            "header.sequence_number", {Header(0, 1), Chunk("x")}),
                                     absl::StatusCode::kAlreadyExists, "SEQUENCE_CONFLICT"),
                                "0"));
}

void AddLandmarks(std::vector<MalformedRequest>* requests) {
  requests->push_back(WithValue(With(Opened("10,001 landmarks", "header.landmarks",
                                            {Changed(Header(1, 10),
                                                     [](v1::FrameHeader* header) {
                                                       for (int k = 0; k <= 10'000; ++k) {
                                                         header->add_landmarks()->set_vertex(0);
                                                       }
                                                     })}),
                                     absl::StatusCode::kResourceExhausted, "LIMIT_EXCEEDED"),
                                "10001"));
  requests->push_back(WithValue(Opened("a landmark without a place", "header.landmarks[1].place",
                                       {Changed(Header(1, 10),
                                                [](v1::FrameHeader* header) {
                                                  header->add_landmarks()->set_vertex(0);
                                                  header->add_landmarks()->set_x(1);
                                                })}),
                                "not set"));
  requests->push_back(WithValue(
      Opened("a landmark at vertex 2^31", "header.landmarks[0].vertex",
             {Changed(Header(1, 10),
                      [](v1::FrameHeader* h) { h->add_landmarks()->set_vertex(1u << 31); })}),
      "2147483648"));
  requests->push_back(WithValue(
      Opened("a landmark in triangle 2^32 - 1", "header.landmarks[0].surface.triangle",
             {Changed(Header(1, 10),
                      [](v1::FrameHeader* header) {
                        header->add_landmarks()->mutable_surface()->set_triangle(0xFFFFFFFF);
                      })}),
      "4294967295"));
}

}  // namespace

std::vector<MalformedRequest> MalformedStreams() {
  std::vector<MalformedRequest> requests;
  AddOpenings(&requests);
  AddOrder(&requests);
  AddChunks(&requests);
  AddHeaders(&requests);
  AddNumbers(&requests);
  AddLandmarks(&requests);
  return requests;
}

}  // namespace cagefit::server::testing
