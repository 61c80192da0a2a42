#include "services/tool/evaluation/accuracy.h"

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/source/frame_reader.h"
#include "services/simulated_source/simulated_source.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::FormatSourceSpec;
using client_agent::FrameReader;
using client_agent::OpenReader;
using client_agent::SourceSpec;

namespace {

// Holds the truth of one sequence and the time from which errors count again.
struct Sequence {
  std::optional<Trajectory> truth;
  std::optional<int64_t> from_ns;  // Nullopt if the sequence is shorter than that.
};

using Sequences = std::map<std::string, Sequence>;

// Returns a key that is equal for sources that share times and truth; without the phase for those
// that share the truth alone.
std::string KeyOf(const SourceSpec& source, bool with_phase = true) {
  SourceSpec sequence;
  sequence.layout = source.layout;
  sequence.directory = source.directory;
  if (const SimulationSpec* simulation = FindSimulation(source); simulation != nullptr) {
    SimulationSpec plain = *simulation;
    plain.lens = {};
    plain.threads = 1;
    // A turned robot with another phase is elsewhere at one time.
    if (!with_phase && !plain.turned) plain.phase = 0;
    SetSimulation(plain, sequence);
  }
  return FormatSourceSpec(sequence);
}

// Returns a name that is equal for sources whose truths are in one frame.
std::string WorldOf(const SourceSpec& source) {
  const SimulationSpec* simulation = FindSimulation(source);
  if (simulation != nullptr) return WorldName(*simulation);
  return source.truth_frame.empty() ? KeyOf(source) : absl::StrCat("truth ", source.truth_frame);
}

absl::StatusOr<Sequence> ReadSequence(const SourceSpec& source, size_t from_frame) {
  Sequence sequence;
  ASSIGN_OR_RETURN(std::optional<GroundTruth> truth, ReadGroundTruth(source));
  if (truth.has_value()) sequence.truth = std::move(truth->trajectory);
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

// Returns nullopt if there are too few poses.
std::optional<AbsoluteError> ErrorOf(const std::vector<PosePair>& pairs, Alignment alignment) {
  const absl::StatusOr<AbsoluteError> error = ComputeAbsoluteError(pairs, alignment);
  return error.ok() ? std::optional(*error) : std::nullopt;
}

std::optional<double> AteOf(const Trajectory& estimate, const Sequence& sequence,
                            Alignment alignment) {
  const auto error = ErrorOf(AssociateByTime(estimate, *sequence.truth), alignment);
  return error.has_value() ? std::optional(error->rmse_m) : std::nullopt;
}

// Returns the poses before the first of `others`; all where there are none.
Trajectory Before(const Trajectory& trajectory, const Trajectory& others) {
  if (others.empty()) return trajectory;
  Trajectory before = trajectory;
  std::erase_if(before, [&](const StampedPose& pose) {
    return pose.timestamp_ns >= others.front().timestamp_ns;
  });
  return before;
}

// Returns the poses of the times of `others`.
Trajectory AtTimesOf(const Trajectory& trajectory, const Trajectory& others) {
  std::set<int64_t> times;
  for (const StampedPose& pose : others) times.insert(pose.timestamp_ns);
  Trajectory kept = trajectory;
  std::erase_if(kept, [&](const StampedPose& pose) { return !times.contains(pose.timestamp_ns); });
  return kept;
}

ToldAccuracy ComputeTold(const ToldPaths& told, const Sequence& sequence, Alignment alignment) {
  const bool knew = !told.global.empty();
  return {AteOf(knew ? told.global : told.local, sequence, alignment),
          knew ? AteOf(Before(told.local, told.global), sequence, alignment) : std::nullopt};
}

RobotAccuracy ComputeRobotAccuracy(const RobotPaths& robot, const Sequence& sequence,
                                   Alignment alignment) {
  if (!sequence.truth.has_value()) return {};
  const Trajectory global = ToTrajectory(robot.global);
  const Trajectory estimate = CountLocalMaps(robot.local) == 1 ? ToTrajectory(robot.local) : global;
  RobotAccuracy accuracy;
  accuracy.ate_m = AteOf(estimate, sequence, alignment);
  accuracy.ate_global_m = AteOf(global, sequence, alignment);
  accuracy.told = ComputeTold(robot.told, sequence, alignment);
  const std::vector<PosePair> pairs = AssociateByTime(estimate, *sequence.truth);
  accuracy.relative = ComputeRelativeError(pairs, *sequence.truth);
  accuracy.by_length = ComputeErrorByLength(pairs, *sequence.truth);
  if (sequence.from_ns.has_value()) {
    accuracy.ate_from_frame_m = AteOf(KeepFrom(estimate, *sequence.from_ns), sequence, alignment);
  }
  return accuracy;
}

// Returns the pairs of all robots that were in `world`; with `from_frame` only those from the frame
// on that counts again.
std::vector<PosePair> PairToTruth(const std::vector<RobotPaths>& robots, const Sequences& sequences,
                                  const std::string& world, bool from_frame) {
  std::vector<PosePair> pairs;
  for (const RobotPaths& robot : robots) {
    const Sequence& sequence = sequences.at(KeyOf(robot.source));
    if (WorldOf(robot.source) != world || !sequence.truth.has_value()) continue;
    if (from_frame && !sequence.from_ns.has_value()) continue;
    const int64_t from_ns = from_frame ? *sequence.from_ns : std::numeric_limits<int64_t>::min();
    const std::vector<PosePair> own =
        AssociateByTime(KeepFrom(ToTrajectory(robot.global), from_ns), *sequence.truth);
    pairs.insert(pairs.end(), own.begin(), own.end());
  }
  return pairs;
}

// Returns the mean over all segments. Each sequence is measured along one path that runs through
// all its robots' parts.
std::optional<RelativeError> FusedRelativeError(const std::vector<RobotPaths>& robots,
                                                const Sequences& sequences) {
  std::vector<RelativeError> errors;
  for (const auto& [key, sequence] : sequences) {
    if (!sequence.truth.has_value()) continue;
    std::vector<Trajectory> parts;
    for (const RobotPaths& robot : robots) {
      if (KeyOf(robot.source) == key) parts.push_back(ToTrajectory(robot.global));
    }
    const std::optional<RelativeError> error =
        ComputeRelativeError(AssociateByTime(MergeByTime(parts), *sequence.truth), *sequence.truth);
    if (error.has_value()) errors.push_back(*error);
  }
  return MeanOverSegments(errors);
}

// Returns the truth of the time in which the robots that went this way were on it.
Trajectory CutTruth(const std::vector<RobotPaths>& robots, const std::string& way,
                    const Trajectory& truth) {
  int64_t first_ns = std::numeric_limits<int64_t>::max();
  int64_t last_ns = std::numeric_limits<int64_t>::min();
  for (const RobotPaths& robot : robots) {
    if (WayOf(robot.source) != way) continue;
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

// Returns true if every local map of the robot is connected to the global frame.
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
  accuracy.truth = CutTruth(robots, WayOf(in_global->source), *sequence.truth);
  const std::string world = WorldOf(in_global->source);
  const std::vector<PosePair> pairs = PairToTruth(robots, sequences, world, false);
  const std::optional<AbsoluteError> all = ErrorOf(pairs, alignment);
  if (all.has_value()) accuracy.truth_from_global = all->truth_from_estimate;
  const auto belongs = [&](const RobotPaths& robot) {
    return WorldOf(robot.source) == world && IsAllGlobal(robot) &&
           sequences.at(KeyOf(robot.source)).truth.has_value();
  };
  if (!std::all_of(robots.begin(), robots.end(), belongs)) return accuracy;
  accuracy.all = all;
  accuracy.without_scale = ErrorOf(pairs, Alignment::kSim3);
  accuracy.from_frame = ErrorOf(PairToTruth(robots, sequences, world, true), alignment);
  accuracy.relative = FusedRelativeError(robots, sequences);
  return accuracy;
}

// Fills in the errors of single poses.
void AddProfile(const RobotPaths& robot, const Sequence& sequence, const std::string& global_world,
                const FusedAccuracy& fused, Alignment alignment, RobotAccuracy& accuracy) {
  if (!sequence.truth.has_value()) return;
  accuracy.is_profile_global = fused.truth_from_global.has_value() && !robot.global.empty() &&
                               WorldOf(robot.source) == global_world;
  const bool is_global = accuracy.is_profile_global || CountLocalMaps(robot.local) != 1;
  const std::vector<PosePair> pairs =
      AssociateByTime(ToTrajectory(is_global ? robot.global : robot.local), *sequence.truth);
  if (accuracy.is_profile_global) {
    accuracy.profile = ProfileErrors(pairs, *fused.truth_from_global);
  } else if (const auto own = ErrorOf(pairs, alignment); own.has_value()) {
    accuracy.profile = ProfileErrors(pairs, own->truth_from_estimate);
  }
}

// Returns the world of the truth that the global frame is aligned to; empty if nothing lies in it.
std::string GlobalWorld(const std::vector<RobotPaths>& robots) {
  for (const RobotPaths& robot : robots) {
    if (!robot.global.empty()) return WorldOf(robot.source);
  }
  return "";
}

}  // namespace

std::string WayOf(const SourceSpec& source) { return KeyOf(source, false); }

absl::StatusOr<ToldAccuracy> ComputeToldAccuracy(const RobotPaths& robot, const ToldPaths& company,
                                                 Alignment alignment) {
  ASSIGN_OR_RETURN(const Sequence sequence, ReadSequence(robot.source, 0));
  if (!sequence.truth.has_value()) return ToldAccuracy{};
  // Of all frames; what it told in a global frame may begin late.
  const Trajectory& told = robot.told.local.empty() ? robot.told.global : robot.told.local;
  if (company.global.empty()) return ComputeTold({told, {}}, sequence, alignment);
  return ToldAccuracy{AteOf(AtTimesOf(told, company.global), sequence, alignment),
                      AteOf(Before(told, company.global), sequence, alignment)};
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
  for (size_t i = 0; i < robots.size(); ++i) {
    AddProfile(robots[i], sequences.at(KeyOf(robots[i].source)), GlobalWorld(robots),
               accuracy.fused, alignment, accuracy.robots[i]);
  }
  return accuracy;
}

}  // namespace corbslam::services
