#include <algorithm>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/time/time.h"
#include "services/client/store/local_map_names.h"
#include "services/convert/geometry.h"
#include "services/convert/resource_names.h"
#include "services/tool/mission/event_text.h"
#include "services/tool/mission/mission_settings.h"
#include "services/tool/mission/mission_summary.h"
#include "services/tool/mission/summary_pairs.h"

namespace corbslam::services {
namespace {

// Robots report every four seconds: an older report says that the line, or the robot, hangs.
constexpr double kOldReport_s = 15;

std::string Count(uint64_t count, const std::string& what) {
  return absl::StrCat(count, " ", what, count == 1 ? "" : "s");
}

// Returns an empty text if fusion goes on.
std::string FormatWorkers(const v1::Mission& mission) {
  const std::string waiting = Count(mission.waiting_queries(), "look-up") + " waiting";
  if (mission.lacks_fusion_worker()) {
    if (mission.waiting_queries() == 0) return "";
    return waiting +
           ": the store has no fusion worker (map_store --worker or "
           "--in-process-worker)\n";
  }
  if (mission.worker_away_since_ns() == 0) return "";
  return absl::StrCat(
      waiting, ": no fusion worker takes requests since ",
      absl::FormatTime("%Y-%m-%d %H:%M:%S", absl::FromUnixNanos(mission.worker_away_since_ns()),
                       absl::LocalTimeZone()),
      " (", mission.worker_error(), ")\n");
}

std::string Mib(uint64_t bytes) {
  return absl::StrFormat("%.1f", static_cast<double>(bytes) / (1 << 20));
}

// Returns an empty text if nothing is known to be damaged.
std::string FormatDamage(const v1::Mission& mission) {
  return mission.damage().empty() ? "" : absl::StrCat("DAMAGED: ", mission.damage(), "\n");
}

std::string FormatMission(const v1::Mission& mission) {
  return absl::StrCat(
      "Mission ", LastSegment(mission.name()), ": ", Count(mission.agents(), "robot"), ", ",
      Count(mission.local_maps(), "local map"), " in ", Count(mission.islands(), "island"), ", ",
      Count(mission.keyframes(), "keyframe"), ", ", Count(mission.map_points(), "map point"),
      "; revision ", mission.revision(), ", fusion ", DescribeFusion(mission), "; about ",
      Mib(mission.memory_bytes()), " MiB in memory, ", Mib(mission.disk_bytes()), " MiB on disk\n",
      mission.asleep() ? "It was asleep until now\n" : "", FormatSettings(mission),
      FormatDamage(mission), FormatWorkers(mission));
}

std::string DescribeState(const v1::Mission& mission) {
  if (!mission.damage().empty()) return "damaged: see `corbslam mission show`";
  return mission.asleep() ? "asleep" : DescribeFusion(mission);
}

// Says where the robot was last, as "1.20 0.00 3.40" in the global frame, and whether it was lost
// since.
std::string DescribeLastPose(const v1::MissionAgent& agent, const LocalMapNames& names) {
  if (!agent.has_last_pose()) return "-";
  const v1::LastPose& pose = agent.last_pose();
  const auto camera_from_island = FromProto(pose.camera_from_island());
  if (!camera_from_island.ok()) return "-";
  const Eigen::Vector3d centre = CameraCentre(*camera_from_island);
  // What rounds to 0 is not below it.
  const Eigen::Vector3d shown = (100 * centre).array().round() / 100 + 0.0;
  std::string text = absl::StrFormat("%.2f %.2f %.2f", shown.x(), shown.y(), shown.z());
  if (!pose.in_global_frame()) {
    const auto island = names.find(pose.island());
    absl::StrAppend(&text, " in the frame of ",
                    island == names.end() ? LastSegment(pose.island()) : island->second);
  }
  if (pose.lost_since()) absl::StrAppend(&text, ", lost since");
  return text;
}

std::string DescribeActivity(const v1::AgentReport& report) {
  switch (report.activity()) {
    case v1::AGENT_ACTIVITY_INITIALISING:
      return "initialising";
    case v1::AGENT_ACTIVITY_TRACKING:
      return "tracking";
    case v1::AGENT_ACTIVITY_LOST:
      return "lost";
    case v1::AGENT_ACTIVITY_WAITING:
      return "waiting";
    case v1::AGENT_ACTIVITY_FINISHED:
      return "finished";
    default:
      return "-";
  }
}

// Says what the robot is doing now, as "tracking" or "no frame for 12 s"; "-" where nobody knows.
std::string DescribeDoing(const v1::MissionAgent& agent) {
  if (!agent.connected()) {
    if (agent.left_on_purpose()) return "ended";
    return agent.has_report() ? "its line broke" : "-";
  }
  if (!agent.has_report()) return agent.localise_only() ? "localises" : "-";
  const v1::AgentReport& report = agent.report();
  const double age_s = report.newest_frame_age_s() + agent.report_age_s();
  std::string text = DescribeActivity(report);
  if (report.activity() == v1::AGENT_ACTIVITY_WAITING) {
    text = report.frames() == 0 ? "no frame yet" : absl::StrFormat("no frame for %.0f s", age_s);
  } else if (agent.report_age_s() > kOldReport_s) {
    absl::StrAppendFormat(&text, ", %.0f s ago", agent.report_age_s());
  }
  return agent.localise_only() ? absl::StrCat(text, ", localises") : text;
}

// Sets how many frames were tracked and lost; "-" where nobody knows. What a robot that only
// localises tracked is in no local map.
struct FrameColumns {
  std::string tracked;
  std::string lost;
};
FrameColumns CountFrames(const v1::MissionAgent& agent, const v1::LocalMap& sum) {
  if (!agent.localise_only()) {
    return {absl::StrCat(sum.tracked_frames()), absl::StrCat(sum.lost_frames())};
  }
  if (!agent.has_report()) return {"-", "-"};
  return {absl::StrCat(agent.report().tracked()), absl::StrCat(agent.report().lost())};
}

// Writes one line for each of others' local maps that the robot goes without.
std::string FormatContradictions(const std::string& mission, const v1::MissionAgent& agent,
                                 const LocalMapNames& names) {
  std::string text;
  for (const v1::MapContradiction& found : agent.report().contradictions()) {
    const std::string local_map = LocalMapName(LastSegment(mission), LocalMapId{found.local_map()});
    const auto name = names.find(local_map);
    absl::StrAppend(&text, LastSegment(agent.name()), " goes without ",
                    name == names.end() ? LastSegment(local_map) : name->second, ", which is ",
                    DescribeContradiction(found), "\n");
  }
  return text;
}

// Writes one line for each robot, with its local maps added up, and below what they go without.
std::string FormatRobots(const MissionSummary& summary) {
  const LocalMapNames names = ShortNames(summary.local_maps);
  std::string text = absl::StrFormat("\n%-16s %-9s %10s %9s %9s %9s %9s  %-23s %s\n", "robot",
                                     "connected", "local maps", "keyframes", "points", "tracked",
                                     "lost", "doing", "last seen at");
  for (const v1::MissionAgent& agent : summary.agents) {
    v1::LocalMap sum;
    for (const v1::LocalMap& local_map : summary.local_maps) {
      if (local_map.agent() != agent.name()) continue;
      sum.set_keyframes(sum.keyframes() + local_map.keyframes());
      sum.set_map_points(sum.map_points() + local_map.map_points());
      sum.set_tracked_frames(sum.tracked_frames() + local_map.tracked_frames());
      sum.set_lost_frames(sum.lost_frames() + local_map.lost_frames());
    }
    const FrameColumns frames = CountFrames(agent, sum);
    absl::StrAppendFormat(&text, "%-16s %-9s %10d %9d %9d %9s %9s  %-23s %s\n",
                          LastSegment(agent.name()), agent.connected() ? "yes" : "no",
                          agent.local_maps_size(), sum.keyframes(), sum.map_points(),
                          frames.tracked, frames.lost, DescribeDoing(agent),
                          DescribeLastPose(agent, names));
  }
  for (const v1::MissionAgent& agent : summary.agents) {
    text += FormatContradictions(summary.mission.name(), agent, names);
  }
  return text;
}

// Returns "alpha/1 to alpha/7" of the local maps that became parts of this one; empty if none did.
// An older store counts them only.
std::string DescribeParts(const v1::LocalMap& local_map) {
  if (local_map.joined_numbers().empty()) {
    return local_map.joined_local_maps().empty()
               ? ""
               : Count(static_cast<uint64_t>(local_map.joined_local_maps_size()), "part");
  }
  std::vector<uint32_t> numbers(local_map.joined_numbers().begin(),
                                local_map.joined_numbers().end());
  std::sort(numbers.begin(), numbers.end());
  return DescribeNumbers(LastSegment(local_map.agent()), numbers);
}

// Says which lengths are no metres; nothing where all are.
std::string FormatWithoutMetres(const MissionSummary& summary, const LocalMapNames& names) {
  std::vector<std::string> own;
  std::vector<std::string> all;
  for (const v1::LocalMap& local_map : summary.local_maps) {
    if (!local_map.without_metres()) continue;
    (local_map.island_without_metres() ? all : own).push_back(names.at(local_map.name()));
  }
  std::string text;
  if (!all.empty()) {
    absl::StrAppend(&text, "without metres: ", absl::StrJoin(all, ", "),
                    " (made with one camera alone; no map with metres is merged with them)\n");
  }
  if (!own.empty()) {
    absl::StrAppend(
        &text, "without metres of their own: ", absl::StrJoin(own, ", "),
        " (made with one camera alone; the maps that they are merged with give them)\n");
  }
  return text;
}

std::string FormatLocalMaps(const MissionSummary& summary) {
  const LocalMapNames names = ShortNames(summary.local_maps);
  std::string text =
      absl::StrFormat("\n%-16s %-16s %-16s %-6s %9s %9s %-6s %s\n", "local map", "id", "island",
                      "global", "keyframes", "points", "closed", "parts");
  for (const v1::LocalMap& local_map : summary.local_maps) {
    const auto island = names.find(local_map.island());
    const std::string parts = DescribeParts(local_map);
    absl::StrAppendFormat(
        &text, "%-16s %-16s %-16s %-6s %9d %9d %-6s %s\n", names.at(local_map.name()),
        LastSegment(local_map.name()), island == names.end() ? "-" : island->second,
        local_map.in_global_frame() ? "yes" : "no", local_map.keyframes(), local_map.map_points(),
        local_map.closed() ? "yes" : "no", parts.empty() ? "-" : parts);
  }
  return text + FormatWithoutMetres(summary, names);
}

// Says what the store itself let go of; nothing if that is nothing.
std::string FormatRetired(const MissionSummary& summary) {
  uint64_t keyframes = 0;
  uint64_t points = 0;
  for (const v1::LocalMap& local_map : summary.local_maps) {
    keyframes += local_map.retired_keyframes();
    points += local_map.faded_map_points();
  }
  if (keyframes + points == 0) return "";
  return absl::StrCat("of closed local maps the store let go of ", Count(keyframes, "keyframe"),
                      " that others stand in for and ", Count(points, "point"), " that vanished\n");
}

// Says how many sessions have become parts of others; nothing if none has.
std::string FormatJoined(const MissionSummary& summary) {
  uint64_t parts = 0;
  for (const v1::LocalMap& local_map : summary.local_maps) {
    parts += static_cast<uint64_t>(local_map.joined_local_maps_size());
  }
  if (parts == 0) return "";
  return absl::StrCat(Count(parts, "closed local map"), " became parts of others\n");
}

// Says what was never compared, which tells nothing of the places.
std::string DescribeUncompared(const PairOverlaps& pair) {
  std::vector<std::string> parts;
  if (pair.waiting > 0) {
    parts.push_back(Count(pair.waiting, "look-up") + " waiting for a fusion worker");
  }
  if (pair.failed > 0) {
    parts.push_back(Count(pair.failed, "look-up") + " given up because fusion workers failed");
  }
  return absl::StrJoin(parts, "; ");
}

std::string DescribeNoOverlap(const PairOverlaps& pair, const MissionSummary& summary) {
  if (pair.is_too_early) return "too few keyframes to be compared yet";
  if (summary.statistics.failed_requests() > 0) {
    return absl::StrCat("no overlap found, but ", summary.statistics.failed_requests(),
                        " requests of this mission failed");
  }
  return "no two keyframes share enough words to be compared";
}

std::string FormatPair(const PairOverlaps& pair, const MissionSummary& summary) {
  std::vector<std::string> parts;
  if (pair.accepted > 0) {
    parts.push_back(
        absl::StrCat(pair.accepted, " accepted (up to ", pair.most_inliers, " inliers)"));
  }
  for (const auto& [verdict, count] : pair.verdicts) {
    if (verdict == v1::OVERLAP_VERDICT_ACCEPTED) continue;
    parts.push_back(absl::StrCat(count, " refused: ", DescribeVerdict(verdict)));
  }
  if (const std::string uncompared = DescribeUncompared(pair); !uncompared.empty()) {
    parts.push_back(uncompared);
  }
  if (parts.empty()) parts.push_back(DescribeNoOverlap(pair, summary));
  return absl::StrJoin(parts, "; ");
}

std::string FormatOverlaps(const MissionSummary& summary) {
  const auto pairs = CountPairs(summary);
  int accepted = 0;
  for (const auto& [names, pair] : pairs) accepted += pair.accepted;
  std::string text = absl::StrCat("\n", Count(summary.overlaps.size(), "overlap"), " verified, ",
                                  accepted, " accepted\n");
  for (const auto& [names, pair] : pairs) {
    absl::StrAppend(&text, "  ", names.first, names.first == names.second ? ", loops" : "");
    if (names.first != names.second) {
      absl::StrAppend(&text, " and ", names.second, pair.same_island ? ", fused" : ", apart");
    }
    absl::StrAppend(&text, ": ", FormatPair(pair, summary), "\n");
  }
  return text;
}

}  // namespace

std::string DescribeFusion(const v1::Mission& mission) {
  if (mission.lacks_fusion_worker()) return "has no worker";
  if (mission.worker_away_since_ns() != 0) return "waits for a worker";
  return mission.fusion_idle() ? "idle" : "busy";
}

std::string DescribeVerdict(v1::OverlapVerdict verdict) {
  switch (verdict) {
    case v1::OVERLAP_VERDICT_ACCEPTED:
      return "accepted";
    case v1::OVERLAP_VERDICT_TOO_FEW_WORD_MATCHES:
      return "too few keypoints look alike";
    case v1::OVERLAP_VERDICT_TOO_FEW_RANSAC_INLIERS:
      return "no motion explains enough of what looks alike";
    case v1::OVERLAP_VERDICT_TOO_FEW_REFINED_INLIERS:
      return "too few pairs stayed after refinement";
    case v1::OVERLAP_VERDICT_TOO_FEW_PROJECTED_MATCHES:
      return "too few neighbouring points are where they should be";
    case v1::OVERLAP_VERDICT_NO_SECOND_KEYFRAME:
      return "no second pair of keyframes agrees";
    case v1::OVERLAP_VERDICT_WRONG_SCALE:
      return "the scales disagree, or are not known";
    case v1::OVERLAP_VERDICT_BENDS_GRAPH:
      return "contradicts what is known";
    case v1::OVERLAP_VERDICT_TAKEN_BACK:
      return "taken back by somebody";
    default:
      return absl::StrCat("verdict ", static_cast<int>(verdict));
  }
}

std::string FormatMissions(const std::vector<v1::Mission>& missions) {
  std::string text = absl::StrFormat("%-40s %6s %6s %7s %9s %9s %8s %10s %10s %s\n", "mission",
                                     "agents", "maps", "islands", "keyframes", "points", "revision",
                                     "memory MiB", "disk MiB", "fusion");
  for (const v1::Mission& mission : missions) {
    absl::StrAppendFormat(&text, "%-40s %6d %6d %7d %9d %9d %8d %10s %10s %s\n", mission.name(),
                          mission.agents(), mission.local_maps(), mission.islands(),
                          mission.keyframes(), mission.map_points(), mission.revision(),
                          Mib(mission.asleep() ? 0 : mission.memory_bytes()),
                          Mib(mission.disk_bytes()), DescribeState(mission));
  }
  return text;
}

std::string FormatSummary(const MissionSummary& summary) {
  return absl::StrCat(FormatMission(summary.mission), FormatRobots(summary),
                      FormatLocalMaps(summary), FormatRetired(summary), FormatJoined(summary),
                      FormatOverlaps(summary));
}

}  // namespace corbslam::services
