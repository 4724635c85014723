#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/io/camera_readers.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kQuotedBytes = 60;

using Field = std::pair<const char*, double Distortion::*>;
constexpr Field kDistortionFields[] = {{"k1", &Distortion::k1},
                                       {"k2", &Distortion::k2},
                                       {"p1", &Distortion::p1},
                                       {"p2", &Distortion::p2},
                                       {"k3", &Distortion::k3}};

// A value for a message. Only what is flat is written out: nlohmann's dump() recurses.
std::string Quoted(const Json& value) {
  if (value.is_array()) return absl::StrCat("an array of ", value.size());
  if (value.is_object()) return "an object";
  const std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  return text.size() > kQuotedBytes ? text.substr(0, kQuotedBytes) + "..." : text;
}

// Parses, and finds fields that an object has twice, of which the parser keeps the last.
absl::StatusOr<Json> Parse(absl::string_view bytes) {
  std::vector<std::set<std::string>> open;  // fields of the objects around
  std::string twice;
  const auto callback = [&](int, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::object_start) open.emplace_back();
    if (event == Json::parse_event_t::object_end) open.pop_back();
    if (event == Json::parse_event_t::key &&
        !open.back().insert(parsed.get<std::string>()).second) {
      if (twice.empty()) twice = Quoted(parsed);
    }
    return true;
  };
  try {
    Json json = Json::parse(bytes.begin(), bytes.end(), callback);
    if (twice.empty()) return json;
  } catch (const Json::exception& error) {
    absl::string_view what = error.what();  // "[json.exception.NAME.NUMBER] ..."
    if (const size_t end = what.find("] "); end != what.npos) what.remove_prefix(end + 2);
    return absl::InvalidArgumentError(what);
  }
  return absl::InvalidArgumentError(absl::StrCat("an object has the field ", twice, " twice"));
}

// Fields of one object; errors start with what the object is.
class Fields {
 public:
  Fields(std::string owner, const Json& json) : owner_(std::move(owner)), json_(json) {}

  absl::Status Wrong(absl::string_view field, const Json& value, absl::string_view expected) const {
    return absl::InvalidArgumentError(
        absl::StrCat(owner_, ": ", field, " is ", Quoted(value), "; expected ", expected));
  }

  absl::Status CheckKnown(const std::set<std::string>& known) const {
    for (const auto& [field, value] : json_.items()) {
      if (known.count(field) > 0) continue;
      return absl::InvalidArgumentError(absl::StrCat(owner_, ": there is no field ", Quoted(field),
                                                     " (its value is ", Quoted(value), ")"));
    }
    return absl::OkStatus();
  }

  absl::StatusOr<const Json*> Find(const char* field) const {
    const auto found = json_.find(field);
    if (found != json_.end()) return &*found;
    return absl::InvalidArgumentError(absl::StrCat(owner_, ": has no field \"", field, "\""));
  }

  absl::Status ReadPixels(const char* field, int* value) const {
    ASSIGN_OR_RETURN(const Json* json, Find(field));
    const double number = json->is_number() ? json->get<double>() : -1;
    // Camera::Validate has narrower bounds; these keep the conversion defined.
    if (!(number >= 0 && number <= std::numeric_limits<int>::max()) ||
        number != std::floor(number)) {
      return Wrong(field, *json, "a whole number of pixels");
    }
    *value = static_cast<int>(number);
    return absl::OkStatus();
  }

  absl::Status ReadNumbers(const std::string& field, const Json& json, int count,
                           double* values) const {
    const std::string expected = absl::StrCat("an array of ", count, " numbers");
    if (!json.is_array() || static_cast<int>(json.size()) != count) {
      return Wrong(field, json, expected);
    }
    for (int k = 0; k < count; ++k) {
      if (!json[k].is_number()) return Wrong(absl::StrCat(field, "[", k, "]"), json[k], "a number");
      values[k] = json[k].get<double>();
    }
    return absl::OkStatus();
  }

  absl::Status ReadMatrix(const char* field, Eigen::Matrix3d* matrix) const {
    ASSIGN_OR_RETURN(const Json* json, Find(field));
    if (!json->is_array() || json->size() != 3) return Wrong(field, *json, "3 rows of 3 numbers");
    for (int row = 0; row < 3; ++row) {
      double values[3];
      RETURN_IF_ERROR(ReadNumbers(absl::StrCat(field, "[", row, "]"), (*json)[row], 3, values));
      for (int column = 0; column < 3; ++column) (*matrix)(row, column) = values[column];
    }
    return absl::OkStatus();
  }

  const std::string& owner() const { return owner_; }

 private:
  std::string owner_;
  const Json& json_;
};

