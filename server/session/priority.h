// How urgent a session's work is.
#ifndef CAGEFIT_SERVER_SESSION_PRIORITY_H_
#define CAGEFIT_SERVER_SESSION_PRIORITY_H_

namespace cagefit::server {

enum class Priority {
  kLive,   // somebody waits for it
  kBatch,  // gets what live work leaves, and a small share in any case
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_PRIORITY_H_
