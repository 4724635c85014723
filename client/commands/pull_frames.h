// A session's whole sequence, as files.
#ifndef CAGEFIT_CLIENT_COMMANDS_PULL_FRAMES_H_
#define CAGEFIT_CLIENT_COMMANDS_PULL_FRAMES_H_

#include <string>

#include "absl/status/status.h"
#include "client/commands/sequence_formats.h"
#include "client/fit_client.h"

namespace cagefit::client {

// FOLDER/NNNN.obj of every fitted frame, by its sequence number, FOLDER/report.json of all frames,
// with the distances that the server sampled, and what `formats` asks for. Errors of the server and
// of writing.
absl::Status PullFrames(FitClient* client, const std::string& session_id, const std::string& folder,
                        const SequenceFormats& formats);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_PULL_FRAMES_H_
