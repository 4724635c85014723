// Which frames of a long sequence a report shows in 3D.
#ifndef CAGEFIT_CLIENT_REPORT_SHOWN_FRAMES_H_
#define CAGEFIT_CLIENT_REPORT_SHOWN_FRAMES_H_

#include <cstddef>
#include <vector>

namespace cagefit::client {

// Indices into `rms`, one a frame: all of them where there are at most `most` (2 or more);
// otherwise every k-th from the first on, and the one with the largest value. Ascending.
std::vector<size_t> ShownFrames(const std::vector<double>& rms, size_t most);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_REPORT_SHOWN_FRAMES_H_
