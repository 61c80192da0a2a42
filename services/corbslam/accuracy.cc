#include "services/corbslam/accuracy.h"

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <utility>

#include "client_agent/source/euroc_calibration.h"
#include "client_agent/source/frame_reader.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

// One recorded sequence: its truth and the time from which errors count again.
struct Sequence {
  std::optional<Trajectory> truth;
  std::optional<int64_t> from_ns;  // None: it is shorter than that.
};

using Sequences = std::map<std::pair<SourceLayout, std::string>, Sequence>;

std::pair<SourceLayout, std::string> KeyOf(const SourceSpec& source) {
  return {source.layout, source.directory};
}

absl::StatusOr<Sequence> ReadSequence(const SourceSpec& source, size_t from_frame) {
  Sequence sequence;
  ASSIGN_OR_RETURN(sequence.truth, ReadGroundTruth(source));
  ASSIGN_OR_RETURN(const std::unique_ptr<FrameReader> reader, OpenReader(source));
  if (from_frame < reader->frame_count()) sequence.from_ns = reader->timestamp_ns(from_frame);
  return sequence;
}

absl::StatusOr<Sequences> ReadSequences(const std::vector<RobotPaths>& robots, size_t from_frame) {
  Sequences sequences;
  for (const RobotPaths& robot : robots) {
    if (sequences.contains(KeyOf(robot.source))) continue;
    ASSIGN_OR_RETURN(sequences[KeyOf(robot.source)], ReadSequence(robot.source, from_frame));
  }
  return sequences;
}

// Nullopt where there are too few poses.
std::optional<AbsoluteError> ErrorOf(const std::vector<PosePair>& pairs, Alignment alignment) {
  const absl::StatusOr<AbsoluteError> error = ComputeAbsoluteError(pairs, alignment);
  return error.ok() ? std::optional(*error) : std::nullopt;
}

std::optional<double> AteOf(const Trajectory& estimate, const Sequence& sequence,
                            Alignment alignment) {
  const auto error = ErrorOf(AssociateByTime(estimate, *sequence.truth), alignment);
  return error.has_value() ? std::optional(error->rmse_m) : std::nullopt;
}

RobotAccuracy ComputeRobotAccuracy(const RobotPaths& robot, const Sequence& sequence,
                                   Alignment alignment) {
  if (!sequence.truth.has_value()) return {};
  const Trajectory global = ToTrajectory(robot.global);
  const Trajectory estimate = CountLocalMaps(robot.local) == 1 ? ToTrajectory(robot.local) : global;
  RobotAccuracy accuracy;
  accuracy.ate_m = AteOf(estimate, sequence, alignment);
  accuracy.ate_global_m = AteOf(global, sequence, alignment);
  if (sequence.from_ns.has_value()) {
    accuracy.ate_from_frame_m = AteOf(KeepFrom(estimate, *sequence.from_ns), sequence, alignment);
  }
  return accuracy;
}

// The pairs of all robots that played `key`.
std::vector<PosePair> PairToTrajectory(const std::vector<RobotPaths>& robots,
                                       const std::pair<SourceLayout, std::string>& key,
                                       const Trajectory& truth, int64_t from_ns) {
  std::vector<PosePair> pairs;
  for (const RobotPaths& robot : robots) {
    if (KeyOf(robot.source) != key) continue;
    const std::vector<PosePair> own =
        AssociateByTime(KeepFrom(ToTrajectory(robot.global), from_ns), truth);
    pairs.insert(pairs.end(), own.begin(), own.end());
  }
  return pairs;
}

// Over one path that runs through all robots' parts.
std::optional<RelativeError> FusedRelativeError(const std::vector<RobotPaths>& robots,
                                                const Trajectory& truth) {
  std::vector<Trajectory> parts;
  for (const RobotPaths& robot : robots) parts.push_back(ToTrajectory(robot.global));
  return ComputeRelativeError(AssociateByTime(MergeByTime(parts), truth));
}

