#include "client/commands/landmark_file.h"

#include <filesystem>
#include <limits>
#include <map>

#include "absl/strings/str_cat.h"
#include "client/io/file_bytes.h"
#include "client/io/text_line.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

constexpr int64_t kMaxFileBytes = int64_t{1} << 30;

absl::Status ReadIndex(const TextLine& line, size_t column, absl::string_view field,
                       int64_t* value) {
  RETURN_IF_ERROR(line.ReadInt(column, field, value));
  if (*value >= 0 && *value <= std::numeric_limits<int32_t>::max()) return absl::OkStatus();
  return line.Wrong(field, line.words[column], "0 to 2147483647");
}

absl::StatusOr<v1::Landmark> ReadLandmark(const TextLine& line) {
  const absl::string_view kind = line.words.size() > 1 ? line.words[1] : "";
  const bool on_surface = kind == "surface";
  if (!on_surface && kind != "vertex") {
    return line.Wrong("the second word", kind, "vertex or surface");
  }
  if (line.words.size() != (on_surface ? 8 : 6)) {
    return line.Wrong(
        "the number of words", absl::StrCat(line.words.size()),
        on_surface ? "8, FRAME surface TRIANGLE U V X Y Z" : "6, FRAME vertex INDEX X Y Z");
  }
  v1::Landmark landmark;
  int64_t index = 0;
  if (on_surface) {
    v1::SurfacePlace* place = landmark.mutable_surface();
    double u = 0, v = 0;
    RETURN_IF_ERROR(ReadIndex(line, 2, "the triangle", &index));
    RETURN_IF_ERROR(line.ReadDouble(3, "U", &u));
    RETURN_IF_ERROR(line.ReadDouble(4, "V", &v));
    place->set_triangle(static_cast<uint32_t>(index));
    place->set_u(u);
    place->set_v(v);
  } else {
    RETURN_IF_ERROR(ReadIndex(line, 2, "the vertex", &index));
    landmark.set_vertex(static_cast<uint32_t>(index));
  }
  const size_t x = line.words.size() - 3;
  double position[3];
  constexpr absl::string_view kFields[] = {"X", "Y", "Z"};
  for (size_t c = 0; c < 3; ++c) RETURN_IF_ERROR(line.ReadDouble(x + c, kFields[c], &position[c]));
  landmark.set_x(position[0]);
  landmark.set_y(position[1]);
  landmark.set_z(position[2]);
  return landmark;
}

absl::StatusOr<std::map<std::string, size_t, std::less<>>> FramesByName(
    const std::vector<std::string>& frames) {
  std::map<std::string, size_t, std::less<>> by_name;
  for (size_t k = 0; k < frames.size(); ++k) {
    const auto [other, is_new] =
        by_name.emplace(std::filesystem::path(frames[k]).stem().string(), k);
    if (is_new) continue;
    return absl::InvalidArgumentError(absl::StrCat(frames[k], ": has the name of ",
                                                   frames[other->second],
                                                   ", so its landmarks cannot be told apart"));
  }
  return by_name;
}

absl::Status Read(absl::string_view text, const std::vector<std::string>& frames,
                  std::vector<std::vector<v1::Landmark>>* landmarks) {
  ASSIGN_OR_RETURN(const auto frame_of_name, FramesByName(frames));
  TextCursor cursor(text);
  TextLine line;
  while (line.Next(&cursor)) {
    const auto frame = frame_of_name.find(line.words[0]);
    if (frame == frame_of_name.end()) {
      return line.Wrong("the frame", line.words[0], "the name of an input file without its ending");
    }
    ASSIGN_OR_RETURN(v1::Landmark landmark, ReadLandmark(line));
    (*landmarks)[frame->second].push_back(std::move(landmark));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<std::vector<v1::Landmark>>> ReadLandmarks(
    const std::string& path, const std::vector<std::string>& frames) {
  ASSIGN_OR_RETURN(const std::string text, ReadFileBytes(path, kMaxFileBytes));
  std::vector<std::vector<v1::Landmark>> landmarks(frames.size());
  const absl::Status read = Read(text, frames, &landmarks);
  if (!read.ok()) return absl::Status(read.code(), absl::StrCat(path, ": ", read.message()));
  return landmarks;
}

}  // namespace cagefit::client
