#include "client/commands/input_files.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/io/geometry_file.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

namespace fs = std::filesystem;

// The run of digits at `at`, without leading zeros; moves `at` behind it.
std::string TakeNumber(const std::string& text, size_t* at) {
  while (*at < text.size() && text[*at] == '0') ++*at;
  const size_t begin = *at;
  while (*at < text.size() && absl::ascii_isdigit(text[*at])) ++*at;
  return text.substr(begin, *at - begin);
}

absl::StatusOr<std::vector<std::string>> ListFolder(const std::string& folder) {
  std::vector<std::string> files;
  std::set<std::string> formats;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string path = entry.path().string();
    if (!IsGeometryFile(path) || entry.path().filename().string()[0] == '.') continue;
    formats.insert(FileExtension(path));
    files.push_back(path);
  }
  if (error) {
    return absl::UnknownError(absl::StrCat(folder, ": cannot be read: ", error.message()));
  }
  if (files.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(folder, ": no .ply, .obj, .stl, .off, .xyz, .pcd or .drc file in it"));
  }
  if (formats.size() > 1) {
    return absl::InvalidArgumentError(
        absl::StrCat(folder, ": files of several formats (", absl::StrJoin(formats, ", "),
                     "); name those of the sequence, as in ", folder, "/*", *formats.begin()));
  }
  std::sort(files.begin(), files.end(), NaturalLess);
  return files;
}

}  // namespace

bool NaturalLess(const std::string& a, const std::string& b) {
  size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (absl::ascii_isdigit(a[i]) && absl::ascii_isdigit(b[j])) {
      const std::string m = TakeNumber(a, &i), n = TakeNumber(b, &j);
      if (m.size() != n.size()) return m.size() < n.size();
      if (m != n) return m < n;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
    }
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;
}

absl::StatusOr<std::vector<std::string>> ListInputs(const std::vector<std::string>& inputs) {
  std::vector<std::string> files;
  for (const std::string& input : inputs) {
    if (!fs::exists(input)) {
      return absl::NotFoundError(absl::StrCat(input, ": there is no such file or folder"));
    }
    if (fs::is_directory(input)) {
      ASSIGN_OR_RETURN(const std::vector<std::string> in_folder, ListFolder(input));
      files.insert(files.end(), in_folder.begin(), in_folder.end());
    } else if (IsGeometryFile(input)) {
      files.push_back(input);
    } else {
      return absl::InvalidArgumentError(
          absl::StrCat(input, ": its name ends with \"", FileExtension(input),
                       "\"; expected .ply, .obj, .stl, .off, .xyz, .pcd or .drc"));
    }
  }
  return files;
}

}  // namespace cagefit::client
