#include "slam/evaluation/trajectory_file.h"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"
#include "slam/evaluation/pose_header.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam {
namespace {

namespace fs = std::filesystem;

constexpr absl::string_view kImages = "images.txt";
constexpr absl::string_view kFrame = "frame-";
constexpr absl::string_view kPose = ".pose.txt";
constexpr size_t kColmapImageFields = 10;

bool Exists(const std::string& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

bool IsFolder(const std::string& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

// Shape of the first row; nullopt in a file without rows.
struct Shape {
  size_t fields = 0;
  bool is_euroc = false;
};
absl::StatusOr<std::optional<Shape>> ShapeOf(const std::string& path) {
  std::optional<Shape> shape;
  // A clock that began at 0 has short times, too: then the head of EuRoC's columns tells.
  bool says_nanoseconds = false;
  // The callback's error only ends the reading after one row.
  const absl::Status read = ForEachRow(
      path,
      [&](absl::string_view comment) {
        says_nanoseconds = says_nanoseconds || absl::StrContains(comment, "[ns]");
      },
      [&](const TextRow& row) -> absl::Status {
        int64_t nanoseconds = 0;
        shape = Shape{row.fields.size(), row.has_commas &&
                                             absl::SimpleAtoi(row.fields[0], &nanoseconds) &&
                                             (says_nanoseconds || row.fields[0].size() >= 15)};
        return absl::CancelledError();
      });
  if (!read.ok() && !absl::IsCancelled(read)) return read;
  return shape;
}

absl::StatusOr<std::string> FindTimes(const std::string& path) {
  const std::string beside = fs::path(path).replace_filename("times.txt").string();
  for (const std::string& candidate : {path + ".times", beside}) {
    if (Exists(candidate)) return candidate;
  }
  return absl::NotFoundError(
      absl::StrCat(path, ": poses in KITTI's form have no times, and there is neither ", path,
                   ".times nor ", beside, "; name a file with a time in seconds a line"));
}

absl::StatusOr<TrajectoryReading> ReadFolder(const std::string& path) {
  const std::string images = absl::StrCat(path, "/", kImages);
  if (Exists(images)) return ReadColmapImages(images);
  absl::StatusOr<TrajectoryReading> poses = ReadPoseFiles(path);
  if (!absl::IsNotFound(poses.status())) return poses;
  return absl::InvalidArgumentError(
      absl::StrCat(path, " is a folder without ", kImages, " and ", kFrame, "000000", kPose,
                   ": name a file in it, or a sequence as LAYOUT:DIR"));
}

// Returns the nanoseconds in ROBOT/NANOSECONDS.png.
std::optional<int64_t> TimeInName(absl::string_view name) {
  const size_t slash = name.rfind('/');
  if (slash != absl::string_view::npos) name.remove_prefix(slash + 1);
  int64_t time_ns = 0;
  if (!absl::SimpleAtoi(name.substr(0, name.find('.')), &time_ns)) return std::nullopt;
  return time_ns;
}

absl::Status AddColmapImage(const TextRow& row, const std::string& path, PoseRows& rows) {
  TextRow numbers = row;
  numbers.fields.resize(kColmapImageFields - 2);
  ASSIGN_OR_RETURN(const std::vector<double> n, ParseAnyNumbers(numbers, path));
  const std::optional<int64_t> time_ns = TimeInName(row.fields.back());
  if (!time_ns.has_value()) {
    return LineError(path, row.line,
                     absl::StrCat("picture ", row.fields.back(),
                                  " is not called after its time, as NANOSECONDS.png"));
  }
  if (!AllFinite(n)) {
    rows.LeaveOut(row.line);
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(const Eigen::Quaterniond rotation,
                   RotationFromQuaternion(n[1], n[2], n[3], n[4], path, row.line));
  const Rigid3d camera_from_world{rotation, Eigen::Vector3d(n[5], n[6], n[7])};
  rows.Add(row.line, time_ns, camera_from_world.Inverse());
  return absl::OkStatus();
}

// Returns nullopt when the pose is not finite.
absl::StatusOr<std::optional<Rigid3d>> ReadPoseFile(const std::string& path) {
  std::vector<double> n;
  RETURN_IF_ERROR(ForEachRow(
      path, [](absl::string_view) {},
      [&](const TextRow& row) -> absl::Status {
        ASSIGN_OR_RETURN(const std::vector<double> numbers, ParseAnyNumbers(row, path));
        n.insert(n.end(), numbers.begin(), numbers.end());
        return absl::OkStatus();
      }));
  if (n.size() != 16) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, " has ", n.size(), " numbers instead of 4 rows of 4"));
  }
  if (!AllFinite(n)) return std::nullopt;
  Eigen::Matrix3d matrix;
  matrix << n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10];
  ASSIGN_OR_RETURN(const Eigen::Quaterniond rotation, RotationFromMatrix(matrix, path, 1));
  return Rigid3d{rotation, Eigen::Vector3d(n[3], n[7], n[11])};
}

