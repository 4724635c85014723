// Metrics as JSON, the same in every command.
#ifndef CAGEFIT_CLIENT_COMMANDS_JSON_H_
#define CAGEFIT_CLIENT_COMMANDS_JSON_H_

#include <nlohmann/json.hpp>
#include <string>

#include "core/metrics/drift.h"
#include "core/metrics/surface_metrics.h"

namespace cagefit::client {

// Keys keep their order.
using Json = nlohmann::ordered_json;

// As text, on one line or indented. Names of files need not be UTF-8, which JSON is: what is not
// becomes U+FFFD.
std::string Text(const Json& json, int indent = -1);
// `text` likewise.
std::string Utf8(const std::string& text);

// Distances in units and in percent of `diagonal`.
Json ToJson(const DistanceStats& stats, double diagonal);
Json ToJson(const SurfaceMetrics& metrics);
Json ToJson(const DriftStats& drift, double diagonal);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_JSON_H_
