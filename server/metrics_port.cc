#include "server/metrics_port.h"

#include <prometheus/metric_family.h>
#include <prometheus/text_serializer.h>

#include <limits>
#include <utility>
#include <vector>

#include "core/base/instruction_set.h"
#include "server/process_memory.h"
#include "server/session/metrics.h"

namespace cagefit::server {
namespace {

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using prometheus::MetricType;
using Labels = std::vector<ClientMetric::Label>;

struct Value {
  double value;
  Labels labels = {};
};

MetricFamily Family(MetricType type, const char* name, const char* help,
                    const std::vector<Value>& values) {
  MetricFamily family = {name, help, type, {}};
  for (const Value& value : values) {
    ClientMetric metric;
    metric.label = value.labels;
    (type == MetricType::Counter ? metric.counter.value : metric.gauge.value) = value.value;
    family.metric.push_back(std::move(metric));
  }
  return family;
}

MetricFamily Gauges(const char* name, const char* help, const std::vector<Value>& values) {
  return Family(MetricType::Gauge, name, help, values);
}

MetricFamily Counters(const char* name, const char* help, const std::vector<Value>& values) {
  return Family(MetricType::Counter, name, help, values);
}

double ValueOf(const Counter& counter) { return static_cast<double>(counter.value()); }

ClientMetric Read(const LatencyHistogram& histogram, Labels labels) {
  ClientMetric metric;
  metric.label = std::move(labels);
  const auto counts = histogram.Counts();
  uint64_t cumulative = 0;
  for (int k = 0; k <= LatencyHistogram::kBounds; ++k) {
    cumulative += counts[k];
    metric.histogram.bucket.push_back({cumulative, k < LatencyHistogram::kBounds
                                                       ? LatencyHistogram::Bound(k)
                                                       : std::numeric_limits<double>::infinity()});
  }
  metric.histogram.sample_count = cumulative;
  metric.histogram.sample_sum = histogram.Seconds();
  return metric;
}

std::vector<MetricFamily> FrameFamilies(const Metrics& m) {
  std::vector<MetricFamily> families;
  families.push_back(Counters("cagefit_frames_total", "Frames answered, by outcome.",
                              {{ValueOf(m.frames_fitted), {{"outcome", "fitted"}}},
                               {ValueOf(m.frames_rejected), {{"outcome", "rejected"}}},
                               {ValueOf(m.frames_skipped), {{"outcome", "skipped"}}},
                               {ValueOf(m.frames_repeated), {{"outcome", "repeated"}}}}));
  families.push_back(Counters("cagefit_frame_verdicts_total", "Frames fitted, by verdict.",
                              {{ValueOf(m.verdict_ok), {{"verdict", "ok"}}},
                               {ValueOf(m.verdict_suspect), {{"verdict", "suspect"}}},
                               {ValueOf(m.verdict_lost), {{"verdict", "lost"}}}}));
  MetricFamily stages = {
      "cagefit_frame_stage_seconds", "Time of a frame's stages.", MetricType::Histogram, {}};
  const std::pair<const char*, const LatencyHistogram*> each[] = {
      {"queue", &m.queue},  {"decode", &m.decode}, {"template", &m.template_making},
      {"index", &m.index},  {"solve", &m.solve},   {"measure", &m.measure},
      {"encode", &m.encode}};
  for (const auto& [name, histogram] : each) {
    stages.metric.push_back(Read(*histogram, {{"stage", name}}));
  }
  families.push_back(std::move(stages));
  families.push_back({"cagefit_store_seconds",
                      "Time of the session store's commits.",
                      MetricType::Histogram,
                      {Read(m.store_seconds, {})}});
  std::vector<Value> rejects;
  for (const auto& [reason, count] : m.rejects.Values()) {
    rejects.push_back({static_cast<double>(count), {{"reason", reason}}});
  }
  families.push_back(Counters("cagefit_rejects_total",
                              "Calls that failed and frames that were rejected, by reason.",
                              rejects));
  return families;
}

std::vector<MetricFamily> ServerFamilies(const ServiceState& state, const Readiness& readiness,
                                         double uptime_seconds, int64_t sessions) {
  const auto number = [](int64_t value) { return static_cast<double>(value); };
  const Scheduler& pools = *state.scheduler;
  return {Gauges("cagefit_build_info", "1; the labels say what runs.",
                 {{1, {{"version", CAGEFIT_VERSION}, {"instruction_set", InstructionSetName()}}}}),
          Gauges("cagefit_uptime_seconds", "Since the server began to serve.", {{uptime_seconds}}),
          Gauges("cagefit_ready", "1 while the server is ready for work, as its health says.",
                 {{readiness.is_ready() ? 1.0 : 0.0}}),
          Gauges("cagefit_sessions", "Sessions in the store.", {{number(sessions)}}),
          Gauges("cagefit_streams", "Open streams of frames.", {{number(state.streams->size())}}),
          Gauges("cagefit_queue_depth", "Tasks that wait for a thread, by pool.",
                 {{number(pools.queries.queued()), {{"pool", "queries"}}},
                  {number(pools.decodes.queued()), {{"pool", "decodes"}}},
                  {number(pools.fits.queued()), {{"pool", "fits"}}}}),
          Gauges("cagefit_in_flight_bytes", "Held by unanswered frames and unsent results.",
                 {{number(state.budget->taken())}}),
          Gauges("process_resident_memory_bytes", "Resident memory of the process.",
                 {{static_cast<double>(ResidentBytes())}})};
}

std::string MetricsText(const ServiceState& state, const Readiness& readiness,
                        double uptime_seconds, int64_t sessions) {
  std::vector<MetricFamily> families = ServerFamilies(state, readiness, uptime_seconds, sessions);
  for (MetricFamily& family : FrameFamilies(*state.metrics)) families.push_back(std::move(family));
  return prometheus::TextSerializer().Serialize(families);
}

}  // namespace

absl::StatusOr<std::unique_ptr<HttpPort>> OpenMetricsPort(const std::string& address,
                                                          const ServiceState& state,
                                                          const Readiness& readiness,
                                                          std::function<int64_t()> sessions) {
  return HttpPort::Open(
      address, {"/metrics", "text/plain; version=0.0.4; charset=utf-8",
                [state, &readiness, sessions = std::move(sessions), start_ms = state.clock()] {
                  return MetricsText(state, readiness, (state.clock() - start_ms) / 1e3,
                                     sessions());
                }});
}

}  // namespace cagefit::server
