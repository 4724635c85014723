#include "client/io/lzf.h"

#include "tests/client/io/expect_error.h"

namespace cagefit::client {
namespace {

TEST(LzfTest, CopiesAndRepeats) {
  // 2: copy 3 bytes; 0x40 (length 2 + 2), distance 3: "abca"; overlapping repeats are allowed.
  EXPECT_EQ(*DecompressLzf(absl::string_view("\x02"
                                             "abc"
                                             "\x40\x02",
                                             6),
                           7),
            "abcabca");
  EXPECT_EQ(*DecompressLzf(absl::string_view("\x00z\xe0\x00\x00", 5), 10), "zzzzzzzzzz");
}

TEST(LzfTest, RefusesBrokenData) {
  EXPECT_INVALID(DecompressLzf("\x05xy", 6), "end early");
  EXPECT_INVALID(DecompressLzf(absl::string_view("\x40\x00", 2), 4), "never there");
  EXPECT_INVALID(DecompressLzf(absl::string_view("\x00z\xe0", 3), 10), "end early");
  EXPECT_INVALID(DecompressLzf(absl::string_view("\x01xy", 3), 1), "more than they claim");
  EXPECT_INVALID(DecompressLzf(absl::string_view("\x01xy", 3), 3), "less than they claim");
  EXPECT_INVALID(DecompressLzf("x", 1'000'000'000), "too few");
}

}  // namespace
}  // namespace cagefit::client
