#include "tests/soak/verdict.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/fit_client.h"
#include "core/base/status.h"

namespace cagefit::testing {

absl::Status Judge(const History& history, const std::vector<std::string>& undisturbed) {
  constexpr size_t kMostSentences = 10;
  std::vector<std::string> broken = CheckHistory(history, undisturbed);
  if (broken.empty()) return absl::OkStatus();
  const size_t count = broken.size();
  broken.resize(std::min(count, kMostSentences));
  return absl::DataLossError(
      absl::StrCat(count, " broken promises:\n  ", absl::StrJoin(broken, "\n  ")));
}

absl::Status CheckStored(const std::string& session_id, uint64_t frames,
                         const std::string& address) {
  ASSIGN_OR_RETURN(const auto client, client::FitClient::Connect({address}));
  ASSIGN_OR_RETURN(const v1::Session session, client->GetSession(session_id));
  if (session.next_sequence_number() == frames && session.fitted_frames() == frames) {
    return absl::OkStatus();
  }
  return absl::DataLossError(absl::StrCat("the server has fitted ", session.fitted_frames(),
                                          " frames and goes on at ", session.next_sequence_number(),
                                          "; ", frames, " were answered"));
}

std::string ProgramBeside(const std::string& name) {
  std::error_code error;
  return (std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / name).string();
}

int Report(const absl::Status& status, int argc, const char* const* argv) {
  if (status.ok()) return EXIT_SUCCESS;
  std::cerr << "FAILED: " << status.ToString() << "\nreproduce: ";
  std::cerr << absl::StrJoin(argv, argv + argc, " ") << "\n";
  return EXIT_FAILURE;
}

}  // namespace cagefit::testing
