#include "server/transport/fit_options_convert.h"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

using ::google::protobuf::FieldDescriptor;
using ::google::protobuf::util::MessageDifferencer;
using ::testing::AllOf;
using ::testing::HasSubstr;

// Of the options and of those of the image loss within them.
std::vector<const FieldDescriptor*> Fields() {
  std::vector<const FieldDescriptor*> fields;
  for (const auto* descriptor : {v1::FitOptions::descriptor(), v1::ImageOptions::descriptor()}) {
    for (int k = 0; k < descriptor->field_count(); ++k) {
      if (descriptor->field(k)->message_type() == nullptr) fields.push_back(descriptor->field(k));
    }
  }
  return fields;
}

bool IsOfImages(const FieldDescriptor* field) {
  return field->containing_type() == v1::ImageOptions::descriptor();
}

// The message that holds a field.
google::protobuf::Message* Holder(v1::FitOptions* proto, const FieldDescriptor* field) {
  if (IsOfImages(field)) return proto->mutable_image();
  return proto;
}

// As errors of the options' ranges call it.
std::string NameOf(const FieldDescriptor* field) {
  return (IsOfImages(field) ? "image." : "") + field->name();
}

// All options away from their defaults, as the wire has them and as core does.
v1::FitOptions UnusualProto() {
  v1::FitOptions fit;
  fit.set_sampling(v1::SAMPLING_AREA);
  fit.set_radius(0.25);
  fit.set_radius_factor(3);
  fit.set_far_radius(0.75);
  fit.set_arap_weight(0.125);
  fit.set_rest_mesh(v1::REST_MESH_PREVIOUS_FRAME);
  fit.set_solver(v1::SOLVER_ADAM);
  fit.set_max_iterations(17);
  fit.set_relative_decrease(0.5);
  fit.set_first_stiffness(2);
  fit.set_field(v1::FIELD_RIMLS);
  fit.set_samples_per_triangle(9);
  fit.set_radius_share(0.0625);
  fit.set_first_radius(8);
  fit.set_kernel(v1::KERNEL_TUKEY);
  fit.set_kernel_scale(0.375);
  fit.set_coverage_weight(0.875);
  fit.set_coverage_points_per_vertex(33);
  fit.set_landmark_weight(2.25);
  fit.set_boundary_weight(0.375);
  fit.set_learning_rate(0.015625);
  fit.set_remove_outliers(false);
  fit.set_repair_normals(false);
  fit.set_distance_weight(0.625);
  v1::ImageOptions& image = *fit.mutable_image();
  image.set_views(v1::VIEWS_TUTORIAL);
  image.set_weight(0.03125);
  image.set_mode(v1::SILHOUETTE_MODE_PYTORCH3D);
  image.set_size(512);
  image.set_view_count(7);
  image.set_views_per_iteration(3);
  image.set_sigma(0.0009765625);
  image.set_blur_radius(0.001953125);
  image.set_faces_per_pixel(44);
  image.set_depth_weight(1.5);
  image.set_normal_weight(2.5);
  image.set_seed(uint64_t{1} << 40);
  image.set_calibration_error(1.25);
  return fit;
}

FitOptions Unusual() {
  FitOptions o;
  o.target = {false, false};
  o.distance = {0.625,          Field::kRimls, Sampling::kArea, 9, 0.25, 0.0625, 3, 0.75, 8,
                Kernel::kTukey, 0.375};
  o.coverage = {0.875, 33};
  o.landmarks.weight = 2.25;
  o.boundary.weight = 0.375;
  o.arap = {0.125, RestMesh::kPreviousFrame};
  o.image = {Views::kTutorial,
             0.03125,
             1.5,
             2.5,
             SilhouetteMode::kPytorch3d,
             512,
             7,
             3,
             0.0009765625,
             0.001953125,
             44,
             uint64_t{1} << 40,
             1.25};
  o.solver = {Solver::kAdam, 17, 0.5, 2, 0.015625};
  return o;
}

