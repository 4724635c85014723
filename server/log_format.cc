#include "server/log_format.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"

namespace cagefit::server {
namespace {

using Json = nlohmann::ordered_json;

std::string TimeText(absl::Time time) {
  return absl::FormatTime("%Y-%m-%dT%H:%M:%E3SZ", time, absl::UTCTimeZone());
}

bool IsKey(absl::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return absl::ascii_islower(c) || absl::ascii_isdigit(c) || c == '_';
  });
}

// Takes the value that `rest` begins with: quoted, or up to a space. False when a quote is open.
bool TakeValue(absl::string_view* rest, Json* value) {
  if (rest->empty() || rest->front() != '"') {
    const absl::string_view word = rest->substr(0, rest->find(' '));
    rest->remove_prefix(word.size());
    const bool number =
        !word.empty() &&
        (word[0] == '-' || absl::ascii_isdigit(static_cast<unsigned char>(word[0]))) &&
        Json::accept(word.begin(), word.end());
    *value = number ? Json::parse(word.begin(), word.end()) : Json(std::string(word));
    return word.find('"') == absl::string_view::npos;
  }
  size_t end = 1;
  while (end < rest->size() && (*rest)[end] != '"') end += (*rest)[end] == '\\' ? 2 : 1;
  std::string text;
  if (end >= rest->size() || !absl::CUnescape(rest->substr(1, end - 1), &text)) return false;
  rest->remove_prefix(end + 1);
  *value = std::move(text);
  return true;
}

// The fields behind the event's word; false when there is something else.
bool TakeFields(absl::string_view rest, Json* line) {
  while (!rest.empty()) {
    if (rest.front() != ' ') return false;
    rest.remove_prefix(1);
    const size_t equals = rest.find('=');
    if (equals == absl::string_view::npos || !IsKey(rest.substr(0, equals))) return false;
    const std::string key(rest.substr(0, equals));
    rest.remove_prefix(equals + 1);
    Json value;
    if (!TakeValue(&rest, &value)) return false;
    line->emplace(key, std::move(value));  // the first of a name counts, `time` above all
  }
  return true;
}

class Formatter : public spdlog::formatter {
 public:
  explicit Formatter(FormatLine format) : format_(format) {}

  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& line) override {
    const auto level = spdlog::level::to_string_view(message.level);
    const std::string text = format_(absl::FromChrono(message.time), {level.data(), level.size()},
                                     {message.payload.data(), message.payload.size()}) +
                             "\n";
    line.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<spdlog::formatter> clone() const override { return MakeFormatter(format_); }

 private:
  const FormatLine format_;
};

}  // namespace

std::string TextLine(absl::Time time, absl::string_view level, absl::string_view event) {
  std::string escaped;
  for (const char c : event) {
    const bool plain = absl::ascii_isprint(static_cast<unsigned char>(c));
    absl::StrAppend(&escaped, plain ? std::string(1, c) : absl::CEscape(absl::string_view(&c, 1)));
  }
  return absl::StrCat(TimeText(time), " ", level, " ", escaped);
}

std::string JsonLine(absl::Time time, absl::string_view level, absl::string_view event) {
  const Json start = {{"time", TimeText(time)}, {"level", std::string(level)}};
  const absl::string_view word = event.substr(0, event.find(' '));
  Json line = start;
  line["event"] = std::string(word);
  if (!IsKey(word) || !TakeFields(event.substr(word.size()), &line)) {
    line = start;
    line["event"] = "message";
    line["message"] = std::string(event);
  }
  return line.dump(-1, ' ', /*ensure_ascii=*/false, Json::error_handler_t::replace);
}

std::unique_ptr<spdlog::formatter> MakeFormatter(FormatLine format) {
  return std::make_unique<Formatter>(format);
}

}  // namespace cagefit::server
