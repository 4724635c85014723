#include <limits>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client/io/camera_readers.h"
#include "client/io/text_line.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

constexpr size_t kHeadWords = 4;      // CAMERA_ID MODEL WIDTH HEIGHT
constexpr double kPixelCenter = 0.5;  // of the first pixel in COLMAP's coordinates

// Parameters in COLMAP's order.
struct Model {
  absl::string_view name, parameters;
};
constexpr Model kModels[] = {
    {"SIMPLE_PINHOLE", "f cx cy"},         {"PINHOLE", "fx fy cx cy"},
    {"SIMPLE_RADIAL", "f cx cy k1"},       {"RADIAL", "f cx cy k1 k2"},
    {"OPENCV", "fx fy cx cy k1 k2 p1 p2"}, {"FULL_OPENCV", "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"}};

// Where a parameter goes; null for f, which goes to two places, and for k4 to k6, which none has.
double* Place(absl::string_view parameter, Camera* camera) {
  Distortion& lens = camera->distortion;
  const std::pair<absl::string_view, double*> places[] = {
      {"fx", &camera->fx}, {"fy", &camera->fy}, {"cx", &camera->cx},
      {"cy", &camera->cy}, {"k1", &lens.k1},    {"k2", &lens.k2},
      {"p1", &lens.p1},    {"p2", &lens.p2},    {"k3", &lens.k3}};
  for (const auto& [name, place] : places) {
    if (name == parameter) return place;
  }
  return nullptr;
}

absl::Status ReadPixels(const TextLine& line, size_t column, absl::string_view field, int* value) {
  int64_t number = 0;
  RETURN_IF_ERROR(line.ReadInt(column, field, &number));
  // Camera::Validate has narrower bounds; these keep the conversion defined.
  if (number < 0 || number > std::numeric_limits<int>::max()) {
    return line.Wrong(field, line.words[column], "a number of pixels");
  }
  *value = static_cast<int>(number);
  return absl::OkStatus();
}

absl::StatusOr<const Model*> FindModel(const TextLine& line) {
  std::string names;
  for (const Model& model : kModels) {
    if (model.name == line.words[1]) return &model;
    absl::StrAppend(&names, names.empty() ? "" : ", ", model.name);
  }
  return line.Wrong("MODEL", line.words[1], names);
}

absl::Status ReadParameters(const TextLine& line, const Model& model, Camera* camera) {
  const std::vector<absl::string_view> names = absl::StrSplit(model.parameters, ' ');
  if (line.words.size() != kHeadWords + names.size()) {
    return line.Wrong(absl::StrCat("the number of PARAMS of ", model.name),
                      absl::StrCat(line.words.size() - kHeadWords),
                      absl::StrCat(names.size(), ": ", model.parameters));
  }
  for (size_t k = 0; k < names.size(); ++k) {
    double value = 0;
    RETURN_IF_ERROR(line.ReadDouble(kHeadWords + k, names[k], &value));
    if (double* place = Place(names[k], camera); place != nullptr) {
      *place = value;
    } else if (names[k] == "f") {
      camera->fx = camera->fy = value;
    } else if (value != 0) {
      return line.Wrong(names[k], line.words[kHeadWords + k],
                        "0, as a lens with k4, k5 or k6 is not supported");
    }
  }
  camera->cx -= kPixelCenter;
  camera->cy -= kPixelCenter;
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ColmapIntrinsics> ReadColmapCameras(absl::string_view bytes) {
  ColmapIntrinsics all;
  TextCursor cursor(bytes);
  TextLine line;
  while (line.Next(&cursor)) {
    if (line.words.size() < kHeadWords) {
      return BadLine(line.number, line.text, "CAMERA_ID MODEL WIDTH HEIGHT PARAMS...");
    }
    int64_t id = 0;
    Camera camera;
    RETURN_IF_ERROR(line.ReadInt(0, "CAMERA_ID", &id));
    ASSIGN_OR_RETURN(const Model* model, FindModel(line));
    RETURN_IF_ERROR(ReadPixels(line, 2, "WIDTH", &camera.width));
    RETURN_IF_ERROR(ReadPixels(line, 3, "HEIGHT", &camera.height));
    RETURN_IF_ERROR(ReadParameters(line, *model, &camera));
    camera.name = absl::StrCat(id);  // for its errors only
    if (const absl::Status status = camera.Validate(); !status.ok()) return line.Located(status);
    camera.name.clear();
    if (!all.emplace(id, std::move(camera)).second) {
      return line.Wrong("CAMERA_ID", line.words[0], "one that no line above it has");
    }
  }
  if (all.empty()) return absl::InvalidArgumentError("there are no cameras in it");
  return all;
}

}  // namespace cagefit::client
