// Protobuf writes a line for every string that is not UTF-8; cagefitd silences it, too.
#include <google/protobuf/stubs/logging.h>

namespace {

[[maybe_unused]] auto* const silenced = google::protobuf::SetLogHandler(nullptr);

}  // namespace
