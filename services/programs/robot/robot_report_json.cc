#include <limits>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "services/programs/robot/robot_report.h"

namespace corbslam::services {

using client_agent::kUpdateKindNames;
using client_agent::kUpdateKinds;

namespace {

using Json = nlohmann::ordered_json;

// Visits every field with its place in the JSON, which is said here once for writing and reading.
template <typename Report, typename Visitor>
void VisitFields(Report& report, Visitor& visit) {
  visit("/name", report.name);
  visit("/source", report.source);
  visit("/source_description", report.source_description);
  visit("/settings", report.settings);
  visit("/frames", report.frames);
  visit("/tracked", report.tracked);
  visit("/dropped", report.dropped);
  visit("/lost", report.lost);
  visit("/left_out", report.left_out);
  visit("/pictures_s", report.pictures_s);
  visit("/local_maps", report.local_maps);
  visit("/hand_overs", report.hand_overs);
  visit("/far/brought_back", report.brought_back);
  visit("/far/recognised", report.far_recognised);
  visit("/far/unreadable", report.far_unreadable);
  visit("/resumed_after_s", report.resumed_after_s);
  visit("/why_not_resumed", report.why_not_resumed);
  visit("/map_mb", report.map_mb);
  visit("/first_upload_s", report.first_upload_s);
  visit("/shared/keyframes_held", report.keyframes_held);
  visit("/shared/points_matched_percent", report.points_matched_percent);
  visit("/shared/loops_closed", report.shared_loops_closed);
  visit("/shared/places_told", report.places_told);
  visit("/shared/located_after_s", report.located_after_s);
  visit("/shared/relocalised", report.shared_relocalised);
  visit("/loops_closed", report.loops_closed);
  visit("/relocalised", report.relocalised);
  visit("/keyframes", report.keyframes);
  visit("/map_points", report.map_points);
  visit("/ate_m", report.ate_m);
  visit("/ate_from_frame_m", report.ate_from_frame_m);
  visit("/ate_global_m", report.ate_global_m);
  visit("/told/ate_m", report.told_ate_m);
  visit("/told/ate_before_m", report.told_ate_before_m);
  visit("/told/jumps", report.told_jumps);
  visit("/told/jumps_m", report.told_jumps_m);
  visit("/told/largest_jump_m", report.told_largest_jump_m);
  visit("/t_rel_percent", report.t_rel_percent);
  visit("/r_rel_deg_per_100m", report.r_rel_deg_per_100m);
  visit("/tracking_ms/median", report.tracking_ms.median);
  visit("/tracking_ms/mean", report.tracking_ms.mean);
  visit("/tracking_ms/p99", report.tracking_ms.p99);
  visit("/latency_ms/median", report.latency_ms.median);
  visit("/latency_ms/mean", report.latency_ms.mean);
  visit("/latency_ms/p99", report.latency_ms.p99);
  visit("/local_ba_ms", report.local_ba_ms.median);
  visit("/local_ba/count", report.local_ba_count);
  visit("/local_ba/mean_ms", report.local_ba_ms.mean);
  visit("/local_ba/p99_ms", report.local_ba_ms.p99);
  visit("/peak_rss_mb", report.peak_rss_mb);
  visit("/cpu_s", report.cpu_s);
  visit("/outbox/batches", report.outbox.batches);
  visit("/outbox/memory_bytes", report.outbox.memory_bytes);
  visit("/outbox/spool_bytes", report.outbox.spool_bytes);
  visit("/outbox/spool_syncs", report.outbox.spool_syncs);
  visit("/outbox/lost_local_maps", report.outbox.lost_local_maps);
  visit("/outbox/refused_items", report.outbox.refused_items);
  for (size_t kind = 0; kind < kUpdateKinds; ++kind) {
    visit(absl::StrCat("/held_back/", kUpdateKindNames[kind]), report.held_back[kind]);
  }
  visit("/bytes_up", report.bytes_up);
  visit("/bytes_down", report.bytes_down);
  visit("/warnings", report.warnings);
}

class FieldWriter {
 public:
  template <typename Value>
  void operator()(const std::string& place, const Value& value) {
    json_[Json::json_pointer(place)] = ToValue(value);
  }
  Json json() && { return std::move(json_); }

 private:
  template <typename Value>
  static Json ToValue(const Value& value) {
    return value;
  }
  static Json ToValue(const std::optional<double>& value) {
    return value.has_value() ? Json(*value) : Json(nullptr);
  }
  // The report itself says which robot they are of, so that the name is left out.
  static Json ToValue(const std::vector<ReportWarning>& warnings) {
    Json array = Json::array();
    for (const ReportWarning& warning : warnings) {
      array.push_back({{"code", warning.code}, {"text", warning.text}});
    }
    return array;
  }

  Json json_ = Json::object();
};

// Reads until the first field that is wrong. It checks each value's kind before it takes the value:
// the library's own conversions cut fractions off and let large numbers wrap.
class FieldReader {
 public:
  explicit FieldReader(const Json& json) : json_(json) {}

  template <typename Value>
  void operator()(const std::string& place, Value& value) {
    if (!status_.ok()) return;
    const Json::json_pointer pointer(place);
    if (!json_.contains(pointer)) {
      status_ = absl::DataLossError(absl::StrCat("a robot's report has no ", place.substr(1)));
    } else if (const Json& field = json_.at(pointer); !Read(field, value)) {
      status_ = absl::DataLossError(absl::StrCat("a robot's report has ", field.dump(), " for ",
                                                 place.substr(1), ", which is of another kind"));
    }
  }
  const absl::Status& status() const { return status_; }

 private:
  static bool Read(const Json& field, uint64_t& value) {
    if (!field.is_number_integer()) return false;
    if (!field.is_number_unsigned() && field.get<int64_t>() < 0) return false;
    value = field.get<uint64_t>();
    return true;
  }
  static bool Read(const Json& field, int& value) {
    uint64_t count = 0;
    if (!Read(field, count) || count > uint64_t{std::numeric_limits<int>::max()}) return false;
    value = static_cast<int>(count);
    return true;
  }
  static bool Read(const Json& field, double& value) {
    if (!field.is_number()) return false;
    value = field.get<double>();
    return true;
  }
  static bool Read(const Json& field, std::optional<double>& value) {
    if (!field.is_null()) return Read(field, value.emplace());
    value.reset();
    return true;
  }
  static bool Read(const Json& field, std::string& value) {
    if (!field.is_string()) return false;
    value = field.get<std::string>();
    return true;
  }
  static bool Read(const Json& field, Json& value) {
    if (!field.is_null() && !field.is_object()) return false;
    value = field;
    return true;
  }
  static bool Read(const Json& field, std::vector<ReportWarning>& warnings) {
    if (!field.is_array()) return false;
    for (const Json& entry : field) {
      ReportWarning& warning = warnings.emplace_back();
      if (!entry.contains("code") || !Read(entry["code"], warning.code)) return false;
      if (!entry.contains("text") || !Read(entry["text"], warning.text)) return false;
    }
    return true;
  }

  const Json& json_;
  absl::Status status_;
};

}  // namespace

nlohmann::ordered_json ToJson(const RobotReport& report) {
  FieldWriter writer;
  VisitFields(report, writer);
  return std::move(writer).json();
}

absl::StatusOr<RobotReport> RobotReportFromJson(const nlohmann::ordered_json& json) {
  RobotReport report;
  FieldReader reader(json);
  VisitFields(report, reader);
  if (!reader.status().ok()) return reader.status();
  return report;
}

}  // namespace corbslam::services
