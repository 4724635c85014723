#include "client/commands/fit_takes.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "client/commands/command.h"
#include "client/commands/fit_run.h"
#include "client/commands/input_files.h"
#include "client/commands/interrupt.h"
#include "client/commands/take_state.h"
#include "client/io/file_bytes.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

namespace fs = std::filesystem;

std::string NameOf(const std::string& input) {
  fs::path path = fs::absolute(input).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();  // it ended with a slash
  return fs::is_directory(path) ? path.filename().string() : path.stem().string();
}

Take MakeTake(const FitArguments& all, const std::string& input) {
  Take take = {NameOf(input), all};
  FitArguments& a = take.arguments;
  a.inputs = {input};
  a.out = absl::StrCat(all.out, "/", take.name);
  for (std::string* path : {&a.cage, &a.cameras, &a.masks, &a.landmarks}) {
    *path = absl::StrReplaceAll(*path, {{"{take}", take.name}});
  }
  for (std::string& path : a.truth) path = absl::StrReplaceAll(path, {{"{take}", take.name}});
  return take;
}

void Say(const Take& take, const std::string& text) {
  std::cerr << "cagefit: take " << take.name << ": " << text << std::endl;
}

std::string StatePath(const Take& take) { return take.arguments.out + "/take.json"; }
std::string StorePath(const Take& take) { return take.arguments.out + "/session.db"; }

void RemoveStore(const Take& take) {
  std::error_code error;
  for (const char* end : {"", "-wal", "-shm"}) fs::remove(StorePath(take) + end, error);
}

// Prepares the arguments for the server that keeps the session; true when they name one that an
// earlier call has begun.
bool GoOnWithEarlier(const TakeState& asked, const std::optional<TakeState>& earlier, Take* take) {
  const bool is_same = earlier.has_value() && earlier->asked == asked.asked &&
                       earlier->server == asked.server && !earlier->session.empty();
  const bool is_inside = take->arguments.server.empty();
  if (is_inside && !(is_same && fs::exists(StorePath(*take)))) RemoveStore(*take);
  if (is_inside) take->arguments.store = "sqlite:" + StorePath(*take);
  if (is_same) take->arguments.session = earlier->session;
  return is_same;
}

void SayHowItWent(const Take& take, const FitReport& report) {
  const FitTotals totals = Totals(report);
  std::string text = absl::StrCat(totals.fitted, " of ", report.frames.size() - report.first_frame,
                                  " frames fitted");
  if (totals.fitted > 0) {
    absl::StrAppendFormat(&text, ", RMS %.4f %% on average, %.4f %% at worst; %.1f s",
                          totals.mean_rms_percent, totals.worst_rms_percent, totals.seconds);
  }
  Say(take, text);
}

void Print(const Take& take, const FitReport& report, int exit_code) {
  Json json = {{"take", take.name}, {"exit_code", exit_code}};
  json.update(ReportJson(report));
  json.erase("frames");
  std::cout << Text(json) << std::endl;
}

class TakeFit {
 public:
  TakeFit(Take take, Interrupt* interrupt) : take_(std::move(take)), interrupt_(interrupt) {}

  int Run() {
    auto input = OpenInput(take_.arguments);
    if (!input.ok()) {
      Say(take_, std::string(input.status().message()));
      return kWrongUsage;
    }
    const absl::Status made = MakeFolder(take_.arguments.out);
    if (!made.ok()) return Report(made);
    TakeState state = {AskedOf(take_.arguments, input->files), take_.arguments.server, "", {}};
    const std::optional<TakeState> earlier = ReadTakeState(StatePath(take_));
    if (earlier.has_value() && earlier->exit_code.has_value() && earlier->asked == state.asked) {
      Say(take_, "done before");
      return *earlier->exit_code;
    }
    const bool goes_on = GoOnWithEarlier(state, earlier, &take_);
    Say(take_, absl::StrCat(goes_on ? "goes on, " : "begins, ", input->files.size(), " frames"));
    FitEnd end = Fit(*input, &state);
    if (goes_on && !end.has_begun && absl::IsNotFound(end.failure)) {
      Say(take_, "its session is gone; it begins anew");
      take_.arguments.session.clear();
      end = Fit(*input, &state);
    }
    return end.exit_code;
  }

 private:
  FitEnd Fit(const FitInput& input, TakeState* state) {
    FitJob job(take_.arguments, input.files, /*follower=*/nullptr, input.truth, interrupt_);
    FitEnd end = RunFit(&job, [&](const std::string& session) {
      state->session = session;
      return WriteTakeState(StatePath(take_), *state);
    });
    if (!end.has_begun) {
      if (!absl::IsNotFound(end.failure)) Say(take_, std::string(end.failure.message()));
      return end;
    }
    SayHowItWent(take_, job.report());
    if (take_.arguments.json) Print(take_, job.report(), end.exit_code);
    if (!end.failure.ok()) {
      Say(take_,
          absl::StrCat(absl::IsCancelled(end.failure) ? "interrupted" : end.failure.message(),
                       "; the same command goes on with it"));
      return end;
    }
    SayWhatWasRefused(job.report());
    return Done(end, state);
  }

  // Every frame has its answer.
  FitEnd Done(FitEnd end, TakeState* state) {
    state->exit_code = end.exit_code;
    end.written = WriteTakeState(StatePath(take_), *state);
    if (!end.written.ok()) {
      Report(end.written);
      end.exit_code = kFailed;
    } else if (!take_.arguments.keep_session) {
      RemoveStore(take_);
    }
    return end;
  }

  Take take_;
  Interrupt* const interrupt_;
};

}  // namespace

absl::StatusOr<std::vector<Take>> ListTakes(const FitArguments& arguments) {
  std::vector<Take> takes;
  for (const std::string& input : arguments.inputs) {
    if (!fs::exists(input)) {
      return absl::NotFoundError(absl::StrCat(input, ": there is no such file or folder"));
    }
    takes.push_back(MakeTake(arguments, input));
  }
  std::sort(takes.begin(), takes.end(),
            [](const Take& a, const Take& b) { return NaturalLess(a.name, b.name); });
  std::vector<Take> chunk;
  for (size_t k = 0; k < takes.size(); ++k) {
    if (k > 0 && takes[k].name == takes[k - 1].name) {
      return absl::InvalidArgumentError(absl::StrCat("two takes have the name ", takes[k].name,
                                                     ": ", takes[k - 1].arguments.inputs.front(),
                                                     " and ", takes[k].arguments.inputs.front()));
    }
    if (k % arguments.chunks == arguments.chunk) chunk.push_back(takes[k]);
  }
  return chunk;
}

int FitTakes(const FitArguments& arguments) {
  const auto takes = ListTakes(arguments);
  if (!takes.ok()) {
    Report(takes.status());
    return kWrongUsage;
  }
  Interrupt interrupt;
  size_t done = 0;
  int last_failure = kDone;
  for (const Take& take : *takes) {
    if (interrupt.seen() || last_failure == kNoServer) break;
    const int exit_code = TakeFit(take, &interrupt).Run();
    if (exit_code == kDone) {
      ++done;
    } else {
      last_failure = exit_code;
    }
  }
  std::cerr << "cagefit: " << done << " of " << takes->size() << " takes are done"
            << (interrupt.seen() ? "; interrupted, the same command goes on" : "") << std::endl;
  if (done == takes->size()) return kDone;
  if (interrupt.seen()) return kPartlyDone;
  return done == 0 || last_failure == kNoServer ? last_failure : static_cast<int>(kPartlyDone);
}

}  // namespace cagefit::client
