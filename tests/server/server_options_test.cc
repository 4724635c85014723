#include "server/server_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "core/base/private_folder.h"

namespace cagefit::server {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class ServerOptionsTest : public ::testing::Test {
 protected:
  ~ServerOptionsTest() override {
    for (const std::string& name : set_) unsetenv(name.c_str());
  }

  void SetVariable(const std::string& name, const std::string& value) {
    setenv(name.c_str(), value.c_str(), 1);
    set_.push_back(name);
  }
  std::string WriteFile(const std::string& text) {
    const std::string path = folder_.path() + "/settings";
    std::ofstream(path) << text;
    return path;
  }
  ParsedServerOptions Parse(std::vector<std::string> arguments) {
    std::vector<const char*> argv = {"cagefitd"};
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    ::testing::internal::CaptureStderr();
    ::testing::internal::CaptureStdout();
    ParsedServerOptions parsed = ParseServerOptions(static_cast<int>(argv.size()), argv.data());
    errors_ = ::testing::internal::GetCapturedStderr();
    output_ = ::testing::internal::GetCapturedStdout();
    return parsed;
  }
  ServerOptions ParseGood(const std::vector<std::string>& arguments) {
    const ParsedServerOptions parsed = Parse(arguments);
    EXPECT_EQ(parsed.exit_code, std::nullopt) << errors_;
    return parsed.options;
  }
  void ExpectRefused(const std::vector<std::string>& arguments, const std::string& a,
                     const std::string& b = "") {
    EXPECT_EQ(Parse(arguments).exit_code, 2);
    EXPECT_THAT(errors_, AllOf(HasSubstr(a), HasSubstr(b)));
    EXPECT_EQ(output_, "");
  }

  static std::string WithoutComments(const std::string& text) {
    std::istringstream lines(text);
    std::string kept;
    for (std::string line; std::getline(lines, line);) {
      if (line[0] != '#') kept += line + "\n";
    }
    return kept;
  }

