#include "services/convert/agent_report.h"

#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "services/convert/errors.h"
#include "services/convert/limits.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

AgentActivity ReadActivity(int activity) {
  switch (activity) {
    case v1::AGENT_ACTIVITY_INITIALISING:
      return AgentActivity::kInitialising;
    case v1::AGENT_ACTIVITY_TRACKING:
      return AgentActivity::kTracking;
    case v1::AGENT_ACTIVITY_LOST:
      return AgentActivity::kLost;
    case v1::AGENT_ACTIVITY_WAITING:
      return AgentActivity::kWaiting;
    case v1::AGENT_ACTIVITY_FINISHED:
      return AgentActivity::kFinished;
    default:
      return AgentActivity::kUnknown;
  }
}

constexpr double kMost = std::numeric_limits<double>::max();

absl::StatusOr<std::optional<MapBend>> ReadBend(const v1::MapContradiction& proto) {
  if (!proto.has_bend()) return std::nullopt;
  const MapBend bend{proto.bend().way_m(), proto.bend().shift_m(), proto.bend().turn_rad()};
  for (const auto& [field, value] :
       {std::pair("report.contradictions.bend.way_m", bend.way_m),
        std::pair("report.contradictions.bend.shift_m", bend.shift_m),
        std::pair("report.contradictions.bend.turn_rad", bend.turn_rad)}) {
    // The condition is written so that NaN is refused.
    if (!(value >= 0 && std::isfinite(value))) return OutOfRange(field, value, 0.0, kMost);
  }
  return bend;
}

absl::StatusOr<std::vector<MapContradiction>> ReadContradictions(const v1::AgentReport& proto) {
  const auto count = static_cast<size_t>(proto.contradictions_size());
  if (count > AgentReport::kMaxContradictions) {
    return OutOfRange("the number of report.contradictions", count, size_t{0},
                      AgentReport::kMaxContradictions);
  }
  std::vector<MapContradiction> read;
  for (const v1::MapContradiction& said : proto.contradictions()) {
    ASSIGN_OR_RETURN(read.emplace_back(), FromProto(said));
  }
  return read;
}

}  // namespace

v1::AgentActivity ToProto(AgentActivity activity) {
  switch (activity) {
    case AgentActivity::kInitialising:
      return v1::AGENT_ACTIVITY_INITIALISING;
    case AgentActivity::kTracking:
      return v1::AGENT_ACTIVITY_TRACKING;
    case AgentActivity::kLost:
      return v1::AGENT_ACTIVITY_LOST;
    case AgentActivity::kWaiting:
      return v1::AGENT_ACTIVITY_WAITING;
    case AgentActivity::kFinished:
      return v1::AGENT_ACTIVITY_FINISHED;
    case AgentActivity::kUnknown:
      break;
  }
  return v1::AGENT_ACTIVITY_UNSPECIFIED;
}

void ToProto(const AgentReport& report, v1::AgentReport* proto) {
  proto->set_activity(ToProto(report.activity));
  proto->set_frames(report.frames);
  proto->set_tracked(report.tracked);
  proto->set_lost(report.lost);
  proto->set_dropped(report.dropped);
  proto->set_newest_timestamp_ns(report.newest_timestamp_ns);
  proto->set_newest_frame_age_s(report.newest_frame_age_s);
  for (const MapContradiction& found : report.contradictions) {
    ToProto(found, proto->add_contradictions());
  }
}

void ToProto(const MapContradiction& found, v1::MapContradiction* proto) {
  proto->set_local_map(found.local_map.value);
  proto->set_scale(found.scale);
  proto->set_scale_sigma(found.scale_sigma);
  if (!found.bend.has_value()) return;
  proto->mutable_bend()->set_way_m(found.bend->way_m);
  proto->mutable_bend()->set_shift_m(found.bend->shift_m);
  proto->mutable_bend()->set_turn_rad(found.bend->turn_rad);
}

absl::StatusOr<MapContradiction> FromProto(const v1::MapContradiction& proto) {
  // The conditions are written so that NaN is refused.
  if (!(proto.scale() > 0 && std::isfinite(proto.scale()))) {
    return OutOfRange("report.contradictions.scale", proto.scale(), 0.0, kMost);
  }
  if (!(proto.scale_sigma() >= 0 && std::isfinite(proto.scale_sigma()))) {
    return OutOfRange("report.contradictions.scale_sigma", proto.scale_sigma(), 0.0, kMost);
  }
  ASSIGN_OR_RETURN(const std::optional<MapBend> bend, ReadBend(proto));
  return MapContradiction{LocalMapId{proto.local_map()}, proto.scale(), proto.scale_sigma(), bend};
}

absl::StatusOr<AgentReport> FromProto(const v1::AgentReport& proto) {
  const int64_t newest_ns = proto.newest_timestamp_ns();
  if (newest_ns < 0 || newest_ns > kMaxTimestamp_ns) {
    return OutOfRange("report.newest_timestamp_ns", newest_ns, int64_t{0}, kMaxTimestamp_ns);
  }
  const double age_s = proto.newest_frame_age_s();
  // The condition is written so that NaN is refused.
  if (!(age_s >= 0 && std::isfinite(age_s))) {
    return OutOfRange("report.newest_frame_age_s", age_s, 0.0, kMost);
  }
  ASSIGN_OR_RETURN(std::vector<MapContradiction> contradictions, ReadContradictions(proto));
  return AgentReport{.activity = ReadActivity(proto.activity()),
                     .frames = proto.frames(),
                     .tracked = proto.tracked(),
                     .lost = proto.lost(),
                     .dropped = proto.dropped(),
                     .newest_timestamp_ns = newest_ns,
                     .newest_frame_age_s = age_s,
                     .contradictions = std::move(contradictions)};
}

}  // namespace corbslam::services
