#include "server/transport/session_convert.h"

#include <gmock/gmock.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include "server/session/error_detail.h"
#include "server/transport/fit_options_convert.h"
#include "tests/server/session/session_fixture.h"

namespace cagefit::server {
namespace {

using cagefit::testing::FrameCage;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

v1::CreateSessionRequest CageRequest() {
  v1::CreateSessionRequest request;
  *request.mutable_control_mesh() = ToProto(FrameCage());
  return request;
}

void ExpectRefused(const v1::CreateSessionRequest& request, const std::string& field) {
  const absl::Status status = FromProto(request, SessionLimits()).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr(field));
}

// A quarter turn about z, and a different number everywhere else.
v1::Camera UnusualCamera(const std::string& name) {
  v1::Camera camera;
  camera.set_name(name);
  camera.set_width(640);
  camera.set_height(480);
  camera.set_fx(500);
  camera.set_fy(510);
  camera.set_cx(319.5);
  camera.set_cy(239.25);
  for (const double value : {0, -1, 0, 1, 0, 0, 0, 0, 1}) camera.add_rotation(value);
  for (const double value : {0.25, 0.5, 3.0}) camera.add_translation(value);
  camera.set_k1(0.01);
  camera.set_k2(0.02);
  camera.set_p1(0.03);
  camera.set_p2(0.04);
  camera.set_k3(0.05);
  return camera;
}

// All options away from their defaults; those of the fit are those of the paper.
v1::SessionOptions UnusualOptions() {
  v1::SessionOptions options;
  options.set_priority(v1::PRIORITY_BATCH);
  *options.mutable_fit() = ToProto(FitOptions::Paper());
  options.set_quantum(1e-3);
  options.set_delta_encoding(v1::DELTA_ENCODING_DRACO);
  options.set_key_interval(5);
  options.set_priority(v1::PRIORITY_BATCH);
  options.set_tolerance(0.003);
  options.set_max_vertices(500);
  *options.add_cameras() = UnusualCamera("left");
  *options.add_cameras() = UnusualCamera("right");
  return options;
}

TEST(SessionConvertTest, CamerasAreLookedThroughUnlessTheViewsAreSaid) {
  v1::CreateSessionRequest request = CageRequest();
  *request.mutable_options()->add_cameras() = UnusualCamera("left");
  EXPECT_EQ(FromProto(request, SessionLimits())->fit.image.views, Views::kCameras);
  request.mutable_options()->mutable_fit()->mutable_image()->set_views(v1::VIEWS_NONE);
  EXPECT_EQ(FromProto(request, SessionLimits())->fit.image.views, Views::kNone);
  EXPECT_EQ(FromProto(CageRequest(), SessionLimits())->fit.image.views, Views::kNone);
}

TEST(SessionConvertTest, EveryOptionArrivesAndComesBack) {
  v1::CreateSessionRequest request = CageRequest();
  request.set_name("a name");
  *request.mutable_options() = UnusualOptions();
  const auto config = FromProto(request, SessionLimits());
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->Validate(), absl::OkStatus());
  EXPECT_EQ(config->fit.solver.max_iterations, 1000);
  EXPECT_EQ(config->fit.arap.weight, 0.01);
  ASSERT_EQ(config->cameras.size(), 2u);
  EXPECT_EQ(config->cameras[1].name, "right");
  EXPECT_EQ(config->cameras[1].R * Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY());
  EXPECT_EQ(config->cameras[1].distortion.p2, 0.04);

  SessionRecord record;
  record.id = "an-id";
  record.created = absl::FromUnixSeconds(5);
  record.config = *config;
  record.head.control_vertices = 42;
  record.head.triangles = 80;
  const SessionLedger ledger(record, std::nullopt, SessionLimits(), nullptr);
  const v1::Session session = ToProto(ledger);
  EXPECT_TRUE(
      google::protobuf::util::MessageDifferencer::Equals(session.options(), request.options()))
      << session.options().DebugString();
  EXPECT_EQ(session.session_id(), "an-id");
  EXPECT_EQ(session.name(), "a name");
  EXPECT_EQ(session.created().seconds(), 5);
  EXPECT_EQ(session.control_vertices(), 42u);
  EXPECT_EQ(session.triangles(), 80u);
}

