#include "client/commands/fit_options.h"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/util/message_differencer.h>

#include <set>
#include <sstream>

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
  const auto* descriptor = v1::FitOptions::descriptor();
  for (int k = 0; k < descriptor->field_count(); ++k) {
    const auto* field = descriptor->field(k);
    const auto begins_with = [&](const std::string& start) {
      const auto found = reached.lower_bound(start);
      return found != reached.end() && found->compare(0, start.size(), start) == 0;
    };
    EXPECT_TRUE(begins_with(field->name() + ": ")) << field->name();
    for (int v = 1; field->enum_type() != nullptr && v < field->enum_type()->value_count(); ++v) {
      const std::string text = field->name() + ": " + field->enum_type()->value(v)->name();
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
