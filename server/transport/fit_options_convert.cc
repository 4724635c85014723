#include "server/transport/fit_options_convert.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <type_traits>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

// An option and the field of v1::FitOptions, or v1::ImageOptions, that stands for it.
struct Row {
  const char* field;
  std::variant<double*, std::optional<double>*, int*, uint64_t*, bool*, Field*, Sampling*, Kernel*,
               RestMesh*, Solver*, Views*, SilhouetteMode*>
      option;
};

std::vector<Row> Rows(FitOptions* o) {
  return {{"remove_outliers", &o->target.remove_outliers},
          {"repair_normals", &o->target.repair_normals},
          {"distance_weight", &o->distance.weight},
          {"field", &o->distance.field},
          {"sampling", &o->distance.sampling},
          {"samples_per_triangle", &o->distance.samples_per_triangle},
          {"radius", &o->distance.radius},
          {"radius_share", &o->distance.radius_share},
          {"radius_factor", &o->distance.radius_factor},
          {"far_radius", &o->distance.far_radius},
          {"first_radius", &o->distance.first_radius},
          {"kernel", &o->distance.kernel},
          {"kernel_scale", &o->distance.kernel_scale},
          {"coverage_weight", &o->coverage.weight},
          {"coverage_points_per_vertex", &o->coverage.points_per_vertex},
          {"landmark_weight", &o->landmarks.weight},
          {"boundary_weight", &o->boundary.weight},
          {"arap_weight", &o->arap.weight},
          {"rest_mesh", &o->arap.rest},
          {"solver", &o->solver.solver},
          {"max_iterations", &o->solver.max_iterations},
          {"relative_decrease", &o->solver.relative_decrease},
          {"first_stiffness", &o->solver.first_stiffness},
          {"learning_rate", &o->solver.learning_rate}};
}

std::vector<Row> Rows(ImageOptions* o) {
  return {{"views", &o->views},
          {"weight", &o->weight},
          {"mode", &o->mode},
          {"size", &o->size},
          {"view_count", &o->view_count},
          {"views_per_iteration", &o->views_per_iteration},
          {"sigma", &o->sigma},
          {"blur_radius", &o->blur_radius},
          {"faces_per_pixel", &o->faces_per_pixel},
          {"depth_weight", &o->depth_weight},
          {"normal_weight", &o->normal_weight},
          {"seed", &o->seed},
          {"calibration_error", &o->calibration_error}};
}

// On the wire an enumerator has core's number plus one: 0 is "not set".
template <typename Enum>
constexpr int OnTheWire(Enum value) {
  return static_cast<int>(value) + 1;
}
static_assert(OnTheWire(Field::kImls) == v1::FIELD_IMLS);
static_assert(OnTheWire(Field::kRimls) == v1::FIELD_RIMLS);
static_assert(OnTheWire(Sampling::kControlVertices) == v1::SAMPLING_CONTROL_VERTICES);
static_assert(OnTheWire(Sampling::kRefinedVertices) == v1::SAMPLING_REFINED_VERTICES);
static_assert(OnTheWire(Sampling::kArea) == v1::SAMPLING_AREA);
static_assert(OnTheWire(Kernel::kIdentity) == v1::KERNEL_IDENTITY);
static_assert(OnTheWire(Kernel::kHuber) == v1::KERNEL_HUBER);
static_assert(OnTheWire(Kernel::kGemanMcClure) == v1::KERNEL_GEMAN_MCCLURE);
static_assert(OnTheWire(Kernel::kTukey) == v1::KERNEL_TUKEY);
static_assert(OnTheWire(RestMesh::kTemplate) == v1::REST_MESH_TEMPLATE);
static_assert(OnTheWire(RestMesh::kPreviousFrame) == v1::REST_MESH_PREVIOUS_FRAME);
static_assert(OnTheWire(Solver::kGaussNewton) == v1::SOLVER_GAUSS_NEWTON);
static_assert(OnTheWire(Solver::kCeres) == v1::SOLVER_CERES);
static_assert(OnTheWire(Solver::kAdam) == v1::SOLVER_ADAM);
static_assert(OnTheWire(Views::kNone) == v1::VIEWS_NONE);
static_assert(OnTheWire(Views::kCameras) == v1::VIEWS_CAMERAS);
static_assert(OnTheWire(Views::kSphere) == v1::VIEWS_SPHERE);
static_assert(OnTheWire(Views::kTutorial) == v1::VIEWS_TUTORIAL);
static_assert(OnTheWire(SilhouetteMode::kOutline) == v1::SILHOUETTE_MODE_OUTLINE);
static_assert(OnTheWire(SilhouetteMode::kPytorch3d) == v1::SILHOUETTE_MODE_PYTORCH3D);