void ExpectSame(const FitOptions& a, const FitOptions& b) {
  EXPECT_EQ(a.target.remove_outliers, b.target.remove_outliers);
  EXPECT_EQ(a.target.repair_normals, b.target.repair_normals);
  EXPECT_EQ(a.distance.weight, b.distance.weight);
  EXPECT_EQ(a.distance.field, b.distance.field);
  EXPECT_EQ(a.distance.sampling, b.distance.sampling);
  EXPECT_EQ(a.distance.samples_per_triangle, b.distance.samples_per_triangle);
  EXPECT_EQ(a.distance.radius, b.distance.radius);
  EXPECT_EQ(a.distance.radius_share, b.distance.radius_share);
  EXPECT_EQ(a.distance.radius_factor, b.distance.radius_factor);
  EXPECT_EQ(a.distance.far_radius, b.distance.far_radius);
  EXPECT_EQ(a.distance.first_radius, b.distance.first_radius);
  EXPECT_EQ(a.distance.kernel, b.distance.kernel);
  EXPECT_EQ(a.distance.kernel_scale, b.distance.kernel_scale);
  EXPECT_EQ(a.coverage.weight, b.coverage.weight);
  EXPECT_EQ(a.coverage.points_per_vertex, b.coverage.points_per_vertex);
  EXPECT_EQ(a.landmarks.weight, b.landmarks.weight);
  EXPECT_EQ(a.boundary.weight, b.boundary.weight);
  EXPECT_EQ(a.arap.weight, b.arap.weight);
  EXPECT_EQ(a.arap.rest, b.arap.rest);
  EXPECT_EQ(a.solver.solver, b.solver.solver);
  EXPECT_EQ(a.solver.max_iterations, b.solver.max_iterations);
  EXPECT_EQ(a.solver.relative_decrease, b.solver.relative_decrease);
  EXPECT_EQ(a.solver.first_stiffness, b.solver.first_stiffness);
  EXPECT_EQ(a.solver.learning_rate, b.solver.learning_rate);
  EXPECT_EQ(a.image.views, b.image.views);
  EXPECT_EQ(a.image.weight, b.image.weight);
  EXPECT_EQ(a.image.mode, b.image.mode);
  EXPECT_EQ(a.image.size, b.image.size);
  EXPECT_EQ(a.image.view_count, b.image.view_count);
  EXPECT_EQ(a.image.views_per_iteration, b.image.views_per_iteration);
  EXPECT_EQ(a.image.sigma, b.image.sigma);
  EXPECT_EQ(a.image.blur_radius, b.image.blur_radius);
  EXPECT_EQ(a.image.faces_per_pixel, b.image.faces_per_pixel);
  EXPECT_EQ(a.image.depth_weight, b.image.depth_weight);
  EXPECT_EQ(a.image.normal_weight, b.image.normal_weight);
  EXPECT_EQ(a.image.seed, b.image.seed);
  EXPECT_EQ(a.image.calibration_error, b.image.calibration_error);
}

TEST(FitOptionsConvertTest, EveryOptionArrivesAtItsPlace) {
  const auto options = FromProto(UnusualProto());
  ASSERT_TRUE(options.ok()) << options.status();
  ExpectSame(*options, Unusual());
  EXPECT_EQ(options->Validate(), absl::OkStatus());
}

TEST(FitOptionsConvertTest, EveryOptionComesBack) {
  const v1::FitOptions back = ToProto(Unusual());
  EXPECT_TRUE(MessageDifferencer::Equals(back, UnusualProto())) << back.DebugString();
}

