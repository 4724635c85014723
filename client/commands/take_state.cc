#include "client/commands/take_state.h"

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "client/commands/message_json.h"
#include "client/io/file_bytes.h"

namespace cagefit::client {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kMostBytes = int64_t{1} << 28;

// [name, bytes, nanoseconds]; of a folder, its files.
Json StampOf(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    std::vector<std::string> inside;
    for (const auto& entry : fs::recursive_directory_iterator(path, error)) {
      if (!entry.is_directory(error)) inside.push_back(entry.path().string());
    }
    std::sort(inside.begin(), inside.end());
    Json json = Json::array();
    for (const std::string& file : inside) json.push_back(StampOf(file));
    return json;
  }
  const auto size = static_cast<int64_t>(fs::file_size(path, error));
  const fs::file_time_type time = fs::last_write_time(path, error);
  return {path, size, std::chrono::nanoseconds(time.time_since_epoch()).count()};
}

Json StampsOf(const std::vector<std::string>& paths) {
  Json json = Json::array();
  for (const std::string& path : paths) {
    if (!path.empty()) json.push_back(StampOf(path));
  }
  return json;
}

}  // namespace

Json AskedOf(const FitArguments& a, const std::vector<std::string>& files) {
  std::vector<std::string> named = {a.cage, a.cameras, a.masks, a.landmarks};
  named.insert(named.end(), a.truth.begin(), a.truth.end());
  return {{"options", ToJson(a.options)},
          {"vertices", a.vertices},
          {"crease_angle", a.crease_angle.has_value() ? Json(*a.crease_angle) : Json()},
          {"position_bits", a.position_bits},
          {"from_frame", a.from_frame},
          {"to_frame", a.to_frame.has_value() ? Json(*a.to_frame) : Json()},
          {"round_trip", a.round_trip},
          {"latest", a.latest},
          {"quick", a.quick},
          {"report", a.report},
          {"formats", ToJson(a.formats)},
          {"named", StampsOf(named)},
          {"frames", StampsOf(files)}};
}

std::optional<TakeState> ReadTakeState(const std::string& path) {
  const auto text = ReadFileBytes(path, kMostBytes);
  if (!text.ok()) return std::nullopt;
  const Json json = Json::parse(*text, /*callback=*/nullptr, /*allow_exceptions=*/false);
  const auto is_text = [&](const char* key) { return json.contains(key) && json[key].is_string(); };
  if (!json.is_object() || !json.contains("asked") || !is_text("server") || !is_text("session")) {
    return std::nullopt;
  }
  TakeState state = {json["asked"], json["server"], json["session"], std::nullopt};
  if (json.contains("exit_code") && json["exit_code"].is_number_integer()) {
    state.exit_code = json["exit_code"].get<int>();
  }
  return state;
}

absl::Status WriteTakeState(const std::string& path, const TakeState& state) {
  Json json = {{"server", state.server}, {"session", state.session}};
  if (state.exit_code.has_value()) json["exit_code"] = *state.exit_code;
  json["asked"] = state.asked;
  return WriteFileBytes(path, Text(json, 1));
}

}  // namespace cagefit::client
