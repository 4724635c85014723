// Tokens and certificates as a user makes and uses them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/e2e/program.h"
#include "tests/support/certificates.h"

namespace cagefit::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;

TEST(TokenProgramTest, ATokenOpensTheServerItsLineIsGivenTo) {
  const std::string folder = EmptyFolder("token");
  const std::string token_file = folder + "/north.token";
  const ProgramResult made =
      RunCagefit({"token", "north", "--out", token_file, "--sessions", "1", "--fits=2",
                  "--bytes-per-second", "100000000", "--expires", "2999-01-01T00:00:00Z"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_THAT(made.out, MatchesRegex("north [0-9a-f]{64} sessions=1 bytes-per-second=100000000 "
                                     "fits=2 expires=2999-01-01T00:00:00Z\n"));
  const std::string token = ReadText(token_file);
  EXPECT_THAT(token, MatchesRegex("cft_[A-Za-z0-9_-]{43}\n"));
  struct stat file = {};
  ASSERT_EQ(stat(token_file.c_str(), &file), 0);
  EXPECT_EQ(file.st_mode & 0777, 0600u);
  WriteText(folder + "/tokens", made.out);
  const ServerProgram server({"--tokens", folder + "/tokens"});

  const std::vector<std::string> list = {"session", "list", "--server", server.address()};
  const ProgramResult refused = RunCagefit(list);
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, HasSubstr("this server wants a valid token or certificate"));
  EXPECT_EQ(RunCagefit(list, {"CAGEFIT_TOKEN_FILE=" + token_file}).exit_code, 0);

  ASSERT_EQ(
      RunCagefit({"synth", "blob", "--out", folder, "--frames", "1", "--points", "500"}).exit_code,
      0);
  const ProgramResult fitted =
      RunCagefit({"fit", folder + "/frame_0000.drc", "--vertices", "100", "--out", folder + "/fit",
                  "--server", server.address(), "--token-file", token_file, "--keep-session"});
  EXPECT_EQ(fitted.exit_code, 0) << fitted.err;
  const std::string secret = token.substr(0, token.size() - 1);
  EXPECT_THAT(ReadText(folder + "/fit/report.json"), Not(HasSubstr(secret)));
  EXPECT_THAT(fitted.out + fitted.err, Not(HasSubstr(secret)));

  const ProgramResult second =
      RunCagefit({"fit", folder + "/frame_0000.drc", "--vertices", "100", "--out", folder + "/fit2",
                  "--server", server.address(), "--token-file", token_file});
  EXPECT_EQ(second.exit_code, 1);
  EXPECT_THAT(second.err, HasSubstr("sessions of north is 2; the limit is 1"));
}

TEST(TlsProgramTest, HealthIsAskedOfAPortWithTls) {
  const std::string folder = EmptyFolder("tls");
  CertificateAuthority authority("authority");
  const CertificateAndKey own = authority.Issue("server");
  WriteText(folder + "/ca.pem", authority.certificate());
  WriteText(folder + "/server.pem", own.certificate);
  WriteText(folder + "/server.key", own.key);
  const ServerProgram server(
      {"--tls-cert", folder + "/server.pem", "--tls-key", folder + "/server.key"});
  const std::vector<std::string> health = {"health", "--server", server.address(), "--timeout",
                                           "2"};
  EXPECT_EQ(RunCagefit(health).out, "no-server\n");
  EXPECT_EQ(RunCagefit(health, {"CAGEFIT_TLS_CA=" + folder + "/ca.pem"}).out, "serving\n");
}

TEST(TokenProgramTest, AFileThatIsThereIsNotOverwritten) {
  const std::string folder = EmptyFolder("token");
  WriteText(folder + "/file", "old");
  const ProgramResult result = RunCagefit({"token", "north", "--out", folder + "/file"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr(folder + "/file: cannot be written: File exists"));
  EXPECT_EQ(ReadText(folder + "/file"), "old");
}

TEST(TokenProgramTest, WrongUsageSaysWhatIsWrong) {
  const std::string folder = EmptyFolder("token");
  const std::string out = folder + "/file";
  const std::vector<std::pair<std::vector<std::string>, std::string>> wrong = {
      {{"token", "--out", out}, "NAME"},
      {{"token", "north"}, "--out"},
      {{"token", "no/rth", "--out", out}, "letters, digits"},
      {{"token", "north", "--out", out, "--fits", "0"}, "--fits"},
      {{"token", "north", "--out", out, "--expires", "soon"}, "2026-12-31T18:00:00Z"},
      {{"session", "list", "--token", "secret"}, "--token"}};
  for (const auto& [arguments, what] : wrong) {
    const ProgramResult result = RunCagefit(arguments);
    EXPECT_EQ(result.exit_code, 2) << ::testing::PrintToString(arguments);
    EXPECT_THAT(result.err, HasSubstr(what)) << ::testing::PrintToString(arguments);
  }
}

TEST(TokenProgramTest, ATokenIsNotSentToAnotherMachineForAllToRead) {
  const std::string folder = EmptyFolder("token");
  WriteText(folder + "/token", "cft_secret");
  const ProgramResult result = RunCagefit(
      {"session", "list", "--server", "rig.example:50051", "--token-file", folder + "/token"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, AllOf(HasSubstr("rig.example:50051 for all to read"), HasSubstr("--tls"),
                                Not(HasSubstr("cft_secret"))));
}

}  // namespace
}  // namespace cagefit::testing
