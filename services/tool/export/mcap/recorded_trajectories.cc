#include "services/tool/export/mcap/recorded_trajectories.h"

#include <algorithm>
#include <tuple>

#include "absl/strings/str_cat.h"
#include "foxglove/frames.pb.h"
#include "services/tool/export/mcap/foxglove_values.h"
#include "services/tool/export/mcap/frame_names.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// Behind this no time of a recording is: 2^62 ns are 146 years.
constexpr uint64_t kLongest_ns = uint64_t{1} << 62;

struct Moment {
  uint64_t after_ns = 0;  // Since the drive began.
  size_t trajectory = 0;
  size_t pose = 0;

  friend bool operator<(const Moment& a, const Moment& b) {
    return std::tie(a.after_ns, a.trajectory, a.pose) < std::tie(b.after_ns, b.trajectory, b.pose);
  }
};

std::string Suffix(const RecordedTrajectory& trajectory) {
  return absl::StrCat(NumberSuffix(trajectory.drive),
                      IslandSuffix(trajectory.island, trajectory.in_global_frame));
}

absl::StatusOr<std::vector<Moment>> CollectMoments(
    const std::vector<RecordedTrajectory>& trajectories) {
  std::vector<Moment> moments;
  for (size_t i = 0; i < trajectories.size(); ++i) {
    int64_t last_ns = trajectories[i].drive_begins_ns;
    for (size_t j = 0; j < trajectories[i].poses.size(); ++j) {
      const int64_t time_ns = trajectories[i].poses[j].timestamp_ns;
      // Unsigned, the difference of any two times is right.
      const uint64_t after_ns =
          static_cast<uint64_t>(time_ns) - static_cast<uint64_t>(trajectories[i].drive_begins_ns);
      if (time_ns < last_ns || after_ns > kLongest_ns) {
        return absl::InvalidArgumentError(absl::StrCat(
            "robot ", EscapeName(trajectories[i].robot), ": time ", time_ns,
            " ns of its trajectory follows ", last_ns, " ns, must ascend by at most 2^62 ns"));
      }
      last_ns = time_ns;
      moments.push_back({after_ns, i, j});
    }
  }
  std::sort(moments.begin(), moments.end());
  return moments;
}

absl::Status WritePath(const RecordedTrajectory& trajectory, uint64_t time_ns,
                       FoxgloveChannels& channels) {
  foxglove::PosesInFrame path;
  ToFoxglove(time_ns, path.mutable_timestamp());
  path.set_frame_id(IslandFrame(trajectory.island));
  for (const StampedPose& pose : trajectory.poses) {
    ToFoxglove(pose.world_from_camera, path.add_poses());
  }
  const std::string topic = absl::StrCat("trajectory", Suffix(trajectory));
  return channels.Write(RobotTopic(trajectory.robot, topic), time_ns, path);
}

}  // namespace

std::string RobotFrame(const RecordedTrajectory& trajectory, const std::string& what) {
  return absl::StrCat(what, "/", EscapeName(trajectory.robot), Suffix(trajectory));
}

absl::Status WriteTrajectories(const std::vector<RecordedTrajectory>& trajectories,
                               const std::string& what, uint64_t time_ns,
                               FoxgloveChannels& channels) {
  ASSIGN_OR_RETURN(const std::vector<Moment> moments, CollectMoments(trajectories));
  for (const RecordedTrajectory& trajectory : trajectories) {
    RETURN_IF_ERROR(WritePath(trajectory, time_ns, channels));
  }
  for (const Moment& moment : moments) {
    const RecordedTrajectory& trajectory = trajectories[moment.trajectory];
    foxglove::FrameTransform transform;
    SetTransform(time_ns + moment.after_ns, IslandFrame(trajectory.island),
                 RobotFrame(trajectory, what), trajectory.poses[moment.pose].world_from_camera,
                 &transform);
    const std::string topic = absl::StrCat("pose", Suffix(trajectory));
    RETURN_IF_ERROR(
        channels.Write(RobotTopic(trajectory.robot, topic), time_ns + moment.after_ns, transform));
  }
  return absl::OkStatus();
}

}  // namespace corbslam::services
