#include <cmath>
#include <cstring>
#include <limits>

#include "absl/strings/str_cat.h"
#include "client/camera_to_proto.h"
#include "client/mesh_from_proto.h"
#include "tests/core/codec/draco_samples.h"
#include "tests/server/malformed/malformed_request.h"
#include "tests/support/frames.h"
#include "tests/support/masks.h"

namespace cagefit::server::testing {
namespace {

using cagefit::testing::MaskPng;
using cagefit::testing::MovingCloud;
using HeaderFn = std::function<void(v1::FrameHeader*)>;

constexpr int64_t kPoints = 100;

std::string GoodBytes() { return cagefit::testing::FrameBytes(MovingCloud(0, kPoints)); }

// The first frame of a session of its own with cameras "left" and "right", so that a rejected one
// takes no number from another.
absl::Status SendFrame(const Target& target, const std::string& bytes, const HeaderFn& change) {
  v1::CreateSessionRequest create;
  *create.mutable_control_mesh() = client::ToProto(cagefit::testing::FrameCage(0));
  for (const char* name : {"left", "right"}) {
    *create.mutable_options()->add_cameras() = client::ToProto(cagefit::testing::SmallCamera(name));
  }
  const auto session = target.client->CreateSession(create);
  if (!session.ok()) return session.status();
  v1::FitFramesRequest header = Header(0, bytes.size());
  change(header.mutable_header());
  std::vector<v1::FitFramesRequest> messages = {Open(session->session_id()), header};
  if (!bytes.empty()) messages.push_back(Chunk(bytes));
  return EndOfStream(target, messages);
}

MalformedRequest Frame(const std::string& name, const std::string& bytes, const HeaderFn& change) {
  MalformedRequest request;
  request.name = name;
  request.send = [bytes, change](const Target& target) { return SendFrame(target, bytes, change); };
  return request;
}

MalformedRequest Bytes(const std::string& name, const std::string& bytes,
                       const std::string& message) {
  MalformedRequest request = Frame(name, bytes, [](v1::FrameHeader*) {});
  request.reason = "BAD_FRAME";
  request.field = "chunk.data";
  request.message = message;
  return request;
}

MalformedRequest Limit(MalformedRequest request) {
  request.code = absl::StatusCode::kResourceExhausted;
  request.reason = "LIMIT_EXCEEDED";
  return request;
}

// `good` with one byte replaced.
std::string WithByte(std::string good, size_t at, char byte) {
  good[at] = byte;
  return good;
}

void AddHeaders(std::vector<MalformedRequest>* requests) {
  const std::string good = GoodBytes();
  requests->push_back(Bytes("no bytes", "", "not Draco"));
  requests->push_back(Bytes("one byte", "D", "not Draco"));
  requests->push_back(Bytes("a PNG", MaskPng(4, 3), "not Draco"));
  requests->push_back(Bytes("text", "ply\nformat ascii 1.0\n", "not Draco"));
  requests->push_back(Bytes("zeros", std::string(100, '\0'), "not Draco"));
  requests->push_back(Bytes("magic alone", "DRACO", "Draco header cut off after 5 bytes"));
  requests->push_back(Bytes("a header cut off", good.substr(0, 10), "cut off after 10 bytes"));
  requests->push_back(Bytes("a header alone", good.substr(0, 11), "Draco"));
  requests->push_back(Bytes("bitstream 9.3", WithByte(good, 5, 9), "9.3"));
  requests->push_back(Bytes("bitstream 2.9", WithByte(good, 6, 9), "2.9"));
  requests->push_back(Bytes("bitstream 2.2 of a kd-tree", WithByte(good, 6, 2), "2.2"));
  requests->push_back(Bytes("geometry 2", WithByte(good, 7, 2), "geometry type 2"));
  requests->push_back(Bytes("geometry 255", WithByte(good, 7, '\xff'), "geometry type 255"));
  requests->push_back(Bytes("method 2", WithByte(good, 8, 2), "method 2"));
  requests->push_back(Bytes("metadata", WithByte(good, 10, '\x80'), "metadata"));
}

// At each place of a small cloud or mesh.
void AddTruncations(std::vector<MalformedRequest>* requests) {
  for (const cagefit::testing::NamedBytes& sample : cagefit::testing::AllDracoSamples()) {
    if (std::strstr(sample.name, "metadata") != nullptr) continue;
    for (const size_t eighths : {3, 5, 7}) {
      requests->push_back(Bytes(absl::StrCat(sample.name, ", the first ", eighths, " eighths"),
                                sample.bytes.substr(0, sample.bytes.size() * eighths / 8),
                                "Draco"));
    }
  }
}

void AddPoints(std::vector<MalformedRequest>* requests) {
  requests->push_back(Bytes("15 points", cagefit::testing::FrameBytes(MovingCloud(0, 15)),
                            "points: 15; a target needs at least 16"));
  for (const float value : {std::nanf(""), std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity()}) {
    PointCloud cloud = MovingCloud(0, kPoints);
    cloud.points(1, 7) = value;
    requests->push_back(Bytes(absl::StrCat("a coordinate of ", value),
                              cagefit::testing::SequentialCloudBytes(cloud.points, cloud.normals),
                              "not finite"));
  }
  MalformedRequest many = Limit(Bytes(
      "too many points", cagefit::testing::FrameBytes(MovingCloud(0, kMaxPoints + 1)), "2001"));
  requests->push_back(many);
  for (const uint64_t count : {uint64_t{99}, uint64_t{101}, uint64_t{kMaxPoints}}) {
    MalformedRequest wrong =
        Frame(absl::StrCat("point_count ", count, " with 100 points"), GoodBytes(),
              [count](v1::FrameHeader* header) { header->set_point_count(count); });
    wrong.reason = "INVALID_FIELD";
    wrong.field = "header.point_count";
    wrong.value = absl::StrCat(count);
    requests->push_back(wrong);
  }
  for (const uint64_t count : {uint64_t{kMaxPoints + 1}, std::numeric_limits<uint64_t>::max()}) {
    MalformedRequest claim =
        Limit(Frame(absl::StrCat("point_count ", count), GoodBytes(),
                    [count](v1::FrameHeader* header) { header->set_point_count(count); }));
    claim.field = "header.point_count";
    claim.value = absl::StrCat(count);
    requests->push_back(claim);
  }
}

struct SentMask {
  std::string camera;
  std::string png;
};

// A good cloud with masks, whose header `change` may change.
MalformedRequest Masks(
    const std::string& name, const std::vector<SentMask>& masks, const std::string& reason,
    const std::string& field, const std::string& value,
    const HeaderFn& change = [](v1::FrameHeader*) {}) {
  std::string bytes = GoodBytes();
  for (const SentMask& mask : masks) bytes += mask.png;
  MalformedRequest request = Frame(name, bytes, [masks, change](v1::FrameHeader* header) {
    for (const SentMask& mask : masks) {
      v1::Mask* proto = header->add_masks();
      proto->set_camera(mask.camera);
      proto->set_png_bytes(mask.png.size());
    }
    change(header);
  });
  request.reason = reason;
  request.field = field;
  request.value = value;
  return request;
}

void AddMasks(std::vector<MalformedRequest>* requests) {
  const std::string png = MaskPng(4, 3);
  requests->push_back(Masks("a mask of an unknown camera", {{"left", png}, {"top", png}},
                            "INVALID_FIELD", "header.masks[1].camera", "\"top\""));
  requests->push_back(
      Masks("a mask of no camera", {{"", png}}, "INVALID_FIELD", "header.masks[0].camera", "\"\""));
  requests->push_back(Masks("two masks of a camera", {{"left", png}, {"left", png}},
                            "INVALID_FIELD", "header.masks[1].camera", "\"left\""));
  requests->push_back(
      Masks("an empty mask", {{"left", ""}}, "INVALID_FIELD", "header.masks[0].png_bytes", "0"));
  for (const uint64_t size : {uint64_t{1'000'000}, std::numeric_limits<uint64_t>::max()}) {
    requests->push_back(
        Masks(absl::StrCat("a mask of ", size, " bytes"), {{"left", png}}, "INVALID_FIELD",
              "header.masks[0].png_bytes", absl::StrCat(size),
              [size](v1::FrameHeader* header) { header->mutable_masks(0)->set_png_bytes(size); }));
  }
  requests->push_back(Masks("a mask of another size", {{"left", MaskPng(3, 3)}}, "INVALID_FIELD",
                            "header.masks[0]", "3 x 3 pixels"));
  requests->push_back(Masks("a mask that is too large", {{"left", MaskPng(400, 300)}}, "BAD_MASK",
                            "header.masks[0]", "left"));
  requests->push_back(Masks("a mask that is text", {{"left", "no picture"}}, "BAD_MASK",
                            "header.masks[0]", "left"));
  requests->push_back(Masks("a mask cut off", {{"left", png.substr(0, png.size() - 20)}},
                            "BAD_MASK", "header.masks[0]", "left"));
}

MalformedRequest WithLandmark(const std::string& field, const std::string& value,
                              const std::function<void(v1::Landmark*)>& spoil) {
  MalformedRequest request = Frame(absl::StrCat("a landmark with ", field, " = ", value),
                                   GoodBytes(), [spoil](v1::FrameHeader* header) {
                                     header->add_landmarks()->set_vertex(0);
                                     v1::Landmark* landmark = header->add_landmarks();
                                     landmark->mutable_surface();
                                     spoil(landmark);
                                   });
  request.reason = "INVALID_FIELD";
  request.field = "header.landmarks[1]." + field;
  request.value = value;
  return request;
}

void AddLandmarks(std::vector<MalformedRequest>* requests) {
  requests->push_back(WithLandmark("vertex", "12", [](v1::Landmark* l) { l->set_vertex(12); }));
  requests->push_back(WithLandmark(
      "triangle", "20", [](v1::Landmark* l) { l->mutable_surface()->set_triangle(20); }));
  const auto at = [&](double u, double v) {
    requests->push_back(
        WithLandmark("surface", absl::StrCat("(", u, ", ", v, ")"), [u, v](v1::Landmark* landmark) {
          landmark->mutable_surface()->set_u(u);
          landmark->mutable_surface()->set_v(v);
        }));
  };
  at(-0.001, 0.5);
  at(0.5, -0.001);
  at(0.501, 0.5);
  at(std::nan(""), 0);
  at(std::numeric_limits<double>::infinity(), 0);
  requests->push_back(WithLandmark("position", "not finite",
                                   [](v1::Landmark* landmark) { landmark->set_y(std::nan("")); }));
}

}  // namespace

std::vector<MalformedRequest> MalformedFrames() {
  std::vector<MalformedRequest> requests;
  AddHeaders(&requests);
  AddTruncations(&requests);
  AddPoints(&requests);
  AddMasks(&requests);
  AddLandmarks(&requests);
  return requests;
}

}  // namespace cagefit::server::testing
