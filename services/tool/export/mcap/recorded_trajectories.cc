#include "services/tool/export/mcap/recorded_trajectories.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "absl/strings/str_cat.h"
#include "foxglove/frames.pb.h"
#include "services/tool/export/mcap/foxglove_values.h"
#include "services/tool/export/mcap/frame_names.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// Behind this no time of a recording is: 2^62 ns are 146 years.
constexpr uint64_t kLongest_ns = uint64_t{1} << 62;

std::string Suffix(const RecordedTrajectory& trajectory) {
  return absl::StrCat(trajectory.suffix,
                      IslandSuffix(trajectory.island, trajectory.in_global_frame));
}

DrivenPath WayOf(const RecordedTrajectory& trajectory) {
  DrivenPath way;
  auto next = trajectory.pieces.begin();
  for (size_t i = 0; i < trajectory.poses.size(); ++i) {
    const bool begins = next != trajectory.pieces.end() && *next == i;
    if (begins) ++next;
    if (begins || way.empty()) way.emplace_back();
    way.back().push_back(trajectory.poses[i].world_from_camera.translation);
  }
  return way;
}

}  // namespace

std::string RobotFrame(const RecordedTrajectory& trajectory, const std::string& what) {
  return absl::StrCat(what, "/", EscapeName(trajectory.robot), Suffix(trajectory));
}

absl::StatusOr<TrajectoryPlayer> TrajectoryPlayer::Create(
    std::vector<RecordedTrajectory> trajectories, std::string what, RobotColours colours,
    std::optional<uint64_t> begin_ns) {
  TrajectoryPlayer player(std::move(trajectories), std::move(what), std::move(colours));
  RETURN_IF_ERROR(player.Collect(begin_ns));
  return player;
}

absl::Status TrajectoryPlayer::Collect(std::optional<uint64_t> begin_ns) {
  begin_ns_ = begin_ns;
  for (size_t i = 0; i < trajectories_.size(); ++i) {
    const RecordedTrajectory& trajectory = trajectories_[i];
    int64_t last_ns = trajectory.drive_begins_ns;
    if (!begin_ns.has_value() && last_ns < 0) {
      return absl::InvalidArgumentError(
          absl::StrCat("robot ", EscapeName(trajectory.robot), ": its drive begins at ", last_ns,
                       " ns by its own clock, and a recording has no time before 0"));
    }
    for (size_t j = 0; j < trajectory.poses.size(); ++j) {
      const int64_t time_ns = trajectory.poses[j].timestamp_ns;
      // Unsigned, the difference of any two times is right.
      const uint64_t after_ns =
          static_cast<uint64_t>(time_ns) - static_cast<uint64_t>(trajectory.drive_begins_ns);
      if (time_ns < last_ns || after_ns > kLongest_ns) {
        return absl::InvalidArgumentError(absl::StrCat(
            "robot ", EscapeName(trajectory.robot), ": time ", time_ns,
            " ns of its trajectory follows ", last_ns, " ns, must ascend by at most 2^62 ns"));
      }
      last_ns = time_ns;
      moments_.push_back(
          {begin_ns.has_value() ? *begin_ns + after_ns : static_cast<uint64_t>(time_ns), i, j});
    }
  }
  std::sort(moments_.begin(), moments_.end(), [](const Moment& a, const Moment& b) {
    return std::tie(a.time_ns, a.trajectory, a.pose) < std::tie(b.time_ns, b.trajectory, b.pose);
  });
  return absl::OkStatus();
}

absl::Status TrajectoryPlayer::WritePath(const RecordedTrajectory& trajectory, uint64_t time_ns,
                                         FoxgloveChannels& channels) const {
  foxglove::PosesInFrame path;
  ToFoxglove(time_ns, path.mutable_timestamp());
  path.set_frame_id(IslandFrame(trajectory.island));
  for (const StampedPose& pose : trajectory.poses) {
    ToFoxglove(pose.world_from_camera, path.add_poses());
  }
  const std::string suffix = Suffix(trajectory);
  RETURN_IF_ERROR(
      channels.Write(RobotTopic(trajectory.robot, "trajectory" + suffix), time_ns, path));
  return WriteWay(RobotTopic(trajectory.robot, "way" + suffix), trajectory.island,
                  WayOf(trajectory), ColourOf(trajectory.robot, colours_), time_ns, channels);
}

absl::Status TrajectoryPlayer::PlayUntil(uint64_t time_ns, FoxgloveChannels& channels) {
  if (begin_ns_.has_value() && !has_begun_) {
    for (const RecordedTrajectory& trajectory : trajectories_) {
      RETURN_IF_ERROR(WritePath(trajectory, *begin_ns_, channels));
    }
  }
  has_begun_ = true;
  for (; played_ < moments_.size() && moments_[played_].time_ns <= time_ns; ++played_) {
    RETURN_IF_ERROR(Play(moments_[played_], channels));
  }
  return absl::OkStatus();
}

absl::Status TrajectoryPlayer::Play(const Moment& moment, FoxgloveChannels& channels) const {
  const RecordedTrajectory& trajectory = trajectories_[moment.trajectory];
  if (moment.pose == 0 && !begin_ns_.has_value()) {
    RETURN_IF_ERROR(WritePath(trajectory, moment.time_ns, channels));
  }
  foxglove::FrameTransform transform;
  SetTransform(moment.time_ns, IslandFrame(trajectory.island), RobotFrame(trajectory, what_),
               trajectory.poses[moment.pose].world_from_camera, &transform);
  const std::string topic = absl::StrCat("pose", Suffix(trajectory));
  return channels.Write(RobotTopic(trajectory.robot, topic), moment.time_ns, transform);
}

std::optional<uint64_t> TrajectoryPlayer::first_ns() const {
  return moments_.empty() ? std::nullopt : std::optional(moments_.front().time_ns);
}

std::optional<uint64_t> TrajectoryPlayer::last_ns() const {
  return moments_.empty() ? std::nullopt : std::optional(moments_.back().time_ns);
}

}  // namespace corbslam::services
