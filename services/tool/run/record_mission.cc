#include "services/tool/run/record_mission.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "corbslam/v1/viewer.pb.h"
#include "services/convert/resource_names.h"
#include "services/tool/mission/mission_summary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr uint32_t kMoments = 60;
constexpr size_t kMostRecordedOverlaps = 1000;

// Messages that tell a map.
struct MapMessages {
  std::vector<std::string> messages;
  size_t bytes = 0;
  uint32_t moments = 0;
  bool is_too_long = false;  // Some are missing.
};

// Which of its messages are read.
struct MapPart {
  bool with_past = false;
  bool with_points = false;
};

absl::StatusOr<MapMessages> ReadMessages(StoreReader& store, const MapPart& part,
                                         size_t most_bytes) {
  MapMessages read;
  const auto take = [&](const v1::WatchMapResponse& message) {
    read.messages.push_back(message.SerializeAsString());
    read.bytes += read.messages.back().size();
    if (!message.continues()) ++read.moments;
    read.is_too_long = read.bytes > most_bytes;
    return read.is_too_long ? absl::CancelledError("it is too long") : absl::OkStatus();
  };
  const absl::Status status = part.with_past ? store.ReadPast(kMoments, part.with_points, take)
                                             : store.ReadPresent(part.with_points, take);
  if (!read.is_too_long) RETURN_IF_ERROR(status);
  return read;
}

// Records as much of the map as is short enough.
absl::Status RecordMap(StoreReader& store, const RecordOptions& options, ShownMission& recorded) {
  for (const bool with_points : {true, false}) {
    for (const bool with_past : {true, false}) {
      if (with_past && !options.has_journal) continue;
      ASSIGN_OR_RETURN(MapMessages read,
                       ReadMessages(store, {with_past, with_points}, options.most_bytes));
      if (read.is_too_long) continue;
      recorded.map = std::move(read.messages);
      recorded.has_points = with_points;
      recorded.has_past = read.moments > 1;
      return absl::OkStatus();
    }
  }
  return absl::ResourceExhaustedError(
      absl::StrCat("the map is longer than ", options.most_bytes, " bytes even without points"));
}

// Says of robots whose sessions still stand that they have finished. Returns how many others are
// connected.
uint32_t EndSessions(const std::vector<std::string>& robots, v1::MissionPulse& pulse) {
  uint32_t connected = 0;
  for (v1::MissionAgent& agent : *pulse.mutable_agents()) {
    if (!agent.connected()) continue;
    if (std::ranges::find(robots, LastSegment(agent.name())) == robots.end()) {
      ++connected;
      continue;
    }
    agent.clear_connected();
    agent.clear_up_to_date();
    agent.set_left_on_purpose(true);
  }
  return connected;
}

// Returns what a viewer would tell of the mission, without what its page does not show.
v1::MissionPulse MakePulse(const MissionSummary& summary, const std::vector<std::string>& robots) {
  v1::MissionPulse pulse;
  pulse.set_time_ns(absl::GetCurrentTimeNanos());
  pulse.set_store_answers(true);
  *pulse.mutable_mission() = summary.mission;
  for (const v1::MissionAgent& agent : summary.agents) *pulse.add_agents() = agent;
  for (const v1::LocalMap& local_map : summary.local_maps) *pulse.add_local_maps() = local_map;
  *pulse.mutable_statistics() = summary.statistics;
  const uint32_t connected = EndSessions(robots, pulse);
  pulse.mutable_mission()->set_connected_agents(connected);
  pulse.mutable_statistics()->set_connected_agents(connected);
  pulse.mutable_statistics()->clear_merge_ms();
  pulse.mutable_statistics()->clear_adjustments();
  pulse.mutable_statistics()->clear_uncompared();
  return pulse;
}

// Of too many overlaps those that were refused last are left out.
std::vector<std::string> EncodeOverlaps(std::vector<v1::Overlap> overlaps) {
  std::stable_partition(overlaps.begin(), overlaps.end(), [](const v1::Overlap& overlap) {
    return overlap.verdict() == v1::OVERLAP_VERDICT_ACCEPTED;
  });
  overlaps.resize(std::min(overlaps.size(), kMostRecordedOverlaps));
  std::sort(overlaps.begin(), overlaps.end(),
            [](const v1::Overlap& a, const v1::Overlap& b) { return a.number() < b.number(); });
  std::vector<std::string> encoded;
  for (const v1::Overlap& overlap : overlaps) encoded.push_back(overlap.SerializeAsString());
  return encoded;
}

}  // namespace

absl::StatusOr<ShownMission> RecordMission(StoreReader& store, const std::string& mission,
                                           const RecordOptions& options) {
  ShownMission recorded;
  recorded.mission = mission;
  RETURN_IF_ERROR(RecordMap(store, options, recorded));
  ASSIGN_OR_RETURN(MissionSummary summary, ReadSummary(store.channel(), mission));
  recorded.pulse = MakePulse(summary, options.robots).SerializeAsString();
  recorded.overlaps = EncodeOverlaps(std::move(summary.overlaps));
  return recorded;
}

}  // namespace corbslam::services
