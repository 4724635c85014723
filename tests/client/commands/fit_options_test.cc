#include "client/commands/fit_options.h"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/util/message_differencer.h>

#include <set>
#include <sstream>
#include <utility>
#include <vector>

namespace cagefit::client {
namespace {

using ::google::protobuf::util::MessageDifferencer;

// Arguments after "fit INPUT --out DIR". CLI::ParseError is wrong usage.
FitArguments Parse(const std::string& flags) {
  FitArguments arguments;
  CLI::App app("", "fit");
  AddFitFlags(&arguments, &app);
  app.parse("in.ply --out dir " + flags);
  return arguments;
}

struct Flag {
  const char* flag;
  std::function<void(v1::FitOptions*)> set;
};

// A flag for every field.
std::vector<Flag> Flags() {
  return {
      {"--preset paper", [](auto* o) { o->set_preset(v1::PRESET_PAPER); }},
      {"--preset default", [](auto* o) { o->set_preset(v1::PRESET_DEFAULT); }},
      {"--field imls", [](auto* o) { o->set_field(v1::FIELD_IMLS); }},
      {"--field rimls", [](auto* o) { o->set_field(v1::FIELD_RIMLS); }},
      {"--sampling control-vertices",
       [](auto* o) { o->set_sampling(v1::SAMPLING_CONTROL_VERTICES); }},
      {"--sampling refined-vertices",
       [](auto* o) { o->set_sampling(v1::SAMPLING_REFINED_VERTICES); }},
      {"--sampling area", [](auto* o) { o->set_sampling(v1::SAMPLING_AREA); }},
      {"--samples-per-triangle 9", [](auto* o) { o->set_samples_per_triangle(9); }},
      {"--radius 0.25", [](auto* o) { o->set_radius(0.25); }},
      {"--radius-share 0.02", [](auto* o) { o->set_radius_share(0.02); }},
      {"--radius-factor 3", [](auto* o) { o->set_radius_factor(3); }},
      {"--far-radius 0.75", [](auto* o) { o->set_far_radius(0.75); }},
      {"--first-radius 8", [](auto* o) { o->set_first_radius(8); }},
      {"--kernel identity", [](auto* o) { o->set_kernel(v1::KERNEL_IDENTITY); }},
      {"--kernel huber", [](auto* o) { o->set_kernel(v1::KERNEL_HUBER); }},
      {"--kernel geman-mcclure", [](auto* o) { o->set_kernel(v1::KERNEL_GEMAN_MCCLURE); }},
      {"--kernel tukey", [](auto* o) { o->set_kernel(v1::KERNEL_TUKEY); }},
      {"--kernel-scale 0.375", [](auto* o) { o->set_kernel_scale(0.375); }},
      {"--coverage-weight 0", [](auto* o) { o->set_coverage_weight(0); }},
      {"--boundary-weight 0.5", [](auto* o) { o->set_boundary_weight(0.5); }},
      {"--landmark-weight 2", [](auto* o) { o->set_landmark_weight(2); }},
      {"--coverage-points 33", [](auto* o) { o->set_coverage_points_per_vertex(33); }},
      {"--arap-weight 0.125", [](auto* o) { o->set_arap_weight(0.125); }},
      {"--rest template", [](auto* o) { o->set_rest_mesh(v1::REST_MESH_TEMPLATE); }},
      {"--rest previous", [](auto* o) { o->set_rest_mesh(v1::REST_MESH_PREVIOUS_FRAME); }},
      {"--solver gauss-newton", [](auto* o) { o->set_solver(v1::SOLVER_GAUSS_NEWTON); }},
      {"--solver ceres", [](auto* o) { o->set_solver(v1::SOLVER_CERES); }},
      {"--solver adam", [](auto* o) { o->set_solver(v1::SOLVER_ADAM); }},
      {"--max-iterations 17", [](auto* o) { o->set_max_iterations(17); }},
      {"--relative-decrease 0.5", [](auto* o) { o->set_relative_decrease(0.5); }},
      {"--first-stiffness 2", [](auto* o) { o->set_first_stiffness(2); }},
      {"--learning-rate 0.5", [](auto* o) { o->set_learning_rate(0.5); }},
      {"--remove-outliers", [](auto* o) { o->set_remove_outliers(true); }},
      {"--keep-outliers", [](auto* o) { o->set_remove_outliers(false); }},
      {"--remove-outliers=false", [](auto* o) { o->set_remove_outliers(false); }},
      {"--repair-normals", [](auto* o) { o->set_repair_normals(true); }},
      {"--keep-normals", [](auto* o) { o->set_repair_normals(false); }},
      {"--distance-weight 0", [](auto* o) { o->set_distance_weight(0); }},
      {"--image-views none", [](auto* o) { o->mutable_image()->set_views(v1::VIEWS_NONE); }},
      {"--image-views cameras", [](auto* o) { o->mutable_image()->set_views(v1::VIEWS_CAMERAS); }},
      {"--image-views sphere", [](auto* o) { o->mutable_image()->set_views(v1::VIEWS_SPHERE); }},
      {"--image-views tutorial",
       [](auto* o) { o->mutable_image()->set_views(v1::VIEWS_TUTORIAL); }},
      {"--image-weight 0.5", [](auto* o) { o->mutable_image()->set_weight(0.5); }},
      {"--image-mode outline",
       [](auto* o) { o->mutable_image()->set_mode(v1::SILHOUETTE_MODE_OUTLINE); }},
      {"--image-mode pytorch3d",
       [](auto* o) { o->mutable_image()->set_mode(v1::SILHOUETTE_MODE_PYTORCH3D); }},
      {"--image-size 512", [](auto* o) { o->mutable_image()->set_size(512); }},
      {"--image-view-count 8", [](auto* o) { o->mutable_image()->set_view_count(8); }},
      {"--image-views-per-iteration 2",
       [](auto* o) { o->mutable_image()->set_views_per_iteration(2); }},
      {"--image-sigma 0.001", [](auto* o) { o->mutable_image()->set_sigma(0.001); }},
      {"--image-blur-radius 0.002", [](auto* o) { o->mutable_image()->set_blur_radius(0.002); }},
      {"--image-faces-per-pixel 50", [](auto* o) { o->mutable_image()->set_faces_per_pixel(50); }},
      {"--image-depth-weight 3", [](auto* o) { o->mutable_image()->set_depth_weight(3); }},
      {"--image-normal-weight 4", [](auto* o) { o->mutable_image()->set_normal_weight(4); }},
      {"--image-calibration-error 0",
       [](auto* o) { o->mutable_image()->set_calibration_error(0); }},
      {"--image-seed 18446744073709551615",
       [](auto* o) { o->mutable_image()->set_seed(~uint64_t{0}); }},
  };
}

TEST(FitOptionsTest, EveryFlagSetsItsFieldAndNoOther) {
  for (const Flag& flag : Flags()) {
    v1::FitOptions expected;
    flag.set(&expected);
    const v1::FitOptions fit = Parse(flag.flag).options.fit();
    EXPECT_TRUE(MessageDifferencer::Equals(fit, expected))
        << flag.flag << " gave " << fit.ShortDebugString();
  }
}

TEST(FitOptionsTest, EveryFieldAndEveryEnumeratorHasAFlag) {
  std::set<std::string> reached;
  for (const Flag& flag : Flags()) {
    v1::FitOptions options;
    flag.set(&options);
    reached.insert(options.ShortDebugString());
  }
  std::vector<std::pair<std::string, const google::protobuf::FieldDescriptor*>> fields;
  for (int k = 0; k < v1::FitOptions::descriptor()->field_count(); ++k) {
    const auto* field = v1::FitOptions::descriptor()->field(k);
    if (field->message_type() == nullptr) fields.emplace_back("", field);
  }
  for (int k = 0; k < v1::ImageOptions::descriptor()->field_count(); ++k) {
    fields.emplace_back("image { ", v1::ImageOptions::descriptor()->field(k));
  }
  for (const auto& [parent, field] : fields) {
    const auto begins_with = [&](const std::string& start) {
      const auto found = reached.lower_bound(start);
      return found != reached.end() && found->compare(0, start.size(), start) == 0;
    };
    EXPECT_TRUE(begins_with(parent + field->name() + ": ")) << field->name();
    for (int v = 1; field->enum_type() != nullptr && v < field->enum_type()->value_count(); ++v) {
      const std::string text = parent + field->name() + ": " + field->enum_type()->value(v)->name();
      EXPECT_TRUE(begins_with(text)) << text;
    }
  }
}

TEST(FitOptionsTest, WhatIsNotGivenStaysUnset) {
  const FitArguments arguments = Parse("");
  EXPECT_EQ(arguments.options.ShortDebugString(), "fit { }");
  EXPECT_EQ(arguments.crease_angle, std::nullopt);
}

TEST(FitOptionsTest, ACreaseAngleIsForAMeshThatIsMade) {
  EXPECT_EQ(Parse("--vertices 9 --crease-angle 0").crease_angle, 0);
  EXPECT_THROW(Parse("--template c.obj --crease-angle 30"), CLI::ParseError);
}

TEST(FitOptionsTest, AToleranceIsAShareOnTheWire) {
  const FitArguments arguments = Parse("--tolerance 0.1% --max-vertices 3000");
  EXPECT_DOUBLE_EQ(arguments.options.tolerance(), 0.001);
  EXPECT_EQ(arguments.options.max_vertices(), 3000u);
  EXPECT_THROW(Parse("--tolerance fine"), CLI::ParseError);
}

TEST(FitOptionsTest, MasksAreOfCameras) {
  const FitArguments arguments = Parse("--cameras c.json --masks m");
  EXPECT_EQ(arguments.cameras, "c.json");
  EXPECT_EQ(arguments.masks, "m");
  EXPECT_THROW(Parse("--masks m"), CLI::ParseError);
}

TEST(FitOptionsTest, RefusesWhatIsNoValue) {
  for (const char* flags :
       {"--preset best", "--field mls", "--sampling all", "--kernel welsch", "--solver sgd",
        "--rest none", "--radius wide", "--samples-per-triangle -1", "--coverage-points 1.5",
        "--crease-angle sharp", "--learning-rate"}) {
    EXPECT_THROW(Parse(flags), CLI::ParseError) << flags;
  }
  EXPECT_THROW(Parse("--keep-outliers=maybe"), std::invalid_argument);
}

}  // namespace
}  // namespace cagefit::client
