// Read back by Open Asset Import Library.
#include "client/io/gltf_writer.h"

#include <assimp/scene.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <assimp/Importer.hpp>
#include <cmath>

#include "core/subdiv/shaded_mesh.h"
#include "tests/support/shapes.h"
#include "tests/support/temp_folder.h"

namespace cagefit::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class GltfWriterTest : public ::testing::Test {
 protected:
  GltfWriterTest() {
    const TriangleMesh shape = testing::Icosphere(1);
    const int32_t a = shape.triangles(0, 0), b = shape.triangles(1, 0);
    cage_ = ControlMesh::Create(shape.vertices, shape.triangles, {{{a, b}}, {}}).value();
    for (const double bend : {0.0, 0.3, -0.2}) {
      Points3d V = cage_->vertices();
      V.row(0) += bend * V.row(1).cwiseProduct(V.row(1));
      motion_.push_back(V);
    }
  }

  // The frames 4, 5 and 8.
  MeshSequence Sequence() const {
    return {&*cage_, {{4, &motion_[0]}, {5, &motion_[1]}, {8, &motion_[2]}}};
  }

  const aiScene* Write(const MeshSequence& sequence, int levels,
                       const SceneSettings& settings = {}) {
    const std::string path = cagefit::testing::TempFolder() + "sequence.glb";
    EXPECT_EQ(WriteGltf(path, sequence, levels, settings), absl::OkStatus());
    const aiScene* scene = importer_.ReadFile(path, 0);
    EXPECT_NE(scene, nullptr) << importer_.GetErrorString();
    return scene;
  }

  std::optional<ControlMesh> cage_;
  std::vector<Points3d> motion_;
  Assimp::Importer importer_;
};

void ExpectNear(const aiVector3D* read, const Points3d& written) {
  ASSERT_NE(read, nullptr);
  double worst = 0;
  for (Eigen::Index v = 0; v < written.cols(); ++v) {
    const Eigen::Vector3d at(read[v].x, read[v].y, read[v].z);
    worst = std::max(worst, (at - written.col(v)).norm());
  }
  EXPECT_LT(worst, 1e-6);
}

TEST_F(GltfWriterTest, EveryFrameIsThere) {
  for (const int levels : {0, 1, 2}) {
    const ShadedMesh shaded(*cage_, levels);
    const aiScene* scene = Write(Sequence(), levels);
    ASSERT_EQ(scene->mNumMeshes, 1u);
    const aiMesh& mesh = *scene->mMeshes[0];
    ASSERT_EQ(mesh.mNumVertices, shaded.limit_vertices().size());
    ASSERT_EQ(mesh.mNumFaces, shaded.triangles().cols());
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(mesh.mFaces[f].mIndices[c], static_cast<unsigned>(shaded.triangles()(c, f)));
      }
    }
    ASSERT_EQ(mesh.mNumAnimMeshes, 2u);
    for (int k = 0; k < 3; ++k) {
      Points3d positions, normals;
      shaded.Evaluate(motion_[k], &positions, &normals);
      ExpectNear(k == 0 ? mesh.mVertices : mesh.mAnimMeshes[k - 1]->mVertices, positions);
      ExpectNear(k == 0 ? mesh.mNormals : mesh.mAnimMeshes[k - 1]->mNormals, normals);
    }
    EXPECT_STREQ(mesh.mAnimMeshes[1]->mName.C_Str(), "frame 8");
  }
}

TEST_F(GltfWriterTest, TheAnimationTurnsOnOneFrameAtATime) {
  const aiScene* scene = Write(Sequence(), 0, {10, 1, 'Y'});
  ASSERT_EQ(scene->mNumAnimations, 1u);
  const aiAnimation& animation = *scene->mAnimations[0];
  ASSERT_EQ(animation.mNumMorphMeshChannels, 1u);
  const aiMeshMorphAnim& morph = *animation.mMorphMeshChannels[0];
  ASSERT_EQ(morph.mNumKeys, 3u);
  const double seconds[] = {0, 0.1, 0.4};
  for (int k = 0; k < 3; ++k) {
    const aiMeshMorphKey& key = morph.mKeys[k];
    EXPECT_NEAR(key.mTime / animation.mTicksPerSecond, seconds[k], 1e-6);
    ASSERT_GE(key.mNumValuesAndWeights, 2u);
    for (unsigned j = 0; j < key.mNumValuesAndWeights; ++j) {
      const bool is_on = key.mValues[j] == static_cast<unsigned>(k - 1) && k > 0 && j < 2;
      EXPECT_EQ(key.mWeights[j], is_on ? 1 : 0) << k << " " << j;
    }
  }
}

TEST_F(GltfWriterTest, TheNodeBringsUnitsAndAxesToMetresAndYUp) {
  const aiScene* scene = Write(Sequence(), 0, {24, 0.01, 'Z'});
  ASSERT_NE(scene->mRootNode, nullptr);
  const aiNode* node = scene->mRootNode->FindNode("surface");
  ASSERT_NE(node, nullptr);
  const aiVector3D up = node->mTransformation * aiVector3D(1, 2, 3);
  EXPECT_NEAR(up.x, 0.01, 1e-8);
  EXPECT_NEAR(up.y, 0.03, 1e-8);
  EXPECT_NEAR(up.z, -0.02, 1e-8);
}

TEST_F(GltfWriterTest, OneFrameIsAStillMesh) {
  const aiScene* scene = Write({&*cage_, {{0, &motion_[1]}}}, 1);
  EXPECT_EQ(scene->mNumAnimations, 0u);
  EXPECT_EQ(scene->mMeshes[0]->mNumAnimMeshes, 0u);
  EXPECT_TRUE(scene->mRootNode->FindNode("surface")->mTransformation.IsIdentity());
}

TEST_F(GltfWriterTest, WhatTheFormatCannotHoldIsRefused) {
  const std::string path = cagefit::testing::TempFolder() + "refused.glb";
  EXPECT_TRUE(absl::IsInvalidArgument(WriteGltf(path, {&*cage_, {}}, 1, {})));
  MeshSequence many = {&*cage_, {}};
  for (int k = 0; k < 40'000; ++k) many.frames.push_back({k, &motion_[0]});
  const absl::Status status = WriteGltf(path, many, 0, {});
  EXPECT_TRUE(absl::IsInvalidArgument(status));
  EXPECT_THAT(status.message(), HasSubstr("40000 frames at 0 levels"));
  EXPECT_NE(access(path.c_str(), F_OK), 0);
}

}  // namespace
}  // namespace cagefit::client
