#include "server/session/metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/session/error_detail.h"
#include "server/session/session.h"

namespace cagefit::server {
namespace {

using ::testing::ElementsAre;
using ::testing::Pair;

uint64_t Total(const LatencyHistogram& histogram) {
  uint64_t total = 0;
  for (const uint64_t count : histogram.Counts()) total += count;
  return total;
}

FrameAnswer Answer(Outcome outcome, Verdict verdict = Verdict::kOk) {
  auto frame = std::make_shared<StoredFrame>();
  frame->outcome = outcome;
  frame->verdict = verdict;
  frame->ms = {1, 2, 0, 4, 5, 6, 7};
  if (outcome == Outcome::kRejected) frame->error = InvalidField("f", "1", "expected 2");
  return FrameAnswer{std::move(frame)};
}

TEST(LatencyHistogramTest, AValueCountsInTheFirstStepThatItDoesNotExceed) {
  LatencyHistogram histogram;
  histogram.Observe(0);
  histogram.Observe(LatencyHistogram::Bound(0));
  histogram.Observe(LatencyHistogram::Bound(0) * 1.001);
  histogram.Observe(LatencyHistogram::Bound(LatencyHistogram::kBounds - 1));
  histogram.Observe(1e6);
  const auto counts = histogram.Counts();
  EXPECT_EQ(counts[0], 2u);
  EXPECT_EQ(counts[1], 1u);
  EXPECT_EQ(counts[LatencyHistogram::kBounds - 1], 1u);
  EXPECT_EQ(counts[LatencyHistogram::kBounds], 1u);
  EXPECT_EQ(Total(histogram), 5u);
  EXPECT_NEAR(histogram.Seconds(), 1e6 + 32.768 + 0.00050025, 1e-6);
}

TEST(LatencyHistogramTest, LosesNothingThatThreadsAddAtOnce) {
  LatencyHistogram histogram;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&histogram] {
      for (int k = 0; k < 10'000; ++k) histogram.Observe(0.001);
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(Total(histogram), 40'000u);
  EXPECT_NEAR(histogram.Seconds(), 40, 1e-6);
}

TEST(NamedCountersTest, ManyNamesShareOne) {
  NamedCounters counters;
  for (size_t k = 0; k < NamedCounters::kMaxNames + 5; ++k) counters.Add(absl::StrCat("NAME", k));
  counters.Add("NAME0");
  EXPECT_EQ(counters.Values().size(), NamedCounters::kMaxNames + 1);
  EXPECT_EQ(counters.Values().at("OTHER"), 5u);
  EXPECT_EQ(counters.Values().at("NAME0"), 2u);
}

TEST(MetricsTest, AFittedFrameCountsByVerdictAndStage) {
  Metrics metrics;
  metrics.CountFrame(Answer(Outcome::kFitted));
  metrics.CountFrame(Answer(Outcome::kFitted, Verdict::kSuspect));
  metrics.CountFrame(Answer(Outcome::kFitted, Verdict::kLost));
  metrics.CountFrame(Answer(Outcome::kFitted, Verdict::kLost));
  EXPECT_EQ(metrics.frames_fitted.value(), 4u);
  EXPECT_EQ(metrics.verdict_ok.value(), 1u);
  EXPECT_EQ(metrics.verdict_suspect.value(), 1u);
  EXPECT_EQ(metrics.verdict_lost.value(), 2u);
  for (const auto& [histogram, ms] : {std::pair{&metrics.queue, 1},
                                      {&metrics.decode, 2},
                                      {&metrics.index, 4},
                                      {&metrics.solve, 5},
                                      {&metrics.measure, 6},
                                      {&metrics.encode, 7}}) {
    EXPECT_EQ(Total(*histogram), 4u) << ms;
    EXPECT_NEAR(histogram->Seconds(), 4 * ms / 1e3, 1e-9);
  }
  EXPECT_EQ(Total(metrics.template_making), 0u);  // of frames that made one
  EXPECT_TRUE(metrics.rejects.Values().empty());
}

TEST(MetricsTest, ARejectedFrameCountsByItsReason) {
  Metrics metrics;
  metrics.CountFrame(Answer(Outcome::kRejected));
  EXPECT_EQ(metrics.frames_rejected.value(), 1u);
  EXPECT_EQ(metrics.frames_fitted.value(), 0u);
  EXPECT_EQ(Total(metrics.decode), 1u);
  EXPECT_EQ(Total(metrics.solve), 0u);
  EXPECT_THAT(metrics.rejects.Values(), ElementsAre(Pair("INVALID_FIELD", 1)));
}

TEST(MetricsTest, ARepeatedAnswerCountsAsThatAlone) {
  Metrics metrics;
  FrameAnswer answer = Answer(Outcome::kRejected);
  answer.repeated = true;
  metrics.CountFrame(answer);
  EXPECT_EQ(metrics.frames_repeated.value(), 1u);
  EXPECT_EQ(metrics.frames_rejected.value(), 0u);
  EXPECT_EQ(Total(metrics.queue), 0u);
}

TEST(MetricsTest, AFailureWithoutAReasonCountsByItsCode) {
  Metrics metrics;
  metrics.CountReject(absl::CancelledError("gone"));
  EXPECT_THAT(metrics.rejects.Values(), ElementsAre(Pair("CANCELLED", 1)));
}

}  // namespace
}  // namespace cagefit::server
