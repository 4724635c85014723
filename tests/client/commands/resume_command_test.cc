#include "client/commands/resume_command.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "absl/strings/str_cat.h"

namespace cagefit::client {
namespace {

std::string WhatAShellReads(const std::string& command) {
  FILE* pipe = popen(command.c_str(), "r");
  std::string text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe))
    text.push_back(static_cast<char>(c));
  pclose(pipe);
  return text;
}

TEST(ResumeCommandTest, AShellReadsEveryWordAsItWas) {
  for (const std::string word : {"plain-1_2./:=,+@%", "", "two words", "it's", "$HOME `id` \"x\"",
                                 "a\nb", "*", "--name=it's", "~", "\\", "!x;&|<>(){}[]#"}) {
    EXPECT_EQ(WhatAShellReads(absl::StrCat("printf %s ", ShellQuoted(word))), word);
  }
}

TEST(ResumeCommandTest, LeavesPlainWordsBare) {
  EXPECT_EQ(Command({"cagefit", "fit", "a b/", "--out=x"}), "cagefit fit 'a b/' --out=x");
}

TEST(ResumeCommandTest, TheFlagReplacesWhatTheWordsSayOfIt) {
  EXPECT_EQ(CommandWith({"cagefit", "fit", "in"}, "--session", "7"), "cagefit fit in --session 7");
  EXPECT_EQ(CommandWith({"cagefit", "--session", "6", "fit", "in"}, "--session", "7"),
            "cagefit fit in --session 7");
  EXPECT_EQ(CommandWith({"cagefit", "fit", "--session=6", "in"}, "--session", "7"),
            "cagefit fit in --session 7");
  EXPECT_EQ(CommandWith({"cagefit", "--session-name", "6"}, "--session", "7"),
            "cagefit --session-name 6 --session 7");
}

}  // namespace
}  // namespace cagefit::client