absl::Status UnknownValue(absl::string_view field, int value) {
  return InvalidField(absl::StrCat("options.fit.", field), absl::StrCat(value),
                      "this server does not know that value");
}

// The field of a row in one message, read or written by the type of the option.
struct FieldOf {
  FieldOf(const char* name, const Message& message)
      : descriptor(message.GetDescriptor()->FindFieldByName(name)),
        reflection(message.GetReflection()) {}

  bool IsSet(const Message& proto) const {
    return descriptor->has_presence() ? reflection->HasField(proto, descriptor)
                                      : reflection->GetEnumValue(proto, descriptor) != 0;
  }

  void Read(const Message& proto, double* option) const {
    *option = reflection->GetDouble(proto, descriptor);
  }
  void Read(const Message& proto, std::optional<double>* option) const {
    *option = reflection->GetDouble(proto, descriptor);
  }
  void Read(const Message& proto, int* option) const {
    *option = ClampToInt(reflection->GetUInt32(proto, descriptor));
  }
  void Read(const Message& proto, uint64_t* option) const {
    *option = reflection->GetUInt64(proto, descriptor);
  }
  void Read(const Message& proto, bool* option) const {
    *option = reflection->GetBool(proto, descriptor);
  }
  template <typename Enum, typename = std::enable_if_t<std::is_enum_v<Enum>>>
  void Read(const Message& proto, Enum* option) const {
    *option = static_cast<Enum>(reflection->GetEnumValue(proto, descriptor) - 1);
  }

  void Write(double option, Message* proto) const {
    reflection->SetDouble(proto, descriptor, option);
  }
  void Write(const std::optional<double>& option, Message* proto) const {
    if (option.has_value()) Write(*option, proto);
  }
  void Write(int option, Message* proto) const {
    reflection->SetUInt32(proto, descriptor, static_cast<uint32_t>(option));
  }
  void Write(uint64_t option, Message* proto) const {
    reflection->SetUInt64(proto, descriptor, option);
  }
  void Write(bool option, Message* proto) const { reflection->SetBool(proto, descriptor, option); }
  template <typename Enum, typename = std::enable_if_t<std::is_enum_v<Enum>>>
  void Write(Enum option, Message* proto) const {
    reflection->SetEnumValue(proto, descriptor, OnTheWire(option));
  }

  const FieldDescriptor* descriptor;
  const google::protobuf::Reflection* reflection;
};

absl::Status ReadRows(const std::vector<Row>& rows, const Message& proto,
                      absl::string_view prefix) {
  for (const Row& row : rows) {
    const FieldOf field(row.field, proto);
    if (!field.IsSet(proto)) continue;
    if (field.descriptor->enum_type() != nullptr) {
      const int value = field.reflection->GetEnumValue(proto, field.descriptor);
      const bool known = field.descriptor->enum_type()->FindValueByNumber(value) != nullptr;
      if (!known) return UnknownValue(absl::StrCat(prefix, row.field), value);
    }
    std::visit([&](auto* option) { field.Read(proto, option); }, row.option);
  }
  return absl::OkStatus();
}

void WriteRows(const std::vector<Row>& rows, Message* proto) {
  for (const Row& row : rows) {
    const FieldOf field(row.field, *proto);
    std::visit([&](const auto* option) { field.Write(*option, proto); }, row.option);
  }
}

}  // namespace

int32_t ClampToInt(uint32_t value) {
  return static_cast<int32_t>(std::min<uint32_t>(value, std::numeric_limits<int32_t>::max()));
}

absl::StatusOr<FitOptions> FromProto(const v1::FitOptions& proto) {
  if (!v1::Preset_IsValid(proto.preset())) return UnknownValue("preset", proto.preset());
  FitOptions options = proto.preset() == v1::PRESET_PAPER ? FitOptions::Paper() : FitOptions();
  RETURN_IF_ERROR(ReadRows(Rows(&options), proto, ""));
  RETURN_IF_ERROR(ReadRows(Rows(&options.image), proto.image(), "image."));
  return options;
}

v1::FitOptions ToProto(const FitOptions& options) {
  v1::FitOptions proto;
  FitOptions copy = options;  // rows point to what may be changed
  WriteRows(Rows(&copy), &proto);
  WriteRows(Rows(&copy.image), proto.mutable_image());
  return proto;
}

}  // namespace cagefit::server
