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

std::vector<const FieldDescriptor*> Fields() {
  std::vector<const FieldDescriptor*> fields;
  for (int k = 0; k < v1::FitOptions::descriptor()->field_count(); ++k) {
    fields.push_back(v1::FitOptions::descriptor()->field(k));
  }
  return fields;
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
  fit.set_learning_rate(0.015625);
  fit.set_remove_outliers(false);
  fit.set_repair_normals(false);
  return fit;
}

FitOptions Unusual() {
  FitOptions o;
  o.target = {false, false};
  o.distance = {Field::kRimls, Sampling::kArea, 9, 0.25, 0.0625, 3, 0.75, 8, Kernel::kTukey, 0.375};
  o.coverage = {0.875, 33};
  o.arap = {0.125, RestMesh::kPreviousFrame};
  o.solver = {Solver::kAdam, 17, 0.5, 2, 0.015625};
  return o;
}

void ExpectSame(const FitOptions& a, const FitOptions& b) {
  EXPECT_EQ(a.target.remove_outliers, b.target.remove_outliers);
  EXPECT_EQ(a.target.repair_normals, b.target.repair_normals);
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
  EXPECT_EQ(a.arap.weight, b.arap.weight);
  EXPECT_EQ(a.arap.rest, b.arap.rest);
  EXPECT_EQ(a.solver.solver, b.solver.solver);
  EXPECT_EQ(a.solver.max_iterations, b.solver.max_iterations);
  EXPECT_EQ(a.solver.relative_decrease, b.solver.relative_decrease);
  EXPECT_EQ(a.solver.first_stiffness, b.solver.first_stiffness);
  EXPECT_EQ(a.solver.learning_rate, b.solver.learning_rate);
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
  const v1::FitOptions in_force = ToProto(FitOptions::Paper());
  for (const FieldDescriptor* field : Fields()) {
    EXPECT_EQ(v1::FitOptions::GetReflection()->HasField(in_force, field), field->name() != "preset")
        << field->name();
  }
  EXPECT_FALSE(ToProto(FitOptions()).has_arap_weight()) << "it stays automatic";
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
      v1::FitOptions::GetReflection()->SetEnum(&proto, field, field->enum_type()->value(k));
      const auto options = FromProto(proto);
      ASSERT_TRUE(options.ok()) << options.status();
      EXPECT_EQ(v1::FitOptions::GetReflection()->GetEnumValue(ToProto(*options), field), k)
          << field->name();
    }
  }
}

TEST(FitOptionsConvertTest, RefusesEnumValuesThatItDoesNotKnow) {
  for (const FieldDescriptor* field : Fields()) {
    if (field->enum_type() == nullptr) continue;
    for (const int value : {99, -1}) {
      v1::FitOptions proto;
      v1::FitOptions::GetReflection()->SetEnumValue(&proto, field, value);
      const absl::Status status = FromProto(proto).status();
      EXPECT_TRUE(absl::IsInvalidArgument(status)) << field->name() << ": " << status;
      ASSERT_TRUE(DetailOf(status).has_value());
      EXPECT_EQ(DetailOf(status)->field, "options.fit." + field->name());
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
                                   {"coverage_points_per_vertex", 0, "0"},
                                   {"coverage_points_per_vertex", 1001, "1001"},
                                   {"learning_rate", 0, "0"},
                                   {"learning_rate", 2, "2"}};

TEST(FitOptionsConvertTest, EveryValueOutOfRangeIsRefusedByName) {
  for (const BadValue& bad : kBadValues) {
    const FieldDescriptor* field = v1::FitOptions::descriptor()->FindFieldByName(bad.field);
    v1::FitOptions proto;
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
      v1::FitOptions::GetReflection()->SetDouble(&proto, field, bad.value);
    } else {
      v1::FitOptions::GetReflection()->SetUInt32(&proto, field, static_cast<uint32_t>(bad.value));
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
    if (field->enum_type() != nullptr || field->cpp_type() == FieldDescriptor::CPPTYPE_BOOL)
      continue;
    bool tested = false;
    for (const BadValue& bad : kBadValues) tested |= field->name() == bad.field;
    EXPECT_TRUE(tested) << field->name();
  }
}

}  // namespace
}  // namespace cagefit::server
