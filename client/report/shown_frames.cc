#include "client/report/shown_frames.h"

#include <algorithm>

namespace cagefit::client {

std::vector<size_t> ShownFrames(const std::vector<double>& rms, size_t most) {
  const size_t count = rms.size();
  const size_t places = most - 1;  // one is left for the worst frame
  const size_t step = count <= most ? 1 : (count + places - 1) / places;
  const auto worst = static_cast<size_t>(std::max_element(rms.begin(), rms.end()) - rms.begin());
  std::vector<size_t> shown;
  for (size_t k = 0; k < count; ++k) {
    if (k % step == 0 || k == worst) shown.push_back(k);
  }
  return shown;
}

}  // namespace cagefit::client
