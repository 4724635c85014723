// How far a fit is, on standard error: a bar on a terminal, a line a frame otherwise.
#ifndef CAGEFIT_CLIENT_COMMANDS_PROGRESS_H_
#define CAGEFIT_CLIENT_COMMANDS_PROGRESS_H_

#include <cstddef>
#include <string>

namespace cagefit::client {

class Progress {
 public:
  explicit Progress(size_t frames);  // 0: it is not known how many
  ~Progress();                       // leaves the bar's line

  // `done` frames are answered; `text` says how the last one went.
  void Show(size_t done, const std::string& text);

 private:
  const size_t frames_;
  const bool terminal_;
  bool shown_ = false;
};

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_PROGRESS_H_
