#include "slam/evaluation/trajectory_io.h"

#include <cmath>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam {
namespace {

absl::StatusOr<Eigen::Quaterniond> MakeRotation(double w, double x, double y, double z,
                                                const std::string& path, int line) {
  const Eigen::Quaterniond rotation(w, x, y, z);
  if (std::abs(rotation.norm() - 1.0) > 0.01) {
    return LineError(path, line, absl::StrCat("quaternion of length ", rotation.norm()));
  }
  return rotation.normalized();
}

absl::StatusOr<StampedPose> ParseTumLine(absl::string_view text, const std::string& path,
                                         int line) {
  const std::vector<absl::string_view> fields =
      absl::StrSplit(text, absl::ByAnyChar(" \t"), absl::SkipEmpty());
  if (fields.size() != 8) {
    return LineError(path, line, absl::StrCat(fields.size(), " fields instead of 8"));
  }
  const absl::StatusOr<int64_t> timestamp_ns = ParseSeconds(fields[0]);
  if (!timestamp_ns.ok()) return LineError(path, line, timestamp_ns.status().message());
  ASSIGN_OR_RETURN(const std::vector<double> n, ParseNumbers(fields, path, line));
  ASSIGN_OR_RETURN(const Eigen::Quaterniond rotation,
                   MakeRotation(n[7], n[4], n[5], n[6], path, line));
  return StampedPose{*timestamp_ns, {rotation, Eigen::Vector3d(n[1], n[2], n[3])}};
}

absl::StatusOr<Rigid3d> ParseKittiLine(absl::string_view text, const std::string& path, int line) {
  const std::vector<absl::string_view> fields =
      absl::StrSplit(text, absl::ByAnyChar(" \t"), absl::SkipEmpty());
  if (fields.size() != 12) {
    return LineError(path, line, absl::StrCat(fields.size(), " fields instead of 12"));
  }
  ASSIGN_OR_RETURN(const std::vector<double> n, ParseNumbers(fields, path, line));
  Eigen::Matrix3d rotation;
  rotation << n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10];
  const double error = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm();
  // Written so that NaN (of infinite products) fails.
  if (!(error <= 0.01) || rotation.determinant() < 0) {
    return LineError(path, line, "fields 1 to 11 hold no rotation");
  }
  return Rigid3d{Eigen::Quaterniond(rotation).normalized(), Eigen::Vector3d(n[3], n[7], n[11])};
}

absl::StatusOr<std::vector<Rigid3d>> ReadKittiPoses(const std::string& path) {
  std::vector<Rigid3d> poses;
  RETURN_IF_ERROR(ForEachLine(path, [&](int line, absl::string_view text) -> absl::Status {
    ASSIGN_OR_RETURN(const Rigid3d pose, ParseKittiLine(text, path, line));
    poses.push_back(pose);
    return absl::OkStatus();
  }));
  return poses;
}

absl::StatusOr<std::vector<int64_t>> ReadTimes(const std::string& path) {
  std::vector<int64_t> times_ns;
  RETURN_IF_ERROR(ForEachLine(path, [&](int line, absl::string_view text) -> absl::Status {
    const absl::StatusOr<int64_t> time_ns = ParseSeconds(text);
    if (!time_ns.ok()) return LineError(path, line, time_ns.status().message());
    times_ns.push_back(*time_ns);
    return absl::OkStatus();
  }));
  return times_ns;
}

absl::StatusOr<StampedPose> ParseEurocLine(absl::string_view text, const std::string& path,
                                           int line) {
  const std::vector<absl::string_view> fields = absl::StrSplit(text, ',');
  if (fields.size() < 8) {
    return LineError(path, line, absl::StrCat(fields.size(), " fields instead of at least 8"));
  }
  int64_t timestamp_ns = 0;
  if (!absl::SimpleAtoi(fields[0], &timestamp_ns)) {
    return LineError(path, line, absl::StrCat("field 1 is no time: ", fields[0]));
  }
  ASSIGN_OR_RETURN(const std::vector<double> n, ParseNumbers(fields, path, line));
  ASSIGN_OR_RETURN(const Eigen::Quaterniond rotation,
                   MakeRotation(n[4], n[5], n[6], n[7], path, line));
  return StampedPose{timestamp_ns, {rotation, Eigen::Vector3d(n[1], n[2], n[3])}};
}

}  // namespace