  PrivateFolder folder_ = PrivateFolder::Create().value();
  std::vector<std::string> set_;
  std::string errors_, output_;
};

TEST_F(ServerOptionsTest, DefaultsAreValid) {
  EXPECT_EQ(ServerOptions().Validate(), absl::OkStatus());
  const ServerOptions options = ParseGood({});
  EXPECT_EQ(options.listen, ServerOptions().listen);
  EXPECT_EQ(options.max_points, ServerOptions().max_points);
}

TEST_F(ServerOptionsTest, MemoryIsThatOfTheMachineOrEnoughToStartWith) {
  EXPECT_EQ(ParseGood({"--max-memory=0"}).max_memory_mib, 0);
  ExpectRefused({"--max-memory=255"}, "--max-memory is 255", "256 to 1048576");
}

TEST_F(ServerOptionsTest, EveryFlagArrives) {
  const ServerOptions o = ParseGood({"--listen=a:1",
                                     "--template-program=/p",
                                     "--template-memory-mib=65",
                                     "--template-seconds=1.5",
                                     "--max-frame-mib=2",
                                     "--max-points=17",
                                     "--max-control-vertices=5",
                                     "--max-sessions=3",
                                     "--max-frames=4",
                                     "--max-history-mib=6",
                                     "--max-streams=7",
                                     "--max-buffered-mib=8",
                                     "--max-memory=300",
                                     "--threads=9",
                                     "--fits=10",
                                     "--store=sqlite:/s",
                                     "--session-ttl-seconds=11",
                                     "--drain-seconds=0.5",
                                     "--log-level=trace",
                                     "--drain-delay=1.5",
                                     "--health-listen=b:2",
                                     "--metrics-listen=c:3",
                                     "--log-format=json",
                                     "--tls-cert=/c",
                                     "--tls-key=/k",
                                     "--tls-client-ca=/r",
                                     "--tokens=/t",
                                     "--reflection"});
  EXPECT_THAT(o.listen, ElementsAre("a:1"));
  EXPECT_EQ(o.template_program, "/p");
  EXPECT_EQ(o.template_memory_mib, 65);
  EXPECT_EQ(o.template_seconds, 1.5);
  EXPECT_EQ(o.max_frame_mib, 2);
  EXPECT_EQ(o.max_points, 17);
  EXPECT_EQ(o.max_control_vertices, 5);
  EXPECT_EQ(o.max_sessions, 3);
  EXPECT_EQ(o.max_frames, 4);
  EXPECT_EQ(o.max_history_mib, 6);
  EXPECT_EQ(o.max_streams, 7);
  EXPECT_EQ(o.max_buffered_mib, 8);
  EXPECT_EQ(o.max_memory_mib, 300);
  EXPECT_EQ(o.threads, 9);
  EXPECT_EQ(o.fits, 10);
  EXPECT_EQ(o.store, "sqlite:/s");
  EXPECT_EQ(o.session_ttl_seconds, 11);
  EXPECT_EQ(o.drain_seconds, 0.5);
  EXPECT_EQ(o.log_level, "trace");
  EXPECT_EQ(o.drain_delay, 1.5);
  EXPECT_EQ(o.health_listen, "b:2");
  EXPECT_EQ(o.metrics_listen, "c:3");
  EXPECT_EQ(o.log_format, "json");
  EXPECT_EQ(o.tls_cert, "/c");
  EXPECT_EQ(o.tls_key, "/k");
  EXPECT_EQ(o.tls_client_ca, "/r");
  EXPECT_EQ(o.tokens, "/t");
  EXPECT_TRUE(o.reflection);
}

TEST_F(ServerOptionsTest, KeepsSessionsInTheFolderForProgramData) {
  SetVariable("XDG_STATE_HOME", "/x");
  EXPECT_EQ(ParseGood({}).store, "sqlite:/x/cagefit/sessions.db");
  SetVariable("STATE_DIRECTORY", "/s");
  EXPECT_EQ(ParseGood({}).store, "sqlite:/s/sessions.db");
  EXPECT_EQ(ParseGood({"--store=memory"}).store, "memory");
}

TEST_F(ServerOptionsTest, FlagsCountMoreThanVariablesAndTheseMoreThanTheFile) {
  const std::string file = WriteFile("max-points=100\nmax-sessions=100\nmax-frames=100\n");
  SetVariable("CAGEFITD_MAX_POINTS", "200");
  SetVariable("CAGEFITD_MAX_SESSIONS", "200");
  const ServerOptions options = ParseGood({"--config", file, "--max-points", "300"});
  EXPECT_EQ(options.max_points, 300);
  EXPECT_EQ(options.max_sessions, 200);
  EXPECT_EQ(options.max_frames, 100);
  EXPECT_EQ(options.max_streams, ServerOptions().max_streams);
}

TEST_F(ServerOptionsTest, AVariableMayNameTheFile) {
  SetVariable("CAGEFITD_CONFIG", WriteFile("max-points=100\n"));
  EXPECT_EQ(ParseGood({}).max_points, 100);
}

TEST_F(ServerOptionsTest, ListensOnSeveralAddresses) {
  EXPECT_THAT(ParseGood({"--listen", "a:1", "--listen", "unix:/b"}).listen,
              ElementsAre("a:1", "unix:/b"));
  SetVariable("CAGEFITD_LISTEN", "c:2,d:3");
  EXPECT_THAT(ParseGood({}).listen, ElementsAre("c:2", "d:3"));
  EXPECT_THAT(ParseGood({"--listen=a:1"}).listen, ElementsAre("a:1"));
}

TEST_F(ServerOptionsTest, AVariableWithACommaIsOneValueWhereThereIsNoList) {
  SetVariable("CAGEFITD_TEMPLATE_PROGRAM", "/a,b");
  EXPECT_EQ(ParseGood({}).template_program, "/a,b");
}

TEST_F(ServerOptionsTest, AnUnknownVariableIsAnErrorWithASuggestion) {
  SetVariable("CAGEFITD_MAX_POINT", "200");
  ExpectRefused({}, "CAGEFITD_MAX_POINT", "did you mean CAGEFITD_MAX_POINTS?");
}

TEST_F(ServerOptionsTest, AnEmptyVariableIsAnEmptyValue) {
  SetVariable("CAGEFITD_HEALTH_LISTEN", "");
  EXPECT_EQ(ParseGood({"--max-points=100"}).max_points, 100);
  SetVariable("CAGEFITD_MAX_FRAMES", "");
  ExpectRefused({}, "max-frames");
}

TEST_F(ServerOptionsTest, AnUnknownFlagIsAnErrorWithASuggestion) {
  ExpectRefused({"--no-such-thing"}, "no option is called --no-such-thing\n");
  ExpectRefused({"--max-pionts=200"}, "--max-pionts; did you mean --max-points?");
  ExpectRefused({"stray"}, "stray");
}

TEST_F(ServerOptionsTest, AnUnknownNameInTheFileIsAnErrorWithItsLineAndASuggestion) {
  ExpectRefused({"--config", WriteFile("# first\nmax-points=100\nmax-frame=1\n")},
                "settings, line 3: no setting is called max-frame", "did you mean max-frames?");
  for (const char* name : {"help", "version", "config", "print-config", "no-such-thing"}) {
    ExpectRefused({"--config", WriteFile(std::string(name) + "=1\n")},
                  std::string("no setting is called ") + name);
  }
}

TEST_F(ServerOptionsTest, AVariableCannotAskForHelp) {
  for (const char* name : {"CAGEFITD_HELP", "CAGEFITD_VERSION", "CAGEFITD_PRINT_CONFIG"}) {
    SetVariable(name, "true");
    ExpectRefused({}, name);
    unsetenv(name);
  }
}

TEST_F(ServerOptionsTest, AFileHasListsLineByLineAndOtherSettingsOnce) {
  EXPECT_THAT(ParseGood({"--config", WriteFile("listen=[::1]:1\nlisten=unix:/b\n")}).listen,
              ElementsAre("[::1]:1", "unix:/b"));
  ExpectRefused({"--config", WriteFile("max-points=100\nmax-points=200\n")}, "line 2",
                "max-points is set twice");
}

TEST_F(ServerOptionsTest, AFileOfAnotherFormIsAnErrorWithItsLine) {
  ExpectRefused({"--config", WriteFile("\nmax-points 100\n")}, "settings, line 2",
                "expected name=value");
  ExpectRefused({"--config", folder_.path()}, "cannot be read");
}

TEST_F(ServerOptionsTest, PrintsWhatIsInForceAndWhereItComesFrom) {
  const std::string file = WriteFile("max-frames=100\nmax-points=100\n");
  SetVariable("CAGEFITD_MAX_SESSIONS", "200");
  EXPECT_EQ(Parse({"--print-config", "--config", file, "--max-points", "300"}).exit_code, 0);
  EXPECT_EQ(errors_, "");
  EXPECT_THAT(output_, HasSubstr("# flag\nmax-points=300\n"));
  EXPECT_THAT(output_, HasSubstr("# variable CAGEFITD_MAX_SESSIONS\nmax-sessions=200\n"));
  EXPECT_THAT(output_, HasSubstr("# " + file + ", line 1\nmax-frames=100\n"));
  EXPECT_THAT(output_, HasSubstr("# default\nlisten=127.0.0.1:50051\n"));
  ExpectRefused({"--print-config", "--max-points=1"}, "max-points is 1");
}

TEST_F(ServerOptionsTest, WhatItPrintsGivesTheSameOptionsAgain) {
  const std::vector<std::vector<std::string>> cases = {
      {},
      {"--listen=[::1]:0", "--listen=unix:/a b #c", "--template-program= \"x\\\n#,;=y' ",
       "--template-seconds=0x1.8p1", "--drain-seconds=0.25", "--log-level=off", "--threads=3"},
      {"--template-program=", "--health-listen=\xc3\xa4:1"}};
  for (const std::vector<std::string>& arguments : cases) {
    const ServerOptions before = ParseGood(arguments);
    std::vector<std::string> printing = arguments;
    printing.push_back("--print-config");
    ASSERT_EQ(Parse(printing).exit_code, 0) << errors_;
    const std::string printed = output_;
    const std::string file = WriteFile(printed);
    const ServerOptions after = ParseGood({"--config", file});
    EXPECT_EQ(after.listen, before.listen);
    EXPECT_EQ(after.template_program, before.template_program);
    EXPECT_EQ(after.template_seconds, before.template_seconds);
    EXPECT_EQ(after.drain_seconds, before.drain_seconds);
    EXPECT_EQ(after.health_listen, before.health_listen);
    EXPECT_EQ(after.log_level, before.log_level);
    EXPECT_EQ(after.threads, before.threads);
    // All of them: printed once more, only the sources differ.
    ASSERT_EQ(Parse({"--print-config", "--config", file}).exit_code, 0);
    EXPECT_EQ(WithoutComments(output_), WithoutComments(printed));
  }
}

TEST_F(ServerOptionsTest, AMissingFileIsAnError) {
  ExpectRefused({"--config", folder_.path() + "/none"}, "none");
}

TEST_F(ServerOptionsTest, ABadValueNamesFieldValueAndRange) {
  ExpectRefused({"--max-points=15"}, "--max-points is 15", "16 to 100000000");
  ExpectRefused({"--max-points=100000001"}, "--max-points is 100000001", "16 to 100000000");
  ExpectRefused({"--template-seconds=0.5"}, "--template-seconds is 0.5", "1 to 86400");
  ExpectRefused({"--threads=-1"}, "--threads is -1", "0 to 1024");
  ExpectRefused({"--store=disk"}, "--store is disk", "memory, sqlite:PATH or postgres:URL");
  ExpectRefused({"--store=postgres://a:secret@b/c"}, "--store is postgres:", "PGPASSWORD");
  ExpectRefused({"--session-ttl-seconds=-1"}, "--session-ttl-seconds is -1", "0 to 1000000000");
  ExpectRefused({"--log-level=loud"}, "--log-level is loud", "trace, debug");
  ExpectRefused({"--max-points=many"}, "max-points", "many");
}

TEST_F(ServerOptionsTest, ABadVariableNamesItToo) {
  SetVariable("CAGEFITD_MAX_POINTS", "15");
  ExpectRefused({}, "max-points is 15");
}

TEST_F(ServerOptionsTest, HalfOfTlsIsAnErrorThatNamesTheOtherHalf) {
  ExpectRefused({"--tls-cert=/c"}, "--tls-key is not set");
  ExpectRefused({"--tls-key=/k"}, "--tls-cert is not set");
  ExpectRefused({"--tls-client-ca=/r"}, "--tls-cert is not set", "--tls-client-ca");
}

TEST_F(ServerOptionsTest, NaNIsOutOfEveryRange) {
  ServerOptions options;
  options.drain_seconds = std::nan("");
  EXPECT_TRUE(absl::IsInvalidArgument(options.Validate()));
}

TEST_F(ServerOptionsTest, NoAddressIsAnError) {
  ServerOptions options;
  options.listen.clear();
  EXPECT_THAT(std::string(options.Validate().message()), HasSubstr("--listen"));
}

TEST_F(ServerOptionsTest, HelpAndVersionEndWithSuccessOnStandardOutput) {
  EXPECT_EQ(Parse({"--help"}).exit_code, 0);
  EXPECT_THAT(output_, AllOf(HasSubstr("--max-points"), HasSubstr("CAGEFITD_MAX_POINTS")));
  EXPECT_EQ(Parse({"--version"}).exit_code, 0);
  EXPECT_THAT(output_, HasSubstr("cagefitd "));
  EXPECT_EQ(errors_, "");
}

}  // namespace
}  // namespace cagefit::server
