#include "tests/bench/scenes.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>

#include "absl/strings/str_cat.h"
#include "client/encode_frame.h"
#include "client/io/geometry_file.h"
#include "client/synth/capture.h"
#include "core/cloud/surface_cloud.h"
#include "core/codec/draco_codec.h"
#include "core/template/template_maker.h"
#include "tests/support/data.h"

namespace cagefit::bench {
namespace {

constexpr size_t kDecodedFrames = 2;

template <typename Value>
Value OrDie(absl::StatusOr<Value> value) {
  if (value.ok()) return *std::move(value);
  std::cerr << value.status() << "\n";
  std::exit(EXIT_FAILURE);
}

bool Small() { return std::getenv("CAGEFIT_BENCH_SMALL") != nullptr; }
bool HasData() { return !Small() && !testing::DataDir().empty(); }

// Decodes the first frames and makes the cage from the first one.
Scene WithCage(std::string label, std::vector<std::string> frames, int32_t vertices) {
  std::vector<PointCloud> clouds;
  for (size_t k = 0; k < std::min(frames.size(), kDecodedFrames); ++k) {
    clouds.push_back(OrDie(DecodeDracoCloud(frames[k], DecodeLimits())));
  }
  TemplateReport report;
  ControlMesh cage = OrDie(TemplateFromCloud(clouds[0], {vertices}, &report));
  absl::StrAppend(&label, ", ", clouds[0].size(), " points, ", cage.vertex_count(),
                  " control vertices");
  return {std::move(label), std::move(cage), std::move(frames), std::move(clouds)};
}

Scene SyntheticSequence(const client::SynthShape& shape, const std::string& name, int frames,
                        int64_t points, int32_t vertices) {
  client::CaptureOptions options;
  options.frames = frames;
  options.points = points;
  std::vector<std::string> encoded;
  for (int frame = 0; frame < frames; ++frame) {
    encoded.push_back(
        OrDie(EncodeDracoCloud(client::CaptureFrame(shape, frame, options), DracoCloudOptions())));
  }
  return WithCage(name, std::move(encoded), vertices);
}

Scene MakeSequence() {
  if (Small()) return SyntheticSequence(*client::MakeTube(1), "small tube", 4, 5'000, 200);
  if (!HasData()) return SyntheticSequence(*client::MakeTube(1), "tube", 30, 100'000, 2046);
  std::vector<std::filesystem::path> files;
  for (const auto& entry :
       std::filesystem::directory_iterator(testing::DataDir() + "/tshirt/drc")) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<std::string> frames;
  for (const auto& file : files) frames.push_back(OrDie(client::EncodeFrame(file, 16)));
  return WithCage("T-shirt", std::move(frames), 2046);
}

Scene MakeStatic() {
  if (Small()) return SyntheticSequence(*client::MakeBlob(1), "small blob", 1, 5'000, 300);
  if (!HasData()) return SyntheticSequence(*client::MakeBlob(1), "blob", 1, 35'000, 4667);
  const client::Geometry bunny =
      OrDie(client::ReadGeometry(testing::DataDir() + "/static/bunny_closed_34835.ply"));
  TemplateReport report;
  ControlMesh cage = OrDie(TemplateFromMesh(bunny.mesh, {4667}, &report));
  PointCloud cloud = SurfaceCloud(bunny.mesh, bunny.normals);
  const std::string label =
      absl::StrCat("bunny, ", cloud.size(), " points, ", cage.vertex_count(), " control vertices");
  return {label, std::move(cage), {}, {std::move(cloud)}};
}

}  // namespace

const Scene& Sequence() {
  static const Scene& scene = *new Scene(MakeSequence());
  return scene;
}

const Scene& Static() {
  static const Scene& scene = *new Scene(MakeStatic());
  return scene;
}

}  // namespace cagefit::bench
