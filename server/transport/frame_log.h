// The server's log: one line of key=value pairs per event.
#ifndef CAGEFIT_SERVER_TRANSPORT_FRAME_LOG_H_
#define CAGEFIT_SERVER_TRANSPORT_FRAME_LOG_H_

#include <spdlog/logger.h>

#include <string>

#include "server/session/session.h"

namespace cagefit::server {

void LogFrame(spdlog::logger& log, const std::string& session_id, const FrameAnswer& answer);

void LogStreamEnd(spdlog::logger& log, const std::string& session_id, uint64_t epoch,
                  const absl::Status& status);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_FRAME_LOG_H_
