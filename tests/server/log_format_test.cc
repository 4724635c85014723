#include "server/log_format.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/logger.h>
#include <spdlog/sinks/ostream_sink.h>

#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "server/transport/log_event.h"

namespace cagefit::server {
namespace {

using nlohmann::json;

const absl::Time kTime = absl::FromUnixMillis(1777863721123);

// As one line of JSON, which must be one and valid.
json Parsed(const std::string& event) {
  const std::string line = JsonLine(kTime, "info", event);
  EXPECT_EQ(line.find_first_of("\r\n"), std::string::npos) << line;
  json parsed = json::parse(line, nullptr, /*allow_exceptions=*/false);
  EXPECT_TRUE(parsed.is_object()) << line;
  return parsed;
}

TEST(LogFormatTest, ALineHasTimeLevelAndFields) {
  const std::string event = LogEvent("frame").Add("session", "ab12").AddInteger("frame", 7).text();
  EXPECT_EQ(TextLine(kTime, "info", event),
            "2026-05-04T03:02:01.123Z info frame session=ab12 frame=7");
  EXPECT_EQ(JsonLine(kTime, "info", event),
            R"({"time":"2026-05-04T03:02:01.123Z","level":"info","event":"frame",)"
            R"("session":"ab12","frame":7})");
}

TEST(LogFormatTest, HostileTextComesBackFromJsonAsItWas) {
  for (const std::string& text : std::initializer_list<std::string>{"plain",
                                                                    "",
                                                                    " ",
                                                                    "\"",
                                                                    "\\",
                                                                    "\\\"",
                                                                    "a\nb\r\n",
                                                                    "x\" level=\"error",
                                                                    "}",
                                                                    "{\"a\":1}",
                                                                    "\x01\x1b[31m\x7f",
                                                                    std::string("nul\0nul", 7),
                                                                    "\xc3\xa4\xe2\x82\xac",
                                                                    "12",
                                                                    "1e5",
                                                                    "true",
                                                                    "null",
                                                                    "[1]",
                                                                    "66cb6ecb",
                                                                    "0x1f",
                                                                    "a=b c=d",
                                                                    "\t",
                                                                    "'"}) {
    const json line = Parsed(LogEvent("call").Add("message", text).AddInteger("n", 1).text());
    EXPECT_EQ(line["message"], text);
    EXPECT_EQ(line["n"], 1);
    EXPECT_EQ(line.size(), 5u) << line;
  }
}

TEST(LogFormatTest, BytesThatAreNoTextAreReplacedInJson) {
  EXPECT_EQ(Parsed(LogEvent("call").Add("message", "a\xff").text())["message"], "a\xef\xbf\xbd");
}

TEST(LogFormatTest, TextStaysOnOneLineOfPlainCharacters) {
  EXPECT_EQ(TextLine(kTime, "info", "raw a=\n\x1b\xc3\xa4\""),
            "2026-05-04T03:02:01.123Z info raw a=\\n\\033\\303\\244\"");
}

TEST(LogFormatTest, NumbersAreNumbersAndTheRestIsText) {
  const json line = Parsed("e a=1 b=-2.5e3 c=1x d=0x1 e=nan f=01 g= h=true");
  EXPECT_EQ(line["a"], 1);
  EXPECT_EQ(line["b"], -2500.0);
  EXPECT_EQ(line["c"], "1x");
  EXPECT_EQ(line["d"], "0x1");
  EXPECT_EQ(line["e"], "nan");
  EXPECT_EQ(line["f"], "01");
  EXPECT_EQ(line["g"], "");
  EXPECT_EQ(line["h"], "true");
}

TEST(LogFormatTest, AnotherFormIsAMessage) {
  for (const std::string& text : std::initializer_list<std::string>{
           "Something went wrong", "two words", "e a=\"open", "e a=\"x\"y", "e  a=1", "e =1", "",
           " ", "e A=1", "e a=x\"y"}) {
    const json line = Parsed(text);
    EXPECT_EQ(line["event"], "message") << text;
    EXPECT_EQ(line["message"], text);
  }
}

TEST(LogFormatTest, AFieldCannotTakeTheTimesOrTheEventsPlace) {
  const json line = Parsed("e time=1 level=2 event=3 a=4 a=5");
  EXPECT_EQ(line["time"], "2026-05-04T03:02:01.123Z");
  EXPECT_EQ(line["level"], "info");
  EXPECT_EQ(line["event"], "e");
  EXPECT_EQ(line["a"], 4);
}

TEST(LogFormatTest, AnyBytesGiveOneValidLine) {
  std::mt19937 random(7);
  static constexpr char kLetters[] = "e a=\"\\01\n\xff {}:,\0nx";
  const std::string alphabet(kLetters, sizeof(kLetters) - 1);
  for (int k = 0; k < 20'000; ++k) {
    std::string event = "e a=";
    for (size_t size = random() % 12; size > 0; --size) {
      event += alphabet[random() % alphabet.size()];
    }
    Parsed(event);
    ASSERT_EQ(TextLine(kTime, "info", event).find('\n'), std::string::npos);
  }
}

TEST(LogFormatTest, ALoggerWritesWholeLines) {
  std::ostringstream out;
  spdlog::logger log("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(out));
  log.set_formatter(MakeFormatter(JsonLine));
  log.warn("first n={}", 1);
  log.info("second");
  std::istringstream lines(out.str());
  std::string line;
  ASSERT_TRUE(std::getline(lines, line));
  EXPECT_EQ(json::parse(line)["event"], "first");
  EXPECT_EQ(json::parse(line)["level"], "warning");
  ASSERT_TRUE(std::getline(lines, line));
  EXPECT_EQ(json::parse(line)["event"], "second");
}

}  // namespace
}  // namespace cagefit::server
