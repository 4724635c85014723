#include <cstdio>
#include <iostream>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/commands/command.h"
#include "client/io/camera_file.h"
#include "client/io/file_bytes.h"
#include "client/io/geometry_file.h"
#include "client/io/image_file.h"
#include "client/synth/capture.h"
#include "client/synth/rig.h"
#include "core/base/status.h"
#include "core/codec/draco_codec.h"

namespace cagefit::client {
namespace {

struct SynthArguments {
  std::string shape, out, format = "drc";
  CaptureOptions capture;
  RigOptions rig;
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

std::string MaskFolder(const std::string& out, const Camera& camera) {
  return out + "/masks/" + camera.name;
}

absl::Status WriteRig(const Rig& rig, const std::string& out) {
  if (rig.cameras().empty()) return absl::OkStatus();
  for (const Camera& camera : rig.cameras()) RETURN_IF_ERROR(MakeFolder(MaskFolder(out, camera)));
  return WriteCameras(out + "/cameras.json", rig.calibrated());
}

absl::Status WriteMasks(const Rig& rig, const SynthShape& shape, int frame,
                        const std::string& out) {
  for (size_t k = 0; k < rig.cameras().size(); ++k) {
    const std::string path =
        absl::StrFormat("%s/frame_%04d.png", MaskFolder(out, rig.cameras()[k]), frame);
    RETURN_IF_ERROR(WritePng(path, rig.Mask(shape, FrameTime(frame), k), 8));
  }
  return absl::OkStatus();
}

absl::Status Synthesize(const SynthArguments& arguments) {
  RETURN_IF_ERROR(arguments.capture.Validate());
  RETURN_IF_ERROR(arguments.rig.Validate());
  ASSIGN_OR_RETURN(const std::unique_ptr<SynthShape> shape,
                   MakeShape(arguments.shape, arguments.capture.seed));
  RETURN_IF_ERROR(MakeFolder(arguments.out + "/truth"));
  const Rig rig(*shape, arguments.rig, arguments.capture.seed);
  RETURN_IF_ERROR(WriteRig(rig, arguments.out));
  for (int frame = 0; frame < arguments.capture.frames; ++frame) {
    const PointCloud cloud = CaptureFrame(*shape, frame, arguments.capture);
    RETURN_IF_ERROR(WriteFrame(
        arguments, absl::StrFormat("%s/frame_%04d.%s", arguments.out, frame, arguments.format),
        cloud));
    RETURN_IF_ERROR(WriteMesh(absl::StrFormat("%s/truth/frame_%04d.ply", arguments.out, frame),
                              {shape->Vertices(FrameTime(frame)), shape->rest().triangles}));
    if (rig.TakesMasksOf(frame)) RETURN_IF_ERROR(WriteMasks(rig, *shape, frame, arguments.out));
  }
  std::cout << arguments.out << ": " << arguments.capture.frames << " frames of "
            << arguments.capture.points << " points; the true motion of "
            << shape->rest().vertices.cols() << " vertices is in " << arguments.out << "/truth\n";
  if (arguments.rig.cameras > 0) {
    std::cout << "Cameras: " << arguments.out << "/cameras.json; their masks: " << arguments.out
              << "/masks\n";
  }
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
  RigOptions* rig = &arguments->rig;
  CLI::Option* cameras =
      command->add_option("--cameras", rig->cameras, "Cameras that take masks, all around")
          ->capture_default_str();
  command->add_option("--mask-size", rig->size, "Pixels of each side of a mask")
      ->capture_default_str()
      ->needs(cameras);
  command->add_option("--masks-every", rig->every, "Masks of every so many frames")
      ->capture_default_str()
      ->needs(cameras);
  command->add_option("--camera-error", rig->error, "Pixels that each camera's calibration is off")
      ->capture_default_str()
      ->needs(cameras);
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
