#include "services/programs/robot/source_json.h"

#include <optional>

namespace corbslam::services {

using client_agent::Intrinsics;
using client_agent::SourceDescription;
using client_agent::SourceFinding;
using client_agent::SourceFindings;

namespace {

using Json = nlohmann::ordered_json;

Json OrNull(const std::optional<double>& value) {
  return value.has_value() ? Json(*value) : Json(nullptr);
}

Json ToJson(const Intrinsics& k) {
  return {{"fx_px", k.fx_px}, {"fy_px", k.fy_px}, {"cx_px", k.cx_px}, {"cy_px", k.cy_px}};
}

}  // namespace

nlohmann::ordered_json ToJson(const SourceDescription& description) {
  const SourceDescription& d = description;
  return {{"layout", d.layout},
          {"camera_model", d.camera_model},
          {"width_px", d.intrinsics.width_px},
          {"height_px", d.intrinsics.height_px},
          {"intrinsics", ToJson(d.intrinsics)},
          {"intrinsics_from", d.intrinsics_from},
          {"baseline_m", OrNull(d.baseline_m)},
          {"depth_units_per_m", OrNull(d.depth_units_per_m)},
          {"depth_units_from", d.depth_units_from},
          {"frames", d.frames},
          {"rate_hz", d.times.rate_hz},
          {"duration_s", d.times.duration_s},
          {"times_from", d.times_from},
          {"gaps", d.times.gaps},
          {"longest_gap_s", d.times.longest_gap_s},
          {"imu", d.imu},
          {"left_out", d.remarks.left_out}};
}

nlohmann::ordered_json ToJson(const SourceFindings& findings) {
  Json array = Json::array();
  for (const SourceFinding& finding : findings) {
    array.push_back({{"code", finding.code}, {"text", finding.text}});
  }
  return array;
}

}  // namespace corbslam::services