TEST(FitOptionsConvertTest, TheOptionsInForceNameEveryFieldButThePreset) {
  FitOptions options = FitOptions::Paper();
  options.image.weight = 1;
  v1::FitOptions in_force = ToProto(options);
  for (const FieldDescriptor* field : Fields()) {
    const google::protobuf::Message& holder = *Holder(&in_force, field);
    EXPECT_EQ(holder.GetReflection()->HasField(holder, field), field->name() != "preset")
        << field->name();
  }
  EXPECT_FALSE(ToProto(FitOptions()).has_arap_weight()) << "it stays automatic";
  EXPECT_FALSE(ToProto(FitOptions()).image().has_weight()) << "it stays automatic";
}

TEST(FitOptionsConvertTest, WhatIsNotSetTakesThePresetsValue) {
  v1::FitOptions proto;
  ExpectSame(*FromProto(proto), FitOptions());
  proto.set_preset(v1::PRESET_DEFAULT);
  ExpectSame(*FromProto(proto), FitOptions());
  proto.set_preset(v1::PRESET_PAPER);
  ExpectSame(*FromProto(proto), FitOptions::Paper());
}

TEST(FitOptionsConvertTest, WhatIsSetCountsMoreThanThePreset) {
  v1::FitOptions proto = UnusualProto();
  proto.set_preset(v1::PRESET_PAPER);
  ExpectSame(*FromProto(proto), Unusual());
  proto = v1::FitOptions();
  proto.set_preset(v1::PRESET_PAPER);
  proto.set_max_iterations(20);
  proto.set_remove_outliers(true);
  FitOptions expected = FitOptions::Paper();
  expected.solver.max_iterations = 20;
  expected.target.remove_outliers = true;
  ExpectSame(*FromProto(proto), expected);
}

TEST(FitOptionsConvertTest, TheOptionsInForceGiveThemselvesWhenTheyAreSent) {
  for (const FitOptions& options : {FitOptions(), FitOptions::Paper(), Unusual()}) {
    ExpectSame(*FromProto(ToProto(options)), options);
  }
}

TEST(FitOptionsConvertTest, EveryValueOfEveryEnumIsKnown) {
  for (const FieldDescriptor* field : Fields()) {
    if (field->enum_type() == nullptr || field->name() == "preset") continue;
    for (int k = 1; k < field->enum_type()->value_count(); ++k) {
      v1::FitOptions proto;
      google::protobuf::Message* holder = Holder(&proto, field);
      holder->GetReflection()->SetEnum(holder, field, field->enum_type()->value(k));
      const auto options = FromProto(proto);
      ASSERT_TRUE(options.ok()) << options.status();
      v1::FitOptions back = ToProto(*options);
      holder = Holder(&back, field);
      EXPECT_EQ(holder->GetReflection()->GetEnumValue(*holder, field), k) << field->name();
    }
  }
}

TEST(FitOptionsConvertTest, RefusesEnumValuesThatItDoesNotKnow) {
  for (const FieldDescriptor* field : Fields()) {
    if (field->enum_type() == nullptr) continue;
    for (const int value : {99, -1}) {
      v1::FitOptions proto;
      google::protobuf::Message* holder = Holder(&proto, field);
      holder->GetReflection()->SetEnumValue(holder, field, value);
      const absl::Status status = FromProto(proto).status();
      EXPECT_TRUE(absl::IsInvalidArgument(status)) << field->name() << ": " << status;
      ASSERT_TRUE(DetailOf(status).has_value());
      EXPECT_EQ(DetailOf(status)->field, "options.fit." + NameOf(field));
      EXPECT_EQ(DetailOf(status)->value, std::to_string(value));
    }
  }
}

// A value out of range, the field that has to be named and how the value has to be quoted.
struct BadValue {
  const char* field;
  double value;
  const char* quoted;
};

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

