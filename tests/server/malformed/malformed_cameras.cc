#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "client/camera_to_proto.h"
#include "client/mesh_from_proto.h"
#include "tests/server/malformed/malformed_request.h"
#include "tests/support/frames.h"
#include "tests/support/masks.h"

namespace cagefit::server::testing {
namespace {

using SpoilFn = std::function<void(v1::Camera*)>;

// A session of a good camera, and of one that `spoil` has made malformed.
MalformedRequest SecondCamera(const std::string& field, const std::string& value,
                              const SpoilFn& spoil) {
  MalformedRequest request;
  request.name = absl::StrCat("camera with ", field, " = ", value);
  request.send = [spoil](const Target& target) {
    v1::CreateSessionRequest create;
    *create.mutable_control_mesh() = client::ToProto(cagefit::testing::FrameCage(0));
    for (const char* name : {"left", "right"}) {
      *create.mutable_options()->add_cameras() =
          client::ToProto(cagefit::testing::SmallCamera(name));
    }
    spoil(create.mutable_options()->mutable_cameras(1));
    return target.client->CreateSession(create).status();
  };
  request.reason = "INVALID_FIELD";
  request.field = "options.cameras[1]." + field;
  request.value = value;
  return request;
}

void AddNames(std::vector<MalformedRequest>* requests) {
  requests->push_back(
      SecondCamera("name", "0 bytes long", [](v1::Camera* camera) { camera->clear_name(); }));
  requests->push_back(SecondCamera("name", "201 bytes long", [](v1::Camera* camera) {
    camera->set_name(std::string(201, 'x'));
  }));
  requests->push_back(
      SecondCamera("name", "\"left\"", [](v1::Camera* camera) { camera->set_name("left"); }));
}

void AddSizes(std::vector<MalformedRequest>* requests) {
  for (const uint32_t size : {0u, 16'385u, 0xFFFFFFFFu}) {
    const std::string value = absl::StrCat(std::min(size, 0x7FFFFFFFu));
    requests->push_back(
        SecondCamera("width", value, [size](v1::Camera* camera) { camera->set_width(size); }));
    requests->push_back(
        SecondCamera("height", value, [size](v1::Camera* camera) { camera->set_height(size); }));
  }
}

void AddNumbers(std::vector<MalformedRequest>* requests) {
  using SetFn = void (v1::Camera::*)(double);
  const auto add = [&](const char* field, SetFn set, double value) {
    requests->push_back(SecondCamera(field, absl::StrCat(value),
                                     [set, value](v1::Camera* camera) { (camera->*set)(value); }));
  };
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  for (const double value : {0.0, -1.0, nan, infinity}) {
    add("fx", &v1::Camera::set_fx, value);
    add("fy", &v1::Camera::set_fy, value);
  }
  for (const double value : {nan, -infinity}) {
    add("cx", &v1::Camera::set_cx, value);
    add("cy", &v1::Camera::set_cy, value);
    add("k1", &v1::Camera::set_k1, value);
    add("k2", &v1::Camera::set_k2, value);
    add("p1", &v1::Camera::set_p1, value);
    add("p2", &v1::Camera::set_p2, value);
    add("k3", &v1::Camera::set_k3, value);
  }
}

void AddPoses(std::vector<MalformedRequest>* requests) {
  requests->push_back(SecondCamera("rotation", "8 values long", [](v1::Camera* camera) {
    camera->mutable_rotation()->RemoveLast();
  }));
  requests->push_back(SecondCamera("rotation", "0 values long",
                                   [](v1::Camera* camera) { camera->clear_rotation(); }));
  requests->push_back(SecondCamera("translation", "4 values long",
                                   [](v1::Camera* camera) { camera->add_translation(0); }));
  requests->push_back(SecondCamera("translation", "not finite", [](v1::Camera* camera) {
    camera->set_translation(1, std::nan(""));
  }));
  const auto rotation = [&](const std::string& value, int k, double number) {
    requests->push_back(SecondCamera(
        "rotation", value, [k, number](v1::Camera* camera) { camera->set_rotation(k, number); }));
  };
  rotation("no rotation: |R R^T - I| is 3, determinant 2", 0, 2);
  rotation("no rotation: |R R^T - I| is 0, determinant -1", 0, -1);
  rotation("no rotation: |R R^T - I| is nan, determinant nan", 4, std::nan(""));
}

MalformedRequest ManyCameras() {
  MalformedRequest request;
  request.name = "65 cameras";
  request.send = [](const Target& target) {
    v1::CreateSessionRequest create;
    *create.mutable_control_mesh() = client::ToProto(cagefit::testing::FrameCage(0));
    for (int k = 0; k < 65; ++k) {
      *create.mutable_options()->add_cameras() =
          client::ToProto(cagefit::testing::SmallCamera(absl::StrCat(k)));
    }
    return target.client->CreateSession(create).status();
  };
  request.reason = "INVALID_FIELD";
  request.field = "options.cameras";
  request.value = "65 long";
  return request;
}

MalformedRequest LargeCameras() {
  MalformedRequest request = SecondCamera("width", "16384", [](v1::Camera* camera) {
    camera->set_width(16'384);
    camera->set_height(16'384);
  });
  request.name = "cameras of too many pixels together";
  request.code = absl::StatusCode::kResourceExhausted;
  request.reason = "LIMIT_EXCEEDED";
  request.field = "pixels of all cameras";
  request.value = absl::StrCat(16'384 * 16'384 + 12);
  return request;
}

}  // namespace

std::vector<MalformedRequest> MalformedCameras() {
  std::vector<MalformedRequest> requests = {ManyCameras(), LargeCameras()};
  AddNames(&requests);
  AddSizes(&requests);
  AddNumbers(&requests);
  AddPoses(&requests);
  return requests;
}

}  // namespace cagefit::server::testing
