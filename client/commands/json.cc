#include "client/commands/json.h"

namespace cagefit::client {
namespace {

double Percent(double distance, double diagonal) {
  return diagonal > 0 ? 100 * distance / diagonal : 0;
}

}  // namespace

std::string Text(const Json& json, int indent) {
  return json.dump(indent, ' ', /*ensure_ascii=*/false, Json::error_handler_t::replace);
}

std::string Utf8(const std::string& text) { return Json::parse(Text(Json(text))); }

Json ToJson(const DistanceStats& stats, double diagonal) {
  return {{"mean", stats.mean},
          {"rms", stats.rms},
          {"max", stats.max},
          {"mean_percent", Percent(stats.mean, diagonal)},
          {"rms_percent", Percent(stats.rms, diagonal)},
          {"max_percent", Percent(stats.max, diagonal)},
          {"samples", stats.samples}};
}

Json ToJson(const SurfaceMetrics& metrics) {
  Json json = {{"diagonal", metrics.diagonal},
               {"target_to_fit", ToJson(metrics.target_to_fit, metrics.diagonal)},
               {"fit_to_target", ToJson(metrics.fit_to_target, metrics.diagonal)},
               {"hausdorff", metrics.hausdorff()},
               {"hausdorff_percent", metrics.Percent(metrics.hausdorff())},
               {"symmetric_rms", metrics.symmetric_rms()},
               {"symmetric_rms_percent", metrics.Percent(metrics.symmetric_rms())}};
  json["fit_to_target"]["approximate"] = metrics.approximate;
  return json;
}

Json ToJson(const DriftStats& drift, double diagonal) {
  return {{"mean", drift.mean},
          {"rms", drift.rms},
          {"max", drift.max},
          {"tangential_mean", drift.tangential_mean},
          {"mean_percent", Percent(drift.mean, diagonal)},
          {"rms_percent", Percent(drift.rms, diagonal)},
          {"max_percent", Percent(drift.max, diagonal)},
          {"tangential_mean_percent", Percent(drift.tangential_mean, diagonal)}};
}

}  // namespace cagefit::client