absl::StatusOr<Trajectory> ReadTumTrajectory(const std::string& path) {
  Trajectory trajectory;
  RETURN_IF_ERROR(ForEachLine(path, [&](int line, absl::string_view text) -> absl::Status {
    ASSIGN_OR_RETURN(const StampedPose pose, ParseTumLine(text, path, line));
    trajectory.push_back(pose);
    return absl::OkStatus();
  }));
  SortByTime(trajectory);
  return trajectory;
}

absl::Status WriteTumTrajectory(const Trajectory& trajectory, const std::string& path) {
  std::vector<std::string> lines;
  lines.reserve(trajectory.size());
  for (const StampedPose& pose : trajectory) {
    const Eigen::Vector3d& t = pose.world_from_camera.translation;
    const Eigen::Quaterniond& q = pose.world_from_camera.rotation;
    lines.push_back(absl::StrFormat("%s %.9f %.9f %.9f %.9f %.9f %.9f %.9f",
                                    FormatSeconds(pose.timestamp_ns), t.x(), t.y(), t.z(), q.x(),
                                    q.y(), q.z(), q.w()));
  }
  return WriteLines(lines, path);
}

absl::StatusOr<Trajectory> ReadKittiTrajectory(const std::string& poses_path,
                                               const std::string& times_path) {
  ASSIGN_OR_RETURN(const std::vector<Rigid3d> poses, ReadKittiPoses(poses_path));
  ASSIGN_OR_RETURN(const std::vector<int64_t> times_ns, ReadTimes(times_path));
  if (poses.size() != times_ns.size()) {
    return absl::InvalidArgumentError(absl::StrCat(poses_path, " has ", poses.size(), " poses, ",
                                                   times_path, " has ", times_ns.size(), " times"));
  }
  Trajectory trajectory;
  for (size_t i = 0; i < poses.size(); ++i) trajectory.push_back({times_ns[i], poses[i]});
  SortByTime(trajectory);
  return trajectory;
}

absl::StatusOr<Trajectory> ReadKittiTrajectory(const std::string& poses_path) {
  constexpr int64_t kFramePeriod_ns = 100'000'000;
  ASSIGN_OR_RETURN(const std::vector<Rigid3d> poses, ReadKittiPoses(poses_path));
  Trajectory trajectory;
  for (const Rigid3d& pose : poses) {
    trajectory.push_back({static_cast<int64_t>(trajectory.size()) * kFramePeriod_ns, pose});
  }
  return trajectory;
}

absl::Status WriteKittiTrajectory(const Trajectory& trajectory, const std::string& path) {
  std::vector<std::string> lines;
  lines.reserve(trajectory.size());
  for (const StampedPose& pose : trajectory) {
    Eigen::Matrix<double, 3, 4> matrix;
    matrix << pose.world_from_camera.rotation.toRotationMatrix(),
        pose.world_from_camera.translation;
    std::vector<std::string> numbers;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        numbers.push_back(absl::StrFormat("%.9e", matrix(row, column)));
      }
    }
    lines.push_back(absl::StrJoin(numbers, " "));
  }
  return WriteLines(lines, path);
}

absl::StatusOr<Trajectory> ReadEurocTrajectory(const std::string& path,
                                               const Rigid3d& body_from_camera) {
  Trajectory trajectory;
  RETURN_IF_ERROR(ForEachLine(path, [&](int line, absl::string_view text) -> absl::Status {
    ASSIGN_OR_RETURN(StampedPose pose, ParseEurocLine(text, path, line));
    pose.world_from_camera = pose.world_from_camera * body_from_camera;
    trajectory.push_back(pose);
    return absl::OkStatus();
  }));
  SortByTime(trajectory);
  return trajectory;
}

}  // namespace corbslam
