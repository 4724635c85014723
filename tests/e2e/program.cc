#include "tests/e2e/program.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "absl/strings/str_cat.h"

namespace cagefit::testing {
namespace {

// Standard output and error go to these descriptors; -1: inherited.
pid_t Spawn(const std::string& program, const std::vector<std::string>& arguments,
            const std::vector<std::string>& environment, int out, int err) {
  std::vector<std::string> words = {program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv, envp;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::vector<std::string> variables = environment;
  for (char** entry = environ; *entry != nullptr; ++entry) variables.emplace_back(*entry);
  for (std::string& variable : variables) envp.push_back(variable.data());
  envp.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (out >= 0) posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO);
  if (err >= 0) posix_spawn_file_actions_adddup2(&actions, err, STDERR_FILENO);
  pid_t pid = -1;
  const int error = posix_spawn(&pid, program.c_str(), &actions, nullptr, argv.data(), envp.data());
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::runtime_error(program + ": " + std::strerror(error));
  return pid;
}

int ExitCode(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : -1; }

std::string UniqueFile(const std::string& name) {
  static std::atomic<int> count{0};
  return ::testing::TempDir() + "/" + name + "." + std::to_string(getpid()) + "." +
         std::to_string(count++);
}

}  // namespace

ProgramResult RunCagefit(const std::vector<std::string>& arguments,
                         const std::vector<std::string>& environment) {
  const std::string out = UniqueFile("out"), err = UniqueFile("err");
  const int out_file = open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  const int err_file = open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  const pid_t pid = Spawn(CAGEFIT_PROGRAM, arguments, environment, out_file, err_file);
  close(out_file);
  close(err_file);
  int status = 0;
  waitpid(pid, &status, 0);
  ProgramResult result = {ExitCode(status), ReadText(out), ReadText(err)};
  std::filesystem::remove(out);
  std::filesystem::remove(err);
  return result;
}

std::string CagefitProgram() { return CAGEFIT_PROGRAM; }

RunningProgram::RunningProgram(const std::string& program,
                               const std::vector<std::string>& arguments) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("pipe");
  pid_ = Spawn(program, arguments, {}, ends[1], -1);
  close(ends[1]);
  out_ = ends[0];
}

RunningProgram::~RunningProgram() {
  if (pid_ > 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  close(out_);
}

std::string RunningProgram::ReadLine() {
  std::string line;
  char c = 0;
  while (read(out_, &c, 1) == 1 && c != '\n') line.push_back(c);
  return line;
}

void RunningProgram::Signal(int signal) const { kill(pid_, signal); }

int RunningProgram::Wait() {
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  return ExitCode(status);
}

int64_t RunningProgram::PeakMiB() const {
  std::ifstream lines("/proc/" + std::to_string(pid_) + "/status");
  std::string word;
  int64_t kib = 0;
  while (lines >> word && word != "VmHWM:") {
  }
  lines >> kib;
  return kib / 1024;
}

double RunningProgram::CpuSeconds() const {
  clockid_t clock;
  timespec time = {};
  if (clock_getcpuclockid(pid_, &clock) == 0) clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

namespace {

// What is not among `arguments` is as tests want it.
std::vector<std::string> WithDefaults(const std::vector<std::string>& arguments) {
  std::vector<std::string> all = arguments;
  const std::pair<std::string, std::string> defaults[] = {
      {"--listen", "127.0.0.1:0"}, {"--log-level", "warning"}, {"--store", "memory"}};
  for (const auto& [flag, value] : defaults) {
    const bool is_given = std::any_of(arguments.begin(), arguments.end(),
                                      [&flag = flag](const std::string& argument) {
                                        return argument.substr(0, argument.find('=')) == flag;
                                      });
    if (!is_given) all.insert(all.end(), {flag, value});
  }
  return all;
}

}  // namespace

ServerProgram::ServerProgram(const std::vector<std::string>& arguments)
    : program_(CAGEFITD_PROGRAM, WithDefaults(arguments)) {
  const std::string line = program_.ReadLine();
  address_ = line.substr(line.rfind(' ') + 1);
}

std::string EmptyFolder(const std::string& name) {
  const ::testing::TestInfo* test = ::testing::UnitTest::GetInstance()->current_test_info();
  const std::string folder = absl::StrCat(::testing::TempDir(), "cagefit/", test->test_suite_name(),
                                          ".", test->name(), "/", name);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

std::string ReadText(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

void WriteText(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

nlohmann::json ReadJson(const std::string& path) { return nlohmann::json::parse(ReadText(path)); }

}  // namespace cagefit::testing
