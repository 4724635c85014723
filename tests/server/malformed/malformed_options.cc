#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/mesh_from_proto.h"
#include "tests/server/malformed/malformed_request.h"
#include "tests/support/frames.h"

namespace cagefit::server::testing {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

v1::CreateSessionRequest GoodRequest() {
  v1::CreateSessionRequest request;
  *request.mutable_control_mesh() = client::ToProto(cagefit::testing::FrameCage(0));
  return request;
}

// A request that `spoil` has made malformed.
MalformedRequest Create(const std::string& field, const std::string& value,
                        const std::function<void(v1::CreateSessionRequest*)>& spoil,
                        const std::string& message = "") {
  MalformedRequest request;
  request.name = absl::StrCat(field, " = ", value);
  request.send = [spoil](const Target& target) {
    v1::CreateSessionRequest create = GoodRequest();
    spoil(&create);
    return target.client->CreateSession(create).status();
  };
  request.reason = "INVALID_FIELD";
  request.field = field;
  request.value = value;
  request.message = message;
  return request;
}

struct Range {
  const char* field;  // of FitOptions, or with "image." of its ImageOptions
  double least, most;
};

constexpr Range kRanges[] = {
    {"radius", 0, 1e12},
    {"radius_factor", 0.5, 20},
    {"far_radius", 0, 1e12},
    {"arap_weight", 0, 1e6},
    {"max_iterations", 1, 100'000},
    {"relative_decrease", 1e-12, 0.5},
    {"first_stiffness", 1, 1e6},
    {"samples_per_triangle", 1, 100},
    {"radius_share", 0, 1},
    {"first_radius", 1, 64},  // 0 has a meaning of its own
    {"kernel_scale", 0, 1e12},
    {"coverage_weight", 0, 1e6},
    {"coverage_points_per_vertex", 1, 1000},
    {"learning_rate", 1e-8, 1},
    {"distance_weight", 0, 1e6},
    {"landmark_weight", 0, 1e6},
    {"boundary_weight", 0, 1e6},
    {"image.weight", 0, 1e9},
    {"image.size", 64, 2048},
    {"image.view_count", 1, 200},
    {"image.views_per_iteration", 0, 200},
    {"image.sigma", 1e-8, 1},
    {"image.blur_radius", 0, 1},
    {"image.faces_per_pixel", 1, 1000},
    {"image.depth_weight", 0, 1e6},
    {"image.normal_weight", 0, 1e6},
    {"image.calibration_error", 0, 100},
};

constexpr const char* kEnums[] = {"sampling", "rest_mesh", "solver",      "preset",
                                  "field",    "kernel",    "image.views", "image.mode"};

// The message that holds the field `name` of the request's options, and the field.
std::pair<Message*, const FieldDescriptor*> FieldOf(v1::CreateSessionRequest* request,
                                                    const std::string& name) {
  v1::FitOptions* fit = request->mutable_options()->mutable_fit();
  constexpr char kImage[] = "image.";
  const bool of_image = name.rfind(kImage, 0) == 0;
  Message* message = of_image ? static_cast<Message*>(fit->mutable_image()) : fit;
  return {message, message->GetDescriptor()->FindFieldByName(
                       of_image ? name.substr(sizeof(kImage) - 1) : name)};
}

bool IsDouble(const std::string& name) {
  v1::CreateSessionRequest request;
  return FieldOf(&request, name).second->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE;
}

MalformedRequest Option(const std::string& name, double value, const std::string& text) {
  return Create(
      absl::StrCat("options.fit.", name), text,
      [name, value](v1::CreateSessionRequest* request) {
        const auto [message, field] = FieldOf(request, name);
        if (field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
          message->GetReflection()->SetDouble(message, field, value);
        } else {
          message->GetReflection()->SetUInt32(message, field, static_cast<uint32_t>(value));
        }
      },
      absl::StrCat("options.fit.", name, " is ", text, ";"));
}

void AddRanges(std::vector<MalformedRequest>* requests) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const Range& range : kRanges) {
    const auto add = [&](double value, const std::string& text) {
      requests->push_back(Option(range.field, value, text));
    };
    if (!IsDouble(range.field)) {
      if (range.least > 0) add(range.least - 1, absl::StrFormat("%g", range.least - 1));
      add(range.most + 1, absl::StrFormat("%g", range.most + 1));
      continue;
    }
    const double below = range.least == 0 ? -1e-9 : 0.999 * range.least;
    add(below, absl::StrFormat("%g", below));
    add(1.001 * range.most, absl::StrFormat("%g", 1.001 * range.most));
    add(std::nan(""), "nan");
    add(kInfinity, "inf");
    add(-kInfinity, "-inf");
  }
  for (const char* name : {"max_iterations", "image.size"}) {
    requests->push_back(Option(name, 4294967295.0, "2.14748e+09"));
  }
}