// The truth while the robots that played `key` were on their way.
Trajectory CutTruth(const std::vector<RobotPaths>& robots,
                    const std::pair<SourceLayout, std::string>& key, const Trajectory& truth) {
  int64_t first_ns = std::numeric_limits<int64_t>::max();
  int64_t last_ns = std::numeric_limits<int64_t>::min();
  for (const RobotPaths& robot : robots) {
    if (KeyOf(robot.source) != key) continue;
    for (const StampedPose& pose : ToTrajectory(robot.global)) {
      first_ns = std::min(first_ns, pose.timestamp_ns);
      last_ns = std::max(last_ns, pose.timestamp_ns);
    }
  }
  Trajectory cut;
  for (const StampedPose& pose : truth) {
    if (pose.timestamp_ns >= first_ns && pose.timestamp_ns <= last_ns) cut.push_back(pose);
  }
  return cut;
}

// Every local map of the robot is connected to the global frame.
bool IsAllGlobal(const RobotPaths& robot) {
  return !robot.global.empty() && CountLocalMaps(robot.global) == CountLocalMaps(robot.local);
}

FusedAccuracy ComputeFusedAccuracy(const std::vector<RobotPaths>& robots,
                                   const Sequences& sequences, Alignment alignment) {
  const auto in_global = std::find_if(
      robots.begin(), robots.end(), [](const RobotPaths& robot) { return !robot.global.empty(); });
  if (in_global == robots.end()) return {};
  const Sequence& sequence = sequences.at(KeyOf(in_global->source));
  if (!sequence.truth.has_value()) return {};
  FusedAccuracy accuracy;
  accuracy.truth = CutTruth(robots, KeyOf(in_global->source), *sequence.truth);
  const auto pairs_from = [&](int64_t from_ns) {
    return PairToTrajectory(robots, KeyOf(in_global->source), *sequence.truth, from_ns);
  };
  const std::optional<AbsoluteError> all =
      ErrorOf(pairs_from(std::numeric_limits<int64_t>::min()), alignment);
  if (all.has_value()) accuracy.truth_from_global = all->truth_from_estimate;
  if (sequences.size() > 1 || !std::all_of(robots.begin(), robots.end(), IsAllGlobal)) {
    return accuracy;
  }
  accuracy.all = all;
  if (sequence.from_ns.has_value()) {
    accuracy.from_frame = ErrorOf(pairs_from(*sequence.from_ns), alignment);
  }
  accuracy.relative = FusedRelativeError(robots, *sequence.truth);
  return accuracy;
}

}  // namespace

absl::StatusOr<std::optional<Trajectory>> ReadGroundTruth(const SourceSpec& source) {
  const std::string& directory = source.directory;
  absl::StatusOr<Trajectory> truth;
  switch (source.layout) {
    case SourceLayout::kKitti:
      truth = ReadKittiTrajectory(directory + "/poses.txt", directory + "/times.txt");
      break;
    case SourceLayout::kTum:
      truth = ReadTumTrajectory(directory + "/groundtruth.txt");
      break;
    case SourceLayout::kEuroc: {
      const std::string root = EurocRoot(directory);
      ASSIGN_OR_RETURN(const EurocCamera camera, ReadEurocCamera(root + "/cam0/sensor.yaml"));
      truth = ReadEurocTrajectory(root + "/state_groundtruth_estimate0/data.csv",
                                  camera.body_from_camera);
      break;
    }
  }
  if (absl::IsNotFound(truth.status())) return std::nullopt;
  RETURN_IF_ERROR(truth.status());
  return *std::move(truth);
}

absl::StatusOr<Accuracy> ComputeAccuracy(const std::vector<RobotPaths>& robots, size_t from_frame,
                                         Alignment alignment) {
  ASSIGN_OR_RETURN(const Sequences sequences, ReadSequences(robots, from_frame));
  Accuracy accuracy;
  for (const RobotPaths& robot : robots) {
    accuracy.robots.push_back(
        ComputeRobotAccuracy(robot, sequences.at(KeyOf(robot.source)), alignment));
  }
  accuracy.fused = ComputeFusedAccuracy(robots, sequences, alignment);
  return accuracy;
}

}  // namespace corbslam