TEST(SessionConvertTest, RefusesCamerasThatAreCutOff) {
  v1::CreateSessionRequest request = CageRequest();
  *request.mutable_options()->add_cameras() = UnusualCamera("left");
  v1::Camera* second = request.mutable_options()->add_cameras();
  *second = UnusualCamera("right");
  second->add_rotation(1);
  ExpectRefused(request, "options.cameras[1].rotation is 10 values long; expected 9");
  *second = UnusualCamera("right");
  second->mutable_translation()->Truncate(2);
  ExpectRefused(request, "options.cameras[1].translation is 2 values long; expected 3");
}

TEST(SessionConvertTest, WhatIsNotSetTakesTheDefault) {
  const auto config = FromProto(CageRequest(), SessionLimits());
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->quantum, SessionConfig().quantum);
  EXPECT_EQ(config->key_interval, SessionConfig().key_interval);
  EXPECT_EQ(config->delta_encoding, DeltaEncoding::kPacked);
  EXPECT_EQ(config->fit.solver.max_iterations, SolverOptions().max_iterations);
  EXPECT_EQ(config->fit.solver.solver, Solver::kGaussNewton);
  EXPECT_EQ(config->fit.arap.weight, std::nullopt);
}

TEST(SessionConvertTest, ZeroIsAValueWhereItIsSet) {
  v1::CreateSessionRequest request = CageRequest();
  request.mutable_options()->set_quantum(0);
  request.mutable_options()->set_key_interval(0);
  request.mutable_options()->mutable_fit()->set_max_iterations(0);
  const auto config = FromProto(request, SessionLimits());
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->quantum, 0);
  EXPECT_EQ(config->key_interval, 0u);
  EXPECT_EQ(config->fit.solver.max_iterations, 0);
}

