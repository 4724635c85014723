// Where the server's work runs: never on a thread that serves the network.
#ifndef CAGEFIT_SERVER_SESSION_SCHEDULER_H_
#define CAGEFIT_SERVER_SESSION_SCHEDULER_H_

#include "server/session/worker_pool.h"

namespace cagefit::server {

// Three pools, so that none waits for another: frames decode while others are fitted, and a large
// surface that somebody asks for holds up neither. Fits give way between solver steps, so a few
// large ones do not occupy all workers for as long as they take.
struct Scheduler {
  struct Options {
    int fit_threads = 1;  // concurrent fits, each of them parallel inside
    int decode_threads = 1;
    int query_threads = 1;
    int64_t max_queued = 4096;  // tasks that may wait in each pool
  };

  // Fits that have given way to sessions that used less, each with its frame in memory.
  static constexpr int kMaxPausedFits = 16;

  explicit Scheduler(const Options& options)
      : queries("requests", options.query_threads, options.max_queued),
        fits("fits", options.fit_threads, options.max_queued, kMaxPausedFits),
        decodes("decodes", options.decode_threads, options.max_queued) {}

  // Destroyed from the last to the first: decodes still hand over to fits.
  WorkerPool queries;  // key: anything
  WorkerPool fits;     // key: session, whose lease the task takes
  WorkerPool decodes;  // key: stream
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_SCHEDULER_H_
