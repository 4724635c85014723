#include "client/commands/fit_session.h"

#include <google/protobuf/util/message_differencer.h>

#include <filesystem>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace cagefit::client {

std::string EarlierMesh(const std::string& out, size_t frame) {
  while (frame-- > 0) {
    std::string path = absl::StrFormat("%s/frames/%04d.obj", out, frame);
    if (std::filesystem::exists(path)) return path;
  }
  return "";
}

absl::Status CheckSameOptions(const v1::SessionOptions& asked, const v1::SessionOptions& in_force) {
  v1::SessionOptions set = asked;
  set.mutable_fit()->clear_preset();
  set.clear_tolerance();
  set.clear_max_vertices();
  // What is set on top of what is in force must change nothing; of lists, a merge would make two.
  v1::SessionOptions merged = in_force;
  if (set.cameras_size() > 0) merged.clear_cameras();
  merged.MergeFrom(set);
  google::protobuf::util::MessageDifferencer differencer;
  std::string differences;
  differencer.ReportDifferencesToString(&differences);
  if (differencer.Compare(in_force, merged)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("the session has other options: ", absl::StripAsciiWhitespace(differences)));
}

}  // namespace cagefit::client