// Returns 12 for "frame-000012.pose.txt".
std::optional<int> FrameOf(absl::string_view name) {
  int frame = 0;
  if (!absl::ConsumePrefix(&name, kFrame) || !absl::ConsumeSuffix(&name, kPose) ||
      !absl::SimpleAtoi(name, &frame) || frame < 0) {
    return std::nullopt;
  }
  return frame;
}

// Refuses what is no text: recordings, pictures, archives.
absl::Status CheckIsText(const std::string& path) {
  std::string begin(512, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<size_t>(file.gcount()));
  const char* what = nullptr;
  if (absl::StartsWith(begin, "\x89MCAP0")) what = "an MCAP recording";
  if (absl::StartsWith(begin, "#ROSBAG")) what = "a ROS bag";
  // A text in UTF-16 has such bytes, too; who reads it says so.
  const bool is_utf16 = absl::StartsWith(begin, "\xff\xfe") || absl::StartsWith(begin, "\xfe\xff");
  if (what == nullptr && !is_utf16 && begin.find('\0') != std::string::npos) what = "no text";
  if (what == nullptr) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      path, " is ", what,
      ": wanted is a trajectory as text (TUM's, EuRoC's or KITTI's form), as `corbslam "
      "mission export --format tum` writes it"));
}

}  // namespace

absl::StatusOr<TrajectoryReading> ReadTrajectoryFile(const std::string& path,
                                                     const std::string& times_path) {
  if (IsFolder(path)) return ReadFolder(path);
  if (fs::path(path).filename().string() == kImages) return ReadColmapImages(path);
  if (absl::EndsWith(path, ".ply")) {
    return absl::InvalidArgumentError(absl::StrCat(path, " holds points and no trajectory"));
  }
  RETURN_IF_ERROR(CheckIsText(path));
  ASSIGN_OR_RETURN(const std::optional<Shape> shape, ShapeOf(path));
  if (shape.has_value() && (shape->fields == 12 || !times_path.empty())) {
    std::string times = times_path;
    if (times.empty()) {
      ASSIGN_OR_RETURN(times, FindTimes(path));
    }
    return ReadKittiFile(path, times);
  }
  if (shape.has_value() && shape->is_euroc) return ReadEurocFile(path, Rigid3d());
  return ReadTumFile(path);
}

absl::StatusOr<TrajectoryReading> ReadColmapImages(const std::string& path) {
  PoseRows rows(path);
  PoseHeader header;
  RETURN_IF_ERROR(ForEachRow(
      path, [&](absl::string_view comment) { ReadPoseHeader(comment, header); },
      [&](const TextRow& row) -> absl::Status {
        // The other lines are keypoints: numbers only.
        double ignored = 0;
        const bool is_image = row.fields.size() == kColmapImageFields &&
                              !absl::SimpleAtod(row.fields.back(), &ignored);
        return is_image ? AddColmapImage(row, path, rows) : absl::OkStatus();
      }));
  TrajectoryReading reading = rows.Finish();
  reading.poses_of = header.poses_of;
  return reading;
}

absl::StatusOr<TrajectoryReading> ReadPoseFiles(const std::string& directory, double rate_hz) {
  std::error_code error;
  std::map<int, std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, error)) {
    const std::optional<int> frame = FrameOf(entry.path().filename().string());
    if (frame.has_value()) files[*frame] = entry.path().string();
  }
  if (files.empty()) {
    return absl::NotFoundError(absl::StrCat(directory, " has no file ", kFrame, "000000", kPose));
  }
  PoseRows rows(directory, "frame");
  for (const auto& [frame, path] : files) {
    ASSIGN_OR_RETURN(const std::optional<Rigid3d> pose, ReadPoseFile(path));
    if (pose.has_value()) {
      rows.Add(frame, std::llround(frame * 1e9 / rate_hz), *pose);
    } else {
      rows.LeaveOut(frame);
    }
  }
  return rows.Finish();
}

}  // namespace corbslam
