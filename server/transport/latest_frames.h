// Frames of a stream in FRAME_MODE_LATEST that are complete and not begun: of the newest one all of
// it, of those before it what their answers need.
#ifndef CAGEFIT_SERVER_TRANSPORT_LATEST_FRAMES_H_
#define CAGEFIT_SERVER_TRANSPORT_LATEST_FRAMES_H_

#include <memory>
#include <utility>
#include <vector>

#include "server/transport/frame_assembler.h"

namespace cagefit::server {

class LatestFrames {
 public:
  struct Batch {
    std::vector<SkippedFrame> skipped;  // in the order in which they came
    std::shared_ptr<ReceivedFrame> newest;
  };

  // Takes a hashed frame in. The one before it is to be skipped; its bytes go.
  void Put(std::shared_ptr<ReceivedFrame> frame) {
    if (waiting_.newest != nullptr) {
      const Frame& older = waiting_.newest->frame;
      waiting_.skipped.push_back({older.sequence_number, older.timestamp, older.digest});
    }
    waiting_.newest = std::move(frame);
  }

  // What waits: the newest is to be begun now. Null where nothing waits.
  Batch Take() { return std::exchange(waiting_, {}); }

 private:
  Batch waiting_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_LATEST_FRAMES_H_
