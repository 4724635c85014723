#include <Eigen/Geometry>
#include <cmath>
#include <set>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "client/io/camera_readers.h"
#include "client/io/text_line.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

constexpr size_t kNameColumn = 9;
constexpr double kUnitTolerance = 1e-2;  // of a quaternion's length, for files with few digits

absl::Status ReadPose(const TextLine& line, Camera* camera) {
  static constexpr absl::string_view kFields[] = {"QW", "QX", "QY", "QZ", "TX", "TY", "TZ"};
  double values[7];
  for (size_t k = 0; k < 7; ++k) {
    RETURN_IF_ERROR(line.ReadDouble(1 + k, kFields[k], &values[k]));
  }
  const Eigen::Quaterniond q(values[0], values[1], values[2], values[3]);
  if (!(std::abs(q.norm() - 1) < kUnitTolerance)) {
    return line.Wrong("the length of QW QX QY QZ", absl::StrCat(q.norm()), "1");
  }
  camera->R = q.normalized().toRotationMatrix();
  camera->t = Eigen::Vector3d(values[4], values[5], values[6]);
  return absl::OkStatus();
}

absl::StatusOr<Camera> ReadImage(const TextLine& line, const ColmapIntrinsics& intrinsics) {
  if (line.words.size() <= kNameColumn) {
    return BadLine(line.number, line.text, "IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME");
  }
  int64_t id = 0;
  RETURN_IF_ERROR(line.ReadInt(0, "IMAGE_ID", &id));
  RETURN_IF_ERROR(line.ReadInt(8, "CAMERA_ID", &id));
  const auto found = intrinsics.find(id);
  if (found == intrinsics.end()) {
    return line.Wrong("CAMERA_ID", line.words[8], "one of those in cameras.txt");
  }
  Camera camera = found->second;
  RETURN_IF_ERROR(ReadPose(line, &camera));
  const size_t name_at = static_cast<size_t>(line.words[kNameColumn].data() - line.text.data());
  camera.name = std::string(absl::StripTrailingAsciiWhitespace(line.text.substr(name_at)));
  if (const absl::Status status = camera.Validate(); !status.ok()) return line.Located(status);
  return camera;
}

// The line of points may be blank, and the last one missing. It is read, though not used, so that
// an image's line in its place is not lost.
absl::Status SkipPoints(TextCursor* cursor) {
  absl::string_view text;
  if (!cursor->NextLine(&text)) return absl::OkStatus();
  std::vector<absl::string_view> words;
  SplitWords(text, "", 0, &words);
  bool good = words.size() % 3 == 0;
  for (size_t k = 0; good && k < words.size(); ++k) {
    double value = 0;
    good = ParseDouble(words[k], &value);
  }
  if (good) return absl::OkStatus();
  return BadLine(cursor->line(), text, "the points of the image above: X Y POINT3D_ID, or nothing");
}

}  // namespace

absl::StatusOr<std::vector<Camera>> ReadColmapImages(absl::string_view bytes,
                                                     const ColmapIntrinsics& intrinsics) {
  std::vector<Camera> cameras;
  std::set<std::string> names;
  TextCursor cursor(bytes);
  TextLine line;
  while (line.Next(&cursor)) {
    ASSIGN_OR_RETURN(Camera camera, ReadImage(line, intrinsics));
    if (!names.insert(camera.name).second) {
      return line.Wrong("NAME", camera.name, "one that no image above it has");
    }
    cameras.push_back(std::move(camera));
    RETURN_IF_ERROR(SkipPoints(&cursor));
  }
  if (cameras.empty()) return absl::InvalidArgumentError("there are no images in it");
  return cameras;
}

}  // namespace cagefit::client
