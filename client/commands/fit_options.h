// The flags of `cagefit fit`.
#ifndef CAGEFIT_CLIENT_COMMANDS_FIT_OPTIONS_H_
#define CAGEFIT_CLIENT_COMMANDS_FIT_OPTIONS_H_

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cagefit/v1/fitting.pb.h"
#include "client/commands/sequence_formats.h"
#include "client/credentials.h"

namespace cagefit::client {

struct FitArguments {
  std::vector<std::string> inputs;
  std::vector<std::string> truth;  // files of the true motion; empty: none
  std::string out, cage, server, name;
  ClientCredentials credentials;  // for the server
  std::string cameras, masks;     // a file or folder of cameras; a folder of their masks, or none
  std::string landmarks;          // a file of them, or none
  std::string session;            // that goes on; empty: a new one
  uint32_t vertices = 0;
  std::optional<double> crease_angle;  // degrees
  int position_bits = 16;
  int threads = 0;               // of the server inside; 0: one per core
  std::string store = "memory";  // likewise; as cagefitd's
  uint64_t from_frame = 0;
  std::optional<uint64_t> to_frame;  // the last one
  SequenceFormats formats;
  bool keep_session = false, quick = false, report = false, json = false, round_trip = false;
  bool takes = false;              // every input is a take of its own
  uint32_t chunk = 0, chunks = 1;  // of the takes, those whose index modulo `chunks` is `chunk`
  bool follow = false;
  double give_up = 60;                        // seconds, of a server that stays away
  double follow_settle = 1, follow_idle = 0;  // seconds; idle 0: until interrupted
  bool latest = false;         // frames that the server cannot keep up with may be skipped
  v1::SessionOptions options;  // what is not given stays unset: the server's defaults
};

// The arguments are written when the command line is parsed.
void AddFitFlags(FitArguments* arguments, CLI::App* command);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_FIT_OPTIONS_H_