TEST(SessionConvertTest, ValuesBeyondInt32StayOutOfRange) {
  v1::CreateSessionRequest request = CageRequest();
  request.mutable_options()->mutable_fit()->set_max_iterations(4'000'000'000u);
  EXPECT_FALSE(FromProto(request, SessionLimits())->Validate().ok());
  request = v1::CreateSessionRequest();
  request.mutable_make_template()->set_vertices(4'000'000'000u);
  EXPECT_EQ(FromProto(request, SessionLimits())->make_template.vertices, 2147483647);
}

TEST(SessionConvertTest, AWishForATemplateArrives) {
  v1::CreateSessionRequest request;
  request.mutable_make_template()->set_vertices(300);
  EXPECT_EQ(FromProto(request, SessionLimits())->make_template.crease_angle_degrees, std::nullopt);
  request.mutable_make_template()->set_crease_angle_degrees(0);
  const auto config = FromProto(request, SessionLimits());
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->make_template.vertices, 300);
  EXPECT_EQ(config->make_template.crease_angle_degrees, 0);
}

TEST(SessionConvertTest, AToleranceStartsFromASmallTemplateWhereNoneIsNamed) {
  v1::CreateSessionRequest request;
  request.mutable_options()->set_tolerance(0.002);
  for (const bool crease_angle : {false, true}) {
    if (crease_angle) request.mutable_make_template()->set_crease_angle_degrees(30);
    const auto config = FromProto(request, SessionLimits());
    ASSERT_TRUE(config.ok()) << config.status();
    EXPECT_EQ(config->make_template.vertices, SessionConfig::kToleranceStartVertices);
    EXPECT_EQ(config->make_template.crease_angle_degrees.has_value(), crease_angle);
    EXPECT_EQ(config->tolerance->tolerance, 0.002);
    EXPECT_EQ(config->tolerance->max_vertices, 0);
    EXPECT_EQ(config->Validate(), absl::OkStatus());
  }
  request.mutable_make_template()->set_vertices(50);
  EXPECT_EQ(FromProto(request, SessionLimits())->make_template.vertices, 50);
}

TEST(SessionConvertTest, AToleranceOf0IsOff) {
  v1::CreateSessionRequest request = CageRequest();
  request.mutable_options()->set_tolerance(0);
  EXPECT_FALSE(FromProto(request, SessionLimits())->tolerance.has_value());
}

TEST(SessionConvertTest, AToleranceAndItsLimitThatAreOutOfRangeAreRefused) {
  v1::CreateSessionRequest request = CageRequest();
  request.mutable_options()->set_tolerance(-0.5);
  EXPECT_TRUE(absl::IsInvalidArgument(FromProto(request, SessionLimits())->Validate()));
  request.mutable_options()->set_tolerance(std::nan(""));
  EXPECT_TRUE(absl::IsInvalidArgument(FromProto(request, SessionLimits())->Validate()));
  request.mutable_options()->set_tolerance(0.001);
  request.mutable_options()->set_max_vertices(0);
  ExpectRefused(request, "options.max_vertices is 0");
  request.mutable_options()->set_max_vertices(4'000'000'000u);
  EXPECT_EQ(FromProto(request, SessionLimits())->tolerance->max_vertices, 2147483647);
}

TEST(SessionConvertTest, TheSessionTellsItsFacts) {
  testing::OpenSession open(testing::CageConfig());
  ASSERT_TRUE(open.Answer(testing::MovingFrame(0)).ok());
  ASSERT_TRUE(open.Answer(testing::DecodedFrame(1, "no Draco")).ok());
  const v1::Session session = ToProto(*open.ledger);
  EXPECT_EQ(session.epoch(), 1u);
  EXPECT_EQ(session.next_sequence_number(), 2u);
  EXPECT_EQ(session.fitted_frames(), 1u);
  EXPECT_EQ(session.rejected_frames(), 1u);
  EXPECT_TRUE(session.stream_attached());
}

TEST(SessionConvertTest, MeshesKeepVerticesTrianglesAndTags) {
  const ControlMesh cage = FrameCage();
  const ControlMesh tagged =
      ControlMesh::Create(cage.vertices(), cage.triangles(),
                          {{{cage.triangles()(0, 0), cage.triangles()(1, 0)}}, {3, 4}})
          .value();
  v1::CreateSessionRequest request;
  *request.mutable_control_mesh() = ToProto(tagged);
  const auto config = FromProto(request, SessionLimits());
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->control_mesh->vertices(), tagged.vertices());
  EXPECT_EQ(config->control_mesh->triangles(), tagged.triangles());
  EXPECT_EQ(config->control_mesh->tags().edges, tagged.tags().edges);
  EXPECT_THAT(config->control_mesh->tags().corners, ElementsAre(3, 4));

  const v1::ControlMesh connectivity = ConnectivityToProto(tagged);
  EXPECT_EQ(connectivity.vertices_size(), 0);
  EXPECT_EQ(connectivity.triangles_size(), 240);
  EXPECT_EQ(connectivity.crease_edges_size(), 2);
  EXPECT_EQ(connectivity.corners_size(), 2);
}

TEST(SessionConvertTest, RefusesEnumValuesThatItDoesNotKnow) {
  v1::CreateSessionRequest request = CageRequest();
  request.mutable_options()->mutable_fit()->set_sampling(static_cast<v1::Sampling>(99));
  ExpectRefused(request, "options.fit.sampling is 99");
  request = CageRequest();
  request.mutable_options()->set_delta_encoding(static_cast<v1::DeltaEncoding>(99));
  ExpectRefused(request, "options.delta_encoding is 99");
}

TEST(SessionConvertTest, RefusesARequestWithoutTemplate) {
  ExpectRefused(v1::CreateSessionRequest(), "template");
}

TEST(SessionConvertTest, RefusesListsThatAreCutOff) {
  v1::CreateSessionRequest request = CageRequest();
  request.mutable_control_mesh()->add_vertices(1);
  ExpectRefused(request, "control_mesh.vertices");
  request = CageRequest();
  request.mutable_control_mesh()->add_triangles(1);
  ExpectRefused(request, "control_mesh.triangles");
  request = CageRequest();
  request.mutable_control_mesh()->add_crease_edges(1);
  ExpectRefused(request, "control_mesh.crease_edges");
}

TEST(SessionConvertTest, RefusesAMeshThatIsNotValid) {
  for (const uint32_t index : {42u, 0x80000000u, 0xFFFFFFFFu}) {
    v1::CreateSessionRequest request = CageRequest();
    request.mutable_control_mesh()->set_triangles(0, index);
    ExpectRefused(request, "");
    request = CageRequest();
    request.mutable_control_mesh()->add_corners(index);
    ExpectRefused(request, "");
  }
  v1::CreateSessionRequest request = CageRequest();
  request.mutable_control_mesh()->set_vertices(0, std::nan(""));
  const absl::Status status = FromProto(request, SessionLimits()).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_EQ(DetailOf(status)->reason, "INVALID_CONTROL_MESH");
}

TEST(SessionConvertTest, RefusesAMeshAboveTheLimit) {
  SessionLimits limits;
  limits.max_control_vertices = 41;
  const absl::Status status = FromProto(CageRequest(), limits).status();
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_EQ(DetailOf(status)->value, "42");
  EXPECT_EQ(DetailOf(status)->limit, "41");
}

}  // namespace
}  // namespace cagefit::server
