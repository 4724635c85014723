#include <grpcpp/grpcpp.h>

#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "client/mesh_from_proto.h"
#include "client/status_from_grpc.h"
#include "tests/server/malformed/malformed_request.h"
#include "tests/support/frames.h"

namespace cagefit::server::testing {
namespace {

using SendFn = std::function<absl::Status(const Target&)>;

MalformedRequest Query(const std::string& name, const std::string& field, const std::string& value,
                       const SendFn& send) {
  MalformedRequest request;
  request.name = name;
  request.send = send;
  request.reason = "INVALID_FIELD";
  request.field = field;
  request.value = value;
  return request;
}

MalformedRequest With(MalformedRequest request, absl::StatusCode code, const std::string& reason) {
  request.code = code;
  request.reason = reason;
  return request;
}

template <typename Request>
Request Of(const std::string& session_id) {
  Request request;
  request.set_session_id(session_id);
  return request;
}

void AddSessions(std::vector<MalformedRequest>* requests) {
  for (const std::string id : {"", "nobody", "\n\t%s", "00000000000000000000000000000000"}) {
    const auto add = [&](const char* call, const SendFn& send) {
      requests->push_back(
          With(Query(absl::StrCat(call, " of \"", id, "\""), "session_id", id, send),
               absl::StatusCode::kNotFound, "NO_SESSION"));
    };
    add("GetSession", [id](const Target& t) { return t.client->GetSession(id).status(); });
    add("DeleteSession", [id](const Target& t) { return t.client->DeleteSession(id); });
    add("GetControlMesh", [id](const Target& t) {
      return t.client->GetControlMesh(Of<v1::GetControlMeshRequest>(id)).status();
    });
    add("GetSurface", [id](const Target& t) {
      return t.client->GetSurface(Of<v1::GetSurfaceRequest>(id)).status();
    });
    add("GetStencils", [id](const Target& t) {
      return t.client->GetStencils(Of<v1::GetStencilsRequest>(id)).status();
    });
    add("EvaluateLoss", [id](const Target& t) {
      auto request = Of<v1::EvaluateLossRequest>(id);
      for (int k = 0; k < 3; ++k) request.add_vertices(k);
      return t.client->EvaluateLoss(request).status();
    });
  }
}

void AddSurfaces(std::vector<MalformedRequest>* requests) {
  for (const uint32_t levels : {6u, 64u, 0xFFFFFFFFu}) {
    requests->push_back(Query(absl::StrCat("a surface of ", levels, " levels"), "levels",
                              absl::StrCat(levels), [levels](const Target& t) {
                                auto request = Of<v1::GetSurfaceRequest>(t.session_id);
                                request.set_levels(levels);
                                return t.client->GetSurface(request).status();
                              }));
    requests->push_back(Query(absl::StrCat("stencils of ", levels, " levels"), "levels",
                              absl::StrCat(levels), [levels](const Target& t) {
                                auto request = Of<v1::GetStencilsRequest>(t.session_id);
                                request.set_levels(levels);
                                return t.client->GetStencils(request).status();
                              }));
  }
  for (const uint32_t bits : {0u, 7u, 31u, 0xFFFFFFFFu}) {
    requests->push_back(Query(absl::StrCat("a surface of ", bits, " bits"), "position_bits",
                              absl::StrCat(bits), [bits](const Target& t) {
                                auto request = Of<v1::GetSurfaceRequest>(t.session_id);
                                request.set_position_bits(bits);
                                return t.client->GetSurface(request).status();
                              }));
  }
  for (const uint64_t number : {uint64_t{1}, std::numeric_limits<uint64_t>::max()}) {
    const auto add = [&](const char* call, const SendFn& send) {
      requests->push_back(With(Query(absl::StrCat(call, " of frame ", number), "sequence_number",
                                     absl::StrCat(number), send),
                               absl::StatusCode::kNotFound, "FRAME_NOT_FITTED"));
    };
    add("GetSurface", [number](const Target& t) {
      auto request = Of<v1::GetSurfaceRequest>(t.session_id);
      request.set_sequence_number(number);
      return t.client->GetSurface(request).status();
    });
    add("GetControlMesh", [number](const Target& t) {
      auto request = Of<v1::GetControlMeshRequest>(t.session_id);
      request.set_sequence_number(number);
      return t.client->GetControlMesh(request).status();
    });
  }
}

// The session's cage has 12 control vertices.
v1::EvaluateLossRequest LossOf(const Target& target) {
  auto request = Of<v1::EvaluateLossRequest>(target.session_id);
  *request.mutable_vertices() = client::ToProto(cagefit::testing::FrameCage(0)).vertices();
  return request;
}

MalformedRequest Loss(const std::string& name, const std::string& field, const std::string& value,
                      const std::function<void(v1::EvaluateLossRequest*)>& spoil) {
  return Query("a loss with " + name, field, value, [spoil](const Target& target) {
    v1::EvaluateLossRequest request = LossOf(target);
    spoil(&request);
    return target.client->EvaluateLoss(request).status();
  });
}

void AddLosses(std::vector<MalformedRequest>* requests) {
  requests->push_back(
      Loss("35 numbers", "vertices", "35 values long",
           [](v1::EvaluateLossRequest* request) { request->mutable_vertices()->RemoveLast(); }));
  requests->push_back(
      Loss("11 vertices", "vertices", "11 vertices",
           [](v1::EvaluateLossRequest* request) { request->mutable_vertices()->Truncate(33); }));
  requests->push_back(Loss("no vertices", "vertices", "0 vertices",
                           [](v1::EvaluateLossRequest* request) { request->clear_vertices(); }));
  for (const double value : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    requests->push_back(
        Loss(absl::StrCat("a vertex at ", value), "vertices[7]", absl::StrCat(value),
             [value](v1::EvaluateLossRequest* request) { request->set_vertices(7, value); }));
  }
  requests->push_back(
      Loss("an unknown encoding", "frame.encoding", "9", [](v1::EvaluateLossRequest* request) {
        request->mutable_frame()->set_encoding(static_cast<v1::FrameEncoding>(9));
      }));
  MalformedRequest text = Loss("a frame of text", "frame.data", "", [](v1::EvaluateLossRequest* r) {
    r->mutable_frame()->set_data("no Draco");
  });
  text.reason = "BAD_FRAME";
  requests->push_back(text);
  requests->push_back(
      Loss("a wrong point_count", "frame.point_count", "99", [](v1::EvaluateLossRequest* request) {
        request->mutable_frame()->set_data(
            cagefit::testing::FrameBytes(cagefit::testing::MovingCloud(0, 100)));
        request->mutable_frame()->set_point_count(99);
      }));
  requests->push_back(
      Loss("a landmark without a place", "frame.landmarks[0].place", "not set",
           [](v1::EvaluateLossRequest* request) { request->mutable_frame()->add_landmarks(); }));
  requests->push_back(
      Loss("an empty mask", "frame.masks[0].png_bytes", "0", [](v1::EvaluateLossRequest* request) {
        request->mutable_frame()->set_data("x");
        request->mutable_frame()->add_masks();
      }));
}

// The end of a call that sends `chunks` as one large request.
template <typename Chunk>
Chunk ChunkOf(uint64_t total_bytes, const std::string& data) {
  Chunk chunk;
  chunk.set_total_bytes(total_bytes);
  chunk.set_data(data);
  return chunk;
}

absl::Status CreateFrom(const Target& target, const std::vector<v1::CreateSessionChunk>& chunks) {
  grpc::ClientContext context;
  v1::Session session;
  const auto writer = target.stub->CreateSessionFromStream(&context, &session);
  for (const v1::CreateSessionChunk& chunk : chunks) writer->Write(chunk);
  writer->WritesDone();
  return client::FromGrpc(writer->Finish(), context);
}

absl::Status EvaluateFrom(const Target& target, const std::vector<v1::DataChunk>& chunks) {
  grpc::ClientContext context;
  const auto stream = target.stub->EvaluateLoss(&context);
  for (const v1::DataChunk& chunk : chunks) stream->Write(chunk);
  stream->WritesDone();
  v1::DataChunk ignored;
  while (stream->Read(&ignored)) {
  }
  return client::FromGrpc(stream->Finish(), context);
}

struct Piece {
  uint64_t total_bytes;
  std::string data;
};

void AddPieces(const std::string& name, const std::string& field, const std::string& value,
               const std::vector<Piece>& pieces, std::vector<MalformedRequest>* requests) {
  requests->push_back(
      Query("CreateSessionFromStream: " + name, field, value, [pieces](const Target& target) {
        std::vector<v1::CreateSessionChunk> chunks;
        for (const Piece& piece : pieces) {
          chunks.push_back(ChunkOf<v1::CreateSessionChunk>(piece.total_bytes, piece.data));
        }
        return CreateFrom(target, chunks);
      }));
  requests->push_back(Query("EvaluateLoss: " + name, field, value, [pieces](const Target& target) {
    std::vector<v1::DataChunk> chunks;
    for (const Piece& piece : pieces) {
      chunks.push_back(ChunkOf<v1::DataChunk>(piece.total_bytes, piece.data));
    }
    return EvaluateFrom(target, chunks);
  }));
}

void AddBlobs(std::vector<MalformedRequest>* requests) {
  constexpr size_t kMiB = 1 << 20;
  AddPieces("no chunk", "data", "0 bytes in all", {}, requests);
  AddPieces("an empty chunk", "data", "0 bytes long", {{10, ""}}, requests);
  AddPieces("an empty whole", "data", "0 bytes long", {{0, ""}}, requests);
  AddPieces("bytes missing", "data", "9 bytes in all", {{10, "012345678"}}, requests);
  AddPieces("bytes too many", "data", "11 bytes long", {{10, "0123456789A"}}, requests);
  AddPieces("a chunk above 1 MiB", "data", "1048577 bytes long",
            {{2 * kMiB, std::string(kMiB + 1, 'x')}}, requests);
  AddPieces("two totals", "total_bytes", "11", {{10, "01234"}, {11, "56789"}}, requests);
  const size_t before = requests->size();
  AddPieces("a huge total", "total_bytes", absl::StrCat(uint64_t{1} << 40),
            {{uint64_t{1} << 40, "x"}}, requests);
  AddPieces("the largest total", "total_bytes", absl::StrCat(std::numeric_limits<uint64_t>::max()),
            {{std::numeric_limits<uint64_t>::max(), "x"}}, requests);
  for (size_t k = before; k < requests->size(); ++k) {
    (*requests)[k].code = absl::StatusCode::kResourceExhausted;
    (*requests)[k].reason = "LIMIT_EXCEEDED";
  }
  requests->push_back(Query("CreateSessionFromStream: no message", "data",
                            "not a CreateSessionRequest", [](const Target& target) {
                              return CreateFrom(
                                  target, {ChunkOf<v1::CreateSessionChunk>(3, "\xff\xff\xff")});
                            }));
  requests->push_back(Query(
      "EvaluateLoss: no message", "data", "not an EvaluateLossRequest", [](const Target& target) {
        return EvaluateFrom(target, {ChunkOf<v1::DataChunk>(3, "\xff\xff\xff")});
      }));
}

}  // namespace

std::vector<MalformedRequest> MalformedQueries() {
  std::vector<MalformedRequest> requests;
  AddSessions(&requests);
  AddSurfaces(&requests);
  AddLosses(&requests);
  AddBlobs(&requests);
  return requests;
}

}  // namespace cagefit::server::testing