constexpr BadValue kBadValues[] = {{"radius", -1, "-1"},
                                   {"radius", 1e13, "1e+13"},
                                   {"radius", kNan, "nan"},
                                   {"radius_factor", 0.25, "0.25"},
                                   {"radius_factor", 21, "21"},
                                   {"far_radius", -0.5, "-0.5"},
                                   {"arap_weight", -1, "-1"},
                                   {"arap_weight", 1e7, "1e+07"},
                                   {"max_iterations", 0, "0"},
                                   {"max_iterations", 100'001, "100001"},
                                   {"max_iterations", 4e9, "2.14748e+09"},
                                   {"relative_decrease", 0, "0"},
                                   {"relative_decrease", 0.75, "0.75"},
                                   {"first_stiffness", 0.5, "0.5"},
                                   {"samples_per_triangle", 0, "0"},
                                   {"samples_per_triangle", 101, "101"},
                                   {"radius_share", 1.5, "1.5"},
                                   {"radius_share", -0.5, "-0.5"},
                                   {"first_radius", 0.5, "0.5"},
                                   {"first_radius", 65, "65"},
                                   {"first_radius", kNan, "nan"},
                                   {"kernel_scale", -1, "-1"},
                                   {"coverage_weight", -1, "-1"},
                                   {"coverage_weight", 1e7, "1e+07"},
                                   {"landmark_weight", -1, "-1"},
                                   {"landmark_weight", 1e7, "1e+07"},
                                   {"boundary_weight", -1, "-1"},
                                   {"boundary_weight", 1e7, "1e+07"},
                                   {"coverage_points_per_vertex", 0, "0"},
                                   {"coverage_points_per_vertex", 1001, "1001"},
                                   {"learning_rate", 0, "0"},
                                   {"learning_rate", 2, "2"},
                                   {"distance_weight", -1, "-1"},
                                   {"distance_weight", kNan, "nan"},
                                   {"image.weight", -1, "-1"},
                                   {"image.size", 63, "63"},
                                   {"image.size", 4e9, "2.14748e+09"},
                                   {"image.calibration_error", -1, "-1"},
                                   {"image.calibration_error", 101, "101"},
                                   {"image.view_count", 0, "0"},
                                   {"image.view_count", 201, "201"},
                                   {"image.views_per_iteration", 201, "201"},
                                   {"image.sigma", 0, "0"},
                                   {"image.blur_radius", 1.5, "1.5"},
                                   {"image.faces_per_pixel", 0, "0"},
                                   {"image.depth_weight", -1, "-1"},
                                   {"image.normal_weight", kNan, "nan"}};

const FieldDescriptor* FieldNamed(const std::string& name) {
  for (const FieldDescriptor* field : Fields()) {
    if (NameOf(field) == name) return field;
  }
  return nullptr;
}

TEST(FitOptionsConvertTest, EveryValueOutOfRangeIsRefusedByName) {
  for (const BadValue& bad : kBadValues) {
    const FieldDescriptor* field = FieldNamed(bad.field);
    ASSERT_NE(field, nullptr) << bad.field;
    v1::FitOptions proto;
    google::protobuf::Message* holder = Holder(&proto, field);
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
      holder->GetReflection()->SetDouble(holder, field, bad.value);
    } else {
      holder->GetReflection()->SetUInt32(holder, field, static_cast<uint32_t>(bad.value));
    }
    const auto options = FromProto(proto);
    ASSERT_TRUE(options.ok()) << options.status();
    const absl::Status status = options->Validate();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << bad.field << " " << bad.value;
    EXPECT_THAT(std::string(status.message()),
                HasSubstr(std::string(bad.field) + " is " + bad.quoted + "; it must be from"));
  }
}

TEST(FitOptionsConvertTest, EveryNumberHasAValueThatIsOutOfRange) {
  for (const FieldDescriptor* field : Fields()) {
    const bool takes_all = field->cpp_type() == FieldDescriptor::CPPTYPE_BOOL ||
                           field->cpp_type() == FieldDescriptor::CPPTYPE_UINT64;
    if (field->enum_type() != nullptr || takes_all) continue;
    bool tested = false;
    for (const BadValue& bad : kBadValues) tested |= NameOf(field) == bad.field;
    EXPECT_TRUE(tested) << field->name();
  }
}

}  // namespace
}  // namespace cagefit::server
