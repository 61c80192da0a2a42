#include "map_store/testing/store_dump.h"

#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"

namespace corbslam::testing {

using map_store::IslandView;
using map_store::KeyframeInfo;
using map_store::LocalMapInfo;
using map_store::MapStore;
using map_store::MissionStatistics;
using map_store::OverlapInfo;
using map_store::Page;

namespace {

std::string PoseText(const Eigen::Quaterniond& q, const Eigen::Vector3d& t) {
  return absl::StrFormat("%.17g %.17g %.17g %.17g %.17g %.17g %.17g", q.w(), q.x(), q.y(), q.z(),
                         t.x(), t.y(), t.z());
}

std::string DumpPoints(const std::string& mission, const MapStore& store) {
  std::string text;
  const std::vector<IslandView> islands = *store.GlobalMapView(mission);
  for (const IslandView& island : islands) {
    for (const IslandView::Point& point : island.points) {
      const Eigen::Vector3d& x = point.position_in_island;
      absl::StrAppend(&text, ToString(point.id), " ", point.observations,
                      absl::StrFormat(" %.17g %.17g %.17g\n", x.x(), x.y(), x.z()));
    }
  }
  return text;
}

}  // namespace

std::string DumpLocal(const std::string& mission, const MapStore& store) {
  std::string text;
  const Page<LocalMapInfo> maps = *store.ListLocalMaps(mission, {});
  for (const LocalMapInfo& map : maps.items) {
    absl::StrAppend(&text, ToString(map.id), " ", map.agent, " ", map.closed, " ", map.last_batch,
                    " ", map.keyframes, " ", map.settled_keyframes, " ", map.map_points, " ",
                    map.tracked_frames, " ", map.parked_references, "\n");
  }
  const Page<KeyframeInfo> keyframes = *store.ListKeyframes(mission, {}, {});
  for (const KeyframeInfo& keyframe : keyframes.items) {
    absl::StrAppend(
        &text, ToString(keyframe.id), " ", keyframe.payload->timestamp_ns, " ",
        PoseText(keyframe.camera_from_local.rotation, keyframe.camera_from_local.translation), " ",
        ToString(keyframe.parent), " ", keyframe.observed_points, "\n");
    for (const Keypoint& keypoint : keyframe.payload->features.keypoints) {
      absl::StrAppend(&text, keypoint.x_px, ",", keypoint.y_px, " ");
    }
    for (const Descriptor& descriptor : keyframe.payload->features.descriptors) {
      absl::StrAppend(&text, descriptor.words[0] ^ descriptor.words[3], " ");
    }
    absl::StrAppend(&text, "\n");
  }
  return text;
}

std::string DumpGlobal(const std::string& mission, const MapStore& store) {
  const MissionStatistics statistics = *store.GetStatistics(mission);
  std::string text =
      absl::StrCat("revision ", statistics.revision, " islands ", statistics.islands, " points ",
                   statistics.map_points, " accepted ", statistics.overlaps_accepted, "\n");
  const Page<KeyframeInfo> keyframes = *store.ListKeyframes(mission, {}, {});
  for (const KeyframeInfo& keyframe : keyframes.items) {
    absl::StrAppend(
        &text, ToString(keyframe.id), " ", ToString(keyframe.island), " ", keyframe.placed, " ",
        keyframe.revision, " ", keyframe.camera_from_island.scale, " ",
        PoseText(keyframe.camera_from_island.rotation, keyframe.camera_from_island.translation),
        "\n");
  }
  const Page<OverlapInfo> overlaps = *store.ListOverlaps(mission, {}, {});
  for (const OverlapInfo& overlap : overlaps.items) {
    absl::StrAppend(&text, overlap.id, " ", ToString(overlap.overlap.query), " ",
                    ToString(overlap.overlap.candidate), " ", overlap.revision, " ",
                    overlap.overlap.inliers.size(), " ", overlap.note, "\n");
  }
  return text + DumpPoints(mission, store);
}

std::string DumpPlaces(const std::string& mission, const MapStore& store) {
  std::string text;
  const Page<KeyframeInfo> keyframes = *store.ListKeyframes(mission, {}, {});
  for (const KeyframeInfo& keyframe : keyframes.items) {
    absl::StrAppend(
        &text, ToString(keyframe.id), " ", ToString(keyframe.island), " ",
        PoseText(keyframe.camera_from_island.rotation, keyframe.camera_from_island.translation),
        "\n");
  }
  return text + DumpPoints(mission, store);
}

std::string FirstDifference(const std::string& a, const std::string& b) {
  if (a == b) return "";
  const std::vector<std::string> lines_a = absl::StrSplit(a, '\n');
  const std::vector<std::string> lines_b = absl::StrSplit(b, '\n');
  size_t i = 0;
  while (i < lines_a.size() && i < lines_b.size() && lines_a[i] == lines_b[i]) ++i;
  const auto line = [i](const std::vector<std::string>& lines) {
    return i < lines.size() ? lines[i].substr(0, 200) : "(end)";
  };
  return absl::StrCat("line ", i + 1, ": \"", line(lines_a), "\" and \"", line(lines_b), "\"");
}

}  // namespace corbslam::testing
