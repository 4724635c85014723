#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/commands/command.h"
#include "client/io/file_bytes.h"
#include "client/io/geometry_file.h"
#include "client/synth/capture.h"
#include "core/base/status.h"
#include "core/codec/draco_codec.h"

namespace cagefit::client {
namespace {

struct SynthArguments {
  std::string shape, out, format = "drc";
  CaptureOptions capture;
  int position_bits = 14;
};

absl::Status WriteFrame(const SynthArguments& arguments, const std::string& path,
                        const PointCloud& cloud) {
  if (arguments.format != "drc") return WriteCloud(path, cloud);
  DracoCloudOptions options;
  options.position_bits = arguments.position_bits;
  ASSIGN_OR_RETURN(const std::string bytes, EncodeDracoCloud(cloud, options));
  return WriteFileBytes(path, bytes);
}

absl::Status Synthesize(const SynthArguments& arguments) {
  RETURN_IF_ERROR(arguments.capture.Validate());
  ASSIGN_OR_RETURN(const std::unique_ptr<SynthShape> shape,
                   MakeShape(arguments.shape, arguments.capture.seed));
  std::error_code error;
  std::filesystem::create_directories(arguments.out + "/truth", error);
  if (error) {
    return absl::FailedPreconditionError(
        absl::StrCat(arguments.out, ": cannot be made: ", error.message()));
  }
  for (int frame = 0; frame < arguments.capture.frames; ++frame) {
    const PointCloud cloud = CaptureFrame(*shape, frame, arguments.capture);
    RETURN_IF_ERROR(WriteFrame(
        arguments, absl::StrFormat("%s/frame_%04d.%s", arguments.out, frame, arguments.format),
        cloud));
    RETURN_IF_ERROR(WriteMesh(absl::StrFormat("%s/truth/frame_%04d.ply", arguments.out, frame),
                              {shape->Vertices(FrameTime(frame)), shape->rest().triangles}));
  }
  std::cout << arguments.out << ": " << arguments.capture.frames << " frames of "
            << arguments.capture.points << " points; the true motion of "
            << shape->rest().vertices.cols() << " vertices is in " << arguments.out << "/truth\n";
  return absl::OkStatus();
}

}  // namespace

void AddSynthCommand(CLI::App* app, Run* run) {
  const auto arguments = std::make_shared<SynthArguments>();
  CaptureOptions* capture = &arguments->capture;
  CLI::App* command = app->add_subcommand(
      "synth",
      "Make a capture with known motion: tube (cloth-like, open at both ends, twists and "
      "waves) or blob (closed, bends and breathes)");
  command->add_option("SHAPE", arguments->shape, absl::StrJoin(ShapeNames(), " or "))
      ->required()
      ->check(CLI::IsMember(ShapeNames()));
  command->add_option("--out", arguments->out, "Folder to write to")->required();
  command->add_option("--frames", capture->frames, "Frames")->capture_default_str();
  command->add_option("--points", capture->points, "Points of a frame")->capture_default_str();
  command->add_option("--seed", capture->seed, "Details of the shape, and where points fall")
      ->capture_default_str();
  command->add_option("--noise", capture->noise, "Standard deviation, share of the diagonal")
      ->capture_default_str();
  command->add_option("--outliers", capture->outliers, "Share of the points")
      ->capture_default_str();
  command->add_option("--format", arguments->format, "drc, ply or xyz")
      ->capture_default_str()
      ->check(CLI::IsMember({"drc", "ply", "xyz"}));
  command->add_option("--position-bits", arguments->position_bits, "Draco's, 8 to 30")
      ->capture_default_str()
      ->check(CLI::Range(8, 30));
  command->callback([arguments, run] {
    *run = [arguments] {
      const absl::Status status = Synthesize(*arguments);
      if (status.ok()) return static_cast<int>(kDone);
      Report(status);
      return absl::IsInvalidArgument(status) ? static_cast<int>(kWrongUsage)
                                             : static_cast<int>(kFailed);
    };
  });
}

}  // namespace cagefit::client
