#include "services/tool/evaluation/past_picture.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "services/tool/evaluation/picture.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr size_t kMostMoments = 16;

// Returns one island as the served map of a moment.
ServedMap ToServed(const ToldMap& past, const ToldMap::Island& island) {
  ServedMap map;
  for (const auto& [id, keyframe] : island.keyframes) {
    map.keyframes.push_back(
        {id, keyframe.parent, past.AgentOf(id.local_map), keyframe.island_from_camera});
  }
  for (const auto& [id, position] : island.points) map.points.push_back(position.cast<double>());
  return map;
}

std::string NameIsland(const MapPicture& picture, bool is_global) {
  std::set<std::string> robots;
  for (const MapPicture::Robot& robot : picture.robots) {
    robots.insert(robot.name.empty() ? "?" : robot.name);
  }
  return absl::StrCat(absl::StrJoin(robots, ", "), is_global ? "" : " (not fused)");
}

absl::StatusOr<size_t> ParseMoment(absl::string_view text, const std::vector<uint64_t>& told) {
  const std::string known =
      absl::StrCat("; there are revisions ", told.front(), " to ", told.back());
  absl::string_view number = absl::StripAsciiWhitespace(text);
  if (absl::ConsumeSuffix(&number, "%")) {
    double percent = 0;
    // The comparison is written so that NaN is refused.
    if (!absl::SimpleAtod(number, &percent) || !(percent >= 0 && percent <= 100)) {
      return absl::InvalidArgumentError(
          absl::StrCat("--at ", text, ": must be 0% to 100%, or a revision", known));
    }
    return static_cast<size_t>(std::lround(percent / 100 * static_cast<double>(told.size() - 1)));
  }
  uint64_t revision = 0;
  if (!absl::SimpleAtoi(number, &revision) || revision < told.front() || revision > told.back()) {
    return absl::InvalidArgumentError(
        absl::StrCat("--at ", text, ": must be a revision or a share as 25%", known));
  }
  const auto after = std::upper_bound(told.begin(), told.end(), revision);
  return static_cast<size_t>(after - told.begin()) - 1;
}

}  // namespace

MapSnapshot ComposeSnapshot(const ToldMap& past, const std::string& own,
                            const FusedAccuracy& accuracy) {
  MapSnapshot snapshot;
  const size_t keyframes = past.CountKeyframes();
  snapshot.title = absl::StrCat("revision ", past.revision, ", ", keyframes,
                                keyframes == 1 ? " keyframe" : " keyframes");
  for (const auto& [id, island] : past.islands) {
    if (island.keyframes.empty()) continue;
    // The truth is known in the global frame only.
    MapPicture map = ComposePicture(ToServed(past, island), own,
                                    island.in_global_frame ? accuracy : FusedAccuracy{});
    map.title = NameIsland(map, island.in_global_frame);
    snapshot.islands.push_back({id.value, island.in_global_frame, std::move(map)});
  }
  return snapshot;
}

absl::Status ForEachMoment(const std::vector<v1::WatchMapResponse>& past,
                           const std::function<absl::Status(size_t, const ToldMap&)>& use) {
  ToldMap map;
  size_t number = 0;
  for (const v1::WatchMapResponse& message : past) {
    RETURN_IF_ERROR(map.Apply(message));
    if (!message.continues()) RETURN_IF_ERROR(use(number++, map));
  }
  return absl::OkStatus();
}

std::vector<uint64_t> RevisionsOf(const std::vector<v1::WatchMapResponse>& past) {
  std::vector<uint64_t> told;
  for (const v1::WatchMapResponse& message : past) {
    if (!message.continues()) told.push_back(message.revision());
  }
  return told;
}

absl::StatusOr<std::vector<size_t>> ParseMoments(const std::string& text,
                                                 const std::vector<uint64_t>& told) {
  if (told.empty()) return absl::InvalidArgumentError("--at: the mission has no past");
  std::vector<size_t> moments;
  for (const absl::string_view part : absl::StrSplit(text, ',')) {
    ASSIGN_OR_RETURN(moments.emplace_back(), ParseMoment(part, told));
  }
  if (moments.size() > kMostMoments) {
    return absl::InvalidArgumentError(
        absl::StrCat("--at names ", moments.size(), " moments, at most ", kMostMoments));
  }
  return moments;
}

}  // namespace corbslam::services
