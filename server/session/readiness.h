// Whether this server should get new work: it should, unless something names a reason against it.
#ifndef CAGEFIT_SERVER_SESSION_READINESS_H_
#define CAGEFIT_SERVER_SESSION_READINESS_H_

#include <atomic>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace cagefit::server {

// Thread-safe. Each part that can be in the way has a name of its own: the store sets "store" when
// it is away and clears it when it is back, whatever else keeps the server from being ready.
class Readiness {
 public:
  using Listener = std::function<void(bool ready)>;

  // Without effect where the reason is set, or not set, already.
  void Set(const std::string& reason);
  void Clear(const std::string& reason);

  bool is_ready() const { return ready_; }
  std::vector<std::string> Reasons() const;  // that are set, in order of name

  // Calls `listener` at every change from now on, one after another, on the thread that makes the
  // change and after is_ready() tells it. It must return soon, must not call Set or Clear, and what
  // it uses must outlive the last change.
  void Listen(Listener listener);

 private:
  void Update();

  mutable std::mutex mutex_;
  std::set<std::string> reasons_;
  std::vector<Listener> listeners_;
  std::atomic<bool> ready_{true};
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_READINESS_H_
