// Parallel loops whose result does not depend on the number of threads.
//
// The range is cut into chunks of `grain` whatever the number of threads, and sums add chunk by
// chunk in order, so that every result is the same to the bit. The number of threads is the
// caller's (oneTBB arena or global control).
#ifndef CAGEFIT_CORE_BASE_PARALLEL_H_
#define CAGEFIT_CORE_BASE_PARALLEL_H_

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/base/sanitizer.h"
#if CAGEFIT_THREAD_SANITIZER
#include <sanitizer/tsan_interface.h>
#endif

namespace cagefit {

// Tells ThreadSanitizer the order that a parallel loop keeps, which it cannot see inside oneTBB:
// what came before the loop, then every chunk, then what comes after. Chunks have none.
class LoopOrder {
 public:
#if CAGEFIT_THREAD_SANITIZER
  LoopOrder() { __tsan_release(&begin_); }
  ~LoopOrder() { __tsan_acquire(&end_); }
  void BeginChunk() { __tsan_acquire(&begin_); }
  void EndChunk() { __tsan_release(&end_); }

 private:
  char begin_ = 0, end_ = 0;
#else
  void BeginChunk() {}
  void EndChunk() {}
#endif
};

// Calls body(begin, end) for consecutive chunks of [0, count), concurrently.
template <typename Body>
void ParallelFor(int64_t count, int64_t grain, const Body& body) {
  if (count <= 0) return;
  const int64_t chunks = (count + grain - 1) / grain;
  if (chunks == 1) {
    body(int64_t{0}, count);
    return;
  }
  LoopOrder order;
  tbb::parallel_for(
      tbb::blocked_range<int64_t>(0, chunks, 1),
      [&](const tbb::blocked_range<int64_t>& range) {
        order.BeginChunk();
        for (int64_t c = range.begin(); c < range.end(); ++c) {
          body(c * grain, std::min(count, (c + 1) * grain));
        }
        order.EndChunk();
      },
      tbb::simple_partitioner());
}

// Returns the sum over chunks of body(begin, end), added in chunk order.
template <typename Body>
double ParallelSum(int64_t count, int64_t grain, const Body& body) {
  if (count <= 0) return 0.0;
  const int64_t chunks = (count + grain - 1) / grain;
  if (chunks == 1) return body(int64_t{0}, count);
  std::vector<double> partial(chunks);
  ParallelFor(count, grain,
              [&](int64_t begin, int64_t end) { partial[begin / grain] = body(begin, end); });
  double sum = 0.0;
  for (const double p : partial) sum += p;
  return sum;
}

}  // namespace cagefit

#endif  // CAGEFIT_CORE_BASE_PARALLEL_H_