void AddEnums(std::vector<MalformedRequest>* requests) {
  for (const std::string name : kEnums) {
    for (const int value : {99, -1}) {
      requests->push_back(Create(absl::StrCat("options.fit.", name), absl::StrCat(value),
                                 [name, value](v1::CreateSessionRequest* request) {
                                   const auto [message, field] = FieldOf(request, name);
                                   message->GetReflection()->SetEnumValue(message, field, value);
                                 }));
    }
  }
}

void AddCombinations(std::vector<MalformedRequest>* requests) {
  requests->push_back(
      Create("options.fit.image.views", "CAMERAS", [](v1::CreateSessionRequest* request) {
        request->mutable_options()->mutable_fit()->mutable_image()->set_views(v1::VIEWS_CAMERAS);
      }));
  requests->push_back(Create("options.fit.solver", "CERES, which does not take images",
                             [](v1::CreateSessionRequest* request) {
                               v1::FitOptions* fit = request->mutable_options()->mutable_fit();
                               fit->mutable_image()->set_views(v1::VIEWS_SPHERE);
                               fit->set_solver(v1::SOLVER_CERES);
                             }));
  requests->push_back(Create("options.fit.image.mode", "PYTORCH3D, which has no Gauss-Newton rows",
                             [](v1::CreateSessionRequest* request) {
                               v1::FitOptions* fit = request->mutable_options()->mutable_fit();
                               fit->mutable_image()->set_views(v1::VIEWS_SPHERE);
                               fit->mutable_image()->set_mode(v1::SILHOUETTE_MODE_PYTORCH3D);
                             }));
}

void AddSessionOptions(std::vector<MalformedRequest>* requests) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double quantum : {9.99e-10, 1.001e-2, -1e-5, std::nan(""), kInfinity, -kInfinity}) {
    requests->push_back(Create(
        "options.quantum", absl::StrCat(quantum),
        [quantum](v1::CreateSessionRequest* r) { r->mutable_options()->set_quantum(quantum); }));
  }
  for (const uint32_t interval : {0u, 100'001u, 4'294'967'295u}) {
    requests->push_back(Create("options.key_interval", absl::StrCat(interval),
                               [interval](v1::CreateSessionRequest* r) {
                                 r->mutable_options()->set_key_interval(interval);
                               }));
  }
  for (const int encoding : {3, -1}) {
    requests->push_back(Create(
        "options.delta_encoding", absl::StrCat(encoding), [encoding](v1::CreateSessionRequest* r) {
          r->mutable_options()->set_delta_encoding(static_cast<v1::DeltaEncoding>(encoding));
        }));
  }
  for (const double tolerance : {9.99e-7, 0.1001, -0.01, std::nan(""), kInfinity, -kInfinity}) {
    requests->push_back(Create("options.tolerance", absl::StrCat(tolerance),
                               [tolerance](v1::CreateSessionRequest* r) {
                                 r->mutable_options()->set_tolerance(tolerance);
                               }));
  }
  for (const uint32_t vertices : {0u, 3u}) {
    requests->push_back(Create("options.max_vertices", absl::StrCat(vertices),
                               [vertices](v1::CreateSessionRequest* r) {
                                 r->mutable_options()->set_tolerance(0.01);
                                 r->mutable_options()->set_max_vertices(vertices);
                               }));
  }
}

void AddTemplates(std::vector<MalformedRequest>* requests) {
  requests->push_back(Create("name", "201 bytes long", [](v1::CreateSessionRequest* request) {
    request->set_name(std::string(201, 'x'));
  }));
  requests->push_back(Create("template", "not set", [](v1::CreateSessionRequest* request) {
    request->clear_template();
  }));
  for (const uint32_t vertices : {0u, 3u}) {
    requests->push_back(Create("make_template.vertices", absl::StrCat(vertices),
                               [vertices](v1::CreateSessionRequest* r) {
                                 r->mutable_make_template()->set_vertices(vertices);
                               }));
  }
  for (const double angle :
       {-0.001, 180.001, std::nan(""), std::numeric_limits<double>::infinity()}) {
    requests->push_back(Create("make_template.crease_angle_degrees", absl::StrCat(angle),
                               [angle](v1::CreateSessionRequest* request) {
                                 request->mutable_make_template()->set_vertices(100);
                                 request->mutable_make_template()->set_crease_angle_degrees(angle);
                               }));
  }
  MalformedRequest many =
      Create("control vertices", absl::StrCat(kMaxControlVertices + 1),
             [](v1::CreateSessionRequest* request) {
               request->mutable_make_template()->set_vertices(kMaxControlVertices + 1);
             });
  many.code = absl::StatusCode::kResourceExhausted;
  many.reason = "LIMIT_EXCEEDED";
  requests->push_back(many);
}

}  // namespace

std::vector<MalformedRequest> MalformedOptions() {
  std::vector<MalformedRequest> requests;
  AddRanges(&requests);
  AddEnums(&requests);
  AddCombinations(&requests);
  AddSessionOptions(&requests);
  AddTemplates(&requests);
  return requests;
}

}  // namespace cagefit::server::testing
