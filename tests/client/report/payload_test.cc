#include "client/report/payload.h"

#include <gmock/gmock.h>

#include "tests/client/report/page_reader.h"

namespace cagefit::client {
namespace {

using ::cagefit::testing::PageData;
using ::cagefit::testing::ReadPayload;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(PayloadTest, BringsArraysOfEveryWidthBack) {
  Payload payload;
  payload.Add("bytes", 1, 0, {0, 255, 128});
  payload.Add("words", 2, 0, {65535, 1});
  payload.Add("wide", 4, 0, {4294967295u, 70000, 0});
  const PageData data = ReadPayload(payload.Encode({{"of", "three"}}));
  EXPECT_EQ(data.header["of"], "three");
  EXPECT_THAT(data.arrays.at("bytes"), ElementsAre(0, 255, 128));
  EXPECT_THAT(data.arrays.at("words"), ElementsAre(65535, 1));
  EXPECT_THAT(data.arrays.at("wide"), ElementsAre(4294967295u, 70000, 0));
}

TEST(PayloadTest, DifferencesWrapAround) {
  Payload payload;
  payload.Add("words", 2, 2, {65535, 3, 1, 65535, 65535, 0});
  EXPECT_THAT(ReadPayload(payload.Encode({})).arrays.at("words"),
              ElementsAre(65535, 3, 1, 65535, 65535, 0));
}

TEST(PayloadTest, TakesAnEmptyArray) {
  Payload payload;
  payload.Add("none", 4, 3, {});
  EXPECT_THAT(ReadPayload(payload.Encode({})).arrays.at("none"), IsEmpty());
}

TEST(PayloadTest, WhatRepeatsWithItsStrideIsSmall) {
  std::vector<uint32_t> values;
  uint32_t state = 1;
  for (int i = 0; i < 1000; ++i) values.push_back((state = state * 1664525 + 1013904223) >> 16);
  for (int i = 0; i < 9000; ++i) values.push_back(values[i]);
  Payload payload;
  payload.Add("words", 2, 1000, values);
  EXPECT_LT(payload.Encode({}).size(), 3500u);  // of 20,000 bytes
}

TEST(PayloadTest, TextThatIsNoUtf8IsReplaced) {
  EXPECT_EQ(ReadPayload(Payload().Encode({{"file", "a\xff\x62"}})).header["file"],
            "a\xEF\xBF\xBD\x62");
}

}  // namespace
}  // namespace cagefit::client
