#include "services/programs/recording/recorded_lines.h"

#include <nlohmann/json.hpp>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "services/programs/recording/calibration_json.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::TrackingResult;
using client_agent::TrackingState;

namespace {

using Json = nlohmann::ordered_json;

constexpr TrackingState kStates[] = {TrackingState::kNotInitialised, TrackingState::kTracking,
                                     TrackingState::kLost};

Json ToJson(const FrameLine& line) {
  Json json = {{"frame", line.frame},
               {"time_ns", line.timestamp_ns},
               {"begins_local_map", line.begins_local_map},
               {"pictures", line.pictures}};
  if (!line.checksums.empty()) json["checksums"] = line.checksums;
  if (line.imu_samples > 0) json["imu_samples"] = line.imu_samples;
  return json;
}

Json ToJson(const OrdersLine& line) {
  Json json = {{"orders", line.frame},
               {"mapping_paused", line.mapping_paused},
               {"opens_local_map", line.opens_local_map}};
  if (line.has_mask.has_value()) json["has_mask"] = *line.has_mask;
  if (line.mask_checksum.has_value()) json["mask_checksum"] = *line.mask_checksum;
  return json;
}

Json ToJson(const ResultLine& line) {
  const TrackingResult& result = line.result;
  Json json = {{"result", line.frame},
               {"time_ns", result.timestamp_ns},
               {"state", std::string(WordOf(result.state))},
               {"local_map", ToString(result.local_map)},
               {"camera_from_local", services::ToJson(result.camera_from_local)},
               {"points", result.points_matched},
               {"others_points", result.foreign_points_matched},
               {"keyframe", result.made_keyframe},
               {"dropped", line.dropped}};
  if (result.follows_keyframe) json["previous_became_keyframe"] = true;
  return json;
}

FrameLine FrameOf(const Json& json) {
  FrameLine line = {json.at("frame"), json.at("time_ns"), json.at("begins_local_map"),
                    json.at("pictures")};
  if (json.contains("checksums")) {
    line.checksums = json.at("checksums").get<std::vector<uint32_t>>();
  }
  line.imu_samples = json.value("imu_samples", uint64_t{0});
  return line;
}

OrdersLine OrdersOf(const Json& json) {
  OrdersLine line = {json.at("orders"), json.at("mapping_paused"), json.at("opens_local_map")};
  if (json.contains("has_mask")) line.has_mask = json.at("has_mask").get<bool>();
  if (json.contains("mask_checksum")) line.mask_checksum = json.at("mask_checksum").get<uint32_t>();
  return line;
}

absl::StatusOr<TrackingState> StateOf(const std::string& word) {
  for (const TrackingState state : kStates) {
    if (word == WordOf(state)) return state;
  }
  return absl::DataLossError(absl::StrCat("an unknown state, ", word));
}

absl::StatusOr<RecordedLine> ResultOf(const Json& json) {
  ResultLine line;
  line.frame = json.at("result");
  line.dropped = json.at("dropped");
  TrackingResult& result = line.result;
  result.timestamp_ns = json.at("time_ns");
  ASSIGN_OR_RETURN(result.state, StateOf(json.at("state")));
  if (!absl::SimpleHexAtoi(json.at("local_map").get<std::string>(), &result.local_map.value)) {
    return absl::DataLossError(absl::StrCat("no local map, ", json.at("local_map").dump()));
  }
  ASSIGN_OR_RETURN(result.camera_from_local, RigidFromJson(json.at("camera_from_local")));
  result.points_matched = json.at("points");
  result.foreign_points_matched = json.at("others_points");
  result.made_keyframe = json.at("keyframe");
  result.follows_keyframe = json.value("previous_became_keyframe", false);
  return line;
}

}  // namespace

absl::string_view WordOf(TrackingState state) {
  switch (state) {
    case TrackingState::kNotInitialised:
      return "not-initialised";
    case TrackingState::kTracking:
      return "tracking";
    case TrackingState::kLost:
      return "lost";
  }
  return "unknown";
}

std::string FormatLine(const RecordedLine& line) {
  return std::visit([](const auto& kind) { return ToJson(kind).dump(); }, line);
}

absl::StatusOr<RecordedLine> ParseLine(absl::string_view text) {
  try {
    const Json json = Json::parse(text.begin(), text.end());
    if (json.contains("result")) return ResultOf(json);
    if (json.contains("orders")) return OrdersOf(json);
    return FrameOf(json);
  } catch (const Json::exception& error) {
    return absl::DataLossError(error.what());
  }
}

bool AreEqual(const TrackingResult& a, const TrackingResult& b) {
  if (a.timestamp_ns != b.timestamp_ns || a.state != b.state || a.local_map != b.local_map) {
    return false;
  }
  if (a.state != TrackingState::kTracking) return true;
  return a.camera_from_local.rotation.coeffs() == b.camera_from_local.rotation.coeffs() &&
         a.camera_from_local.translation == b.camera_from_local.translation &&
         a.points_matched == b.points_matched &&
         a.foreign_points_matched == b.foreign_points_matched &&
         a.made_keyframe == b.made_keyframe && a.follows_keyframe == b.follows_keyframe;
}

}  // namespace corbslam::services
