// The server's log of frames: one line each.
#ifndef CAGEFIT_SERVER_TRANSPORT_FRAME_LOG_H_
#define CAGEFIT_SERVER_TRANSPORT_FRAME_LOG_H_

#include <spdlog/logger.h>

#include <string>

#include "server/session/session.h"

namespace cagefit::server {

void LogFrame(spdlog::logger& log, const std::string& session_id, const std::string& trace_id,
              const FrameAnswer& answer);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_FRAME_LOG_H_
