#include "client/commands/parse_tolerance.h"

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"

namespace cagefit::client {
namespace {

constexpr double kMost = 0.1;  // as the server has it
constexpr double kMostWithoutSign = 0.01;

}  // namespace

absl::StatusOr<double> ParseTolerance(absl::string_view text) {
  absl::string_view number = absl::StripAsciiWhitespace(text);
  const bool percent = absl::ConsumeSuffix(&number, "%");
  double value = 0;
  if (!absl::SimpleAtod(absl::StripAsciiWhitespace(number), &value)) {
    return absl::InvalidArgumentError(
        absl::StrCat("--tolerance is \"", text,
                     "\"; expected a percentage, as in 0.1%, or a share, as in 0.001"));
  }
  const double share = percent ? value / 100 : value;
  if (!(share > 0 && share <= kMost)) {  // false for NaN
    return absl::InvalidArgumentError(
        absl::StrCat("--tolerance is \"", text, "\"; expected more than 0 and at most 10%"));
  }
  if (!percent && share > kMostWithoutSign) {
    return absl::InvalidArgumentError(absl::StrCat("--tolerance is \"", text, "\", which is ",
                                                   100 * share, "% of the diagonal; write ", text,
                                                   "% or ", 100 * share, "%"));
  }
  return share;
}

}  // namespace cagefit::client
