#include "server/http_port.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/time/clock.h"
#include "tests/server/http_get.h"

namespace cagefit::server {
namespace {

using testing::Dial;
using ::testing::HasSubstr;
using testing::HttpGet;
using testing::ReadToEnd;
using testing::Say;
using ::testing::StartsWith;

std::unique_ptr<HttpPort> OpenPage(std::string text) {
  return HttpPort::Open("127.0.0.1:0",
                        {"/page", "text/x", [text = std::move(text)] { return text; }})
      .value();
}

TEST(HttpPortTest, ServesOnePage) {
  const auto port = OpenPage("hello");
  EXPECT_EQ(HttpGet(port->address(), "/page"),
            "HTTP/1.1 200 OK\r\nContent-Type: text/x\r\nContent-Length: 5\r\n"
            "Connection: close\r\n\r\nhello");
  EXPECT_THAT(HttpGet(port->address(), "/page?x=1"), StartsWith("HTTP/1.1 200"));
}

TEST(HttpPortTest, ServesAPageThatIsLargerThanTheSocketsBuffer) {
  const std::string large(20 << 20, 'x');
  const auto port = OpenPage(large);
  EXPECT_THAT(HttpGet(port->address(), "/page").size(), ::testing::Gt(large.size()));
}

TEST(HttpPortTest, ServesNothingElse) {
  const auto port = OpenPage("hello");
  for (const char* path : {"/", "/pages", "/page/", "/../page", ""}) {
    EXPECT_THAT(HttpGet(port->address(), path), StartsWith("HTTP/1.1 404")) << path;
  }
  const int fd = Dial(port->address());
  ASSERT_TRUE(Say(fd, "POST /page HTTP/1.1\r\n\r\n"));
  EXPECT_THAT(ReadToEnd(fd), StartsWith("HTTP/1.1 405"));
  close(fd);
}

TEST(HttpPortTest, TakesARequestInParts) {
  const auto port = OpenPage("hello");
  const int fd = Dial(port->address());
  for (const char* part : {"GET /pa", "ge HTTP/1.1\r", "\nHost: x\r\n\r", "\n"}) {
    ASSERT_TRUE(Say(fd, part));
    EXPECT_THAT(HttpGet(port->address(), "/page"), HasSubstr("hello"));  // others do not wait
  }
  EXPECT_THAT(ReadToEnd(fd), HasSubstr("hello"));
  close(fd);
}

TEST(HttpPortTest, HangsUpOnARequestThatIsTooLong) {
  const auto port = OpenPage("hello");
  const int fd = Dial(port->address());
  Say(fd, "GET /page HTTP/1.1\r\nX: " + std::string(2 * HttpPort::kMaxRequestBytes, 'x'));
  EXPECT_EQ(ReadToEnd(fd), "");
  close(fd);
}

TEST(HttpPortTest, SilentClientsAreHungUpOnSoThatOthersGetTheirTurn) {
  const auto port = OpenPage("hello");
  std::vector<int> silent;
  for (size_t k = 0; k < HttpPort::kMaxConnections; ++k) silent.push_back(Dial(port->address()));
  EXPECT_THAT(HttpGet(port->address(), "/page"), HasSubstr("hello"));
  EXPECT_EQ(ReadToEnd(silent[0]), "");
  for (const int fd : silent) close(fd);
}

TEST(HttpPortTest, ASilentClientDoesNotHoldUpTheEnd) {
  auto port = OpenPage("hello");
  const int silent = Dial(port->address());
  const int half = Dial(port->address());
  ASSERT_TRUE(Say(half, "GET /pa"));
  HttpGet(port->address(), "/page");  // by now, both are connected
  const absl::Time start = absl::Now();
  port.reset();
  EXPECT_LT(absl::Now() - start, absl::Seconds(1));
  EXPECT_EQ(ReadToEnd(silent), "");
  close(silent);
  close(half);
}

TEST(HttpPortTest, NamesAnAddressThatItCannotListenOn) {
  const auto port = OpenPage("hello");
  const auto taken = HttpPort::Open(port->address(), {});
  EXPECT_TRUE(absl::IsUnavailable(taken.status())) << taken.status();
  EXPECT_THAT(std::string(taken.status().message()), HasSubstr(port->address()));
  EXPECT_TRUE(absl::IsUnavailable(HttpPort::Open("nobody.invalid:1", {}).status()));
  for (const char* bad :
       {"9090", ":9090", "127.0.0.1", "127.0.0.1:", "127.0.0.1:x", "a:65536", "a:-1"}) {
    const auto opened = HttpPort::Open(bad, {});
    EXPECT_TRUE(absl::IsInvalidArgument(opened.status())) << bad;
    EXPECT_THAT(std::string(opened.status().message()), HasSubstr(bad));
  }
}

TEST(HttpPortTest, TakesAName) {
  const auto port = HttpPort::Open("localhost:0", {"/page", "text/x", [] { return "hello"; }});
  ASSERT_TRUE(port.ok()) << port.status();
  EXPECT_THAT((*port)->address(), ::testing::MatchesRegex("localhost:[1-9][0-9]*"));
}

}  // namespace
}  // namespace cagefit::server