absl::Status TakeIntrinsics(const Fields& fields, Camera* camera) {
  Eigen::Matrix3d K;
  RETURN_IF_ERROR(fields.ReadMatrix("K", &K));
  constexpr int kConstants[][3] = {{0, 1, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {2, 2, 1}};
  for (const auto& [row, column, value] : kConstants) {
    if (K(row, column) == value) continue;
    return fields.Wrong(absl::StrCat("K[", row, "][", column, "]"), K(row, column),
                        absl::StrCat(value, ", as K is [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]"));
  }
  camera->fx = K(0, 0);
  camera->fy = K(1, 1);
  camera->cx = K(0, 2);
  camera->cy = K(1, 2);
  return absl::OkStatus();
}

absl::StatusOr<Distortion> ReadDistortion(const std::string& owner, const Json& json) {
  Distortion distortion;
  const Fields fields(owner, json);
  std::set<std::string> known;
  for (const auto& [name, member] : kDistortionFields) {
    known.insert(name);
    const auto found = json.find(name);
    if (found == json.end()) continue;
    if (!found->is_number()) return fields.Wrong(name, *found, "a number");
    distortion.*member = found->get<double>();
  }
  RETURN_IF_ERROR(fields.CheckKnown(known));
  return distortion;
}

absl::StatusOr<Camera> ReadCamera(size_t index, const Json& json) {
  const Fields unnamed(absl::StrCat("camera ", index, " (from 0)"), json);
  if (!json.is_object()) {
    return absl::InvalidArgumentError(
        absl::StrCat(unnamed.owner(), " is ", Quoted(json), "; expected an object"));
  }
  ASSIGN_OR_RETURN(const Json* name, unnamed.Find("name"));
  if (!name->is_string()) return unnamed.Wrong("name", *name, "a string");
  Camera camera;
  camera.name = name->get<std::string>();
  const Fields fields(absl::StrCat("camera ", Quoted(*name)), json);
  RETURN_IF_ERROR(fields.CheckKnown({"name", "width", "height", "K", "R", "t", "distortion"}));
  RETURN_IF_ERROR(fields.ReadPixels("width", &camera.width));
  RETURN_IF_ERROR(fields.ReadPixels("height", &camera.height));
  RETURN_IF_ERROR(TakeIntrinsics(fields, &camera));
  RETURN_IF_ERROR(fields.ReadMatrix("R", &camera.R));
  ASSIGN_OR_RETURN(const Json* t, fields.Find("t"));
  RETURN_IF_ERROR(fields.ReadNumbers("t", *t, 3, camera.t.data()));
  if (const auto distortion = json.find("distortion"); distortion != json.end()) {
    if (!distortion->is_object()) return fields.Wrong("distortion", *distortion, "an object");
    ASSIGN_OR_RETURN(camera.distortion,
                     ReadDistortion(absl::StrCat(fields.owner(), ", distortion"), *distortion));
  }
  RETURN_IF_ERROR(camera.Validate());
  return camera;
}

absl::Status CheckNames(const std::vector<Camera>& cameras) {
  std::set<std::string> names;
  for (const Camera& camera : cameras) {
    if (names.insert(camera.name).second) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("two cameras have the name ", Quoted(camera.name)));
  }
  return absl::OkStatus();
}

Json MatrixToJson(const Eigen::Matrix3d& M) {
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row) rows.push_back({M(row, 0), M(row, 1), M(row, 2)});
  return rows;
}

Json CameraToJson(const Camera& camera) {
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  K(0, 0) = camera.fx;
  K(1, 1) = camera.fy;
  K(0, 2) = camera.cx;
  K(1, 2) = camera.cy;
  Json json = {{"name", camera.name},         {"width", camera.width},
               {"height", camera.height},     {"K", MatrixToJson(K)},
               {"R", MatrixToJson(camera.R)}, {"t", {camera.t[0], camera.t[1], camera.t[2]}}};
  if (camera.distortion.is_zero()) return json;
  for (const auto& [name, member] : kDistortionFields) {
    json["distortion"][name] = camera.distortion.*member;
  }
  return json;
}

}  // namespace

absl::StatusOr<std::vector<Camera>> ReadCamerasJson(absl::string_view bytes) {
  ASSIGN_OR_RETURN(const Json json, Parse(bytes));
  const Fields fields("the file", json);
  if (!json.is_object()) return absl::InvalidArgumentError("the file is no JSON object");
  RETURN_IF_ERROR(fields.CheckKnown({"cameras"}));
  ASSIGN_OR_RETURN(const Json* list, fields.Find("cameras"));
  if (!list->is_array() || list->empty()) {
    return fields.Wrong("\"cameras\"", *list, "an array of cameras");
  }
  std::vector<Camera> cameras;
  for (const Json& item : *list) {
    ASSIGN_OR_RETURN(Camera camera, ReadCamera(cameras.size(), item));
    cameras.push_back(std::move(camera));
  }
  RETURN_IF_ERROR(CheckNames(cameras));
  return cameras;
}

absl::StatusOr<std::string> CamerasToJson(const std::vector<Camera>& cameras) {
  if (cameras.empty()) return absl::InvalidArgumentError("there are no cameras to write");
  RETURN_IF_ERROR(CheckNames(cameras));
  std::string text = "{\"cameras\": [";
  for (const Camera& camera : cameras) {
    RETURN_IF_ERROR(camera.Validate());
    try {
      absl::StrAppend(&text, &camera == &cameras.front() ? "\n  " : ",\n  ",
                      CameraToJson(camera).dump());
    } catch (const Json::exception&) {
      return absl::InvalidArgumentError(
          absl::StrCat("the name ", Quoted(camera.name), " of a camera is not UTF-8"));
    }
  }
  return text + "\n]}\n";
}

}  // namespace cagefit::client
