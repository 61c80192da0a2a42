#include "services/tool/evaluation/evaluation_input.h"

#include <filesystem>
#include <limits>
#include <memory>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client_agent/source/frame_reader.h"
#include "services/tool/evaluation/ground_truth.h"
#include "slam/camera/recorded_camera.h"
#include "slam/evaluation/trajectory_file.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::FrameReader;
using client_agent::OpenReader;
using client_agent::ParseSourceSpec;
using client_agent::SourceSpec;

namespace {

void AddNotes(const std::vector<std::string>& notes, EvaluationInput& input) {
  input.notes.insert(input.notes.end(), notes.begin(), notes.end());
}

// Returns true if `truth` names a sequence, which has a colon behind its layout. A file may have a
// colon in its name, too.
bool IsSequence(const std::string& truth) {
  std::error_code ignored;
  return absl::StrContains(truth, ':') && !std::filesystem::exists(truth, ignored);
}

absl::Status OtherFrame(const std::string& file, PosesOf poses_of, absl::string_view other) {
  return absl::InvalidArgumentError(
      absl::StrCat(file, " has poses of ", Describe(poses_of), ", ", other));
}

// Returns the frame that the files or the option say, which must agree.
absl::StatusOr<std::optional<PosesOf>> AgreeOnFrame(
    const EvaluationFiles& files, const std::vector<std::optional<PosesOf>>& said) {
  std::optional<PosesOf> agreed;
  std::string by = "--poses-of";
  if (!files.poses_of.empty()) {
    ASSIGN_OR_RETURN(agreed, ParsePosesOf(files.poses_of));
  }
  for (size_t i = 0; i < said.size(); ++i) {
    if (!said[i].has_value()) continue;
    if (agreed.has_value() && *agreed != *said[i]) {
      return OtherFrame(files.estimates[i], *said[i],
                        absl::StrCat(by, " says ", Describe(*agreed)));
    }
    agreed = said[i];
    by = files.estimates[i];
  }
  return agreed;
}

absl::StatusOr<std::optional<PosesOf>> ReadEstimates(const EvaluationFiles& files,
                                                     EvaluationInput& input) {
  std::vector<std::optional<PosesOf>> said;
  for (const std::string& path : files.estimates) {
    ASSIGN_OR_RETURN(TrajectoryReading reading, ReadTrajectoryFile(path));
    AddNotes(reading.notes, input);
    said.push_back(reading.poses_of);
    input.estimates.push_back(std::move(reading.trajectory));
  }
  return AgreeOnFrame(files, said);
}

// Returns the time of a sequence's frame.
absl::StatusOr<int64_t> TimeOfFrame(const SourceSpec& source, size_t frame) {
  ASSIGN_OR_RETURN(const std::unique_ptr<FrameReader> frames, OpenReader(source));
  if (frame < frames->frame_count()) return frames->timestamp_ns(frame);
  return absl::InvalidArgumentError(
      absl::StrCat("--from-frame ", frame, ": there are ", frames->frame_count()));
}

// Returns the time from which errors count.
absl::StatusOr<int64_t> ReadRecordedTruth(const EvaluationFiles& files, PosesOf poses_of,
                                          EvaluationInput& input) {
  ASSIGN_OR_RETURN(const SourceSpec source, ParseSourceSpec(files.truth));
  ASSIGN_OR_RETURN(const std::optional<GroundTruth> truth, ReadGroundTruth(source));
  if (!truth.has_value()) {
    return absl::NotFoundError(absl::StrCat("no ground truth in ", source.directory));
  }
  AddNotes(truth->notes, input);
  ASSIGN_OR_RETURN(input.truth, TruthOf(*truth, source, poses_of));
  if (!files.from_frame.has_value()) return std::numeric_limits<int64_t>::min();
  return TimeOfFrame(source, *files.from_frame);
}

absl::StatusOr<int64_t> ReadTruthFile(const EvaluationFiles& files,
                                      const std::optional<PosesOf>& poses_of,
                                      EvaluationInput& input) {
  ASSIGN_OR_RETURN(TrajectoryReading reading, ReadTrajectoryFile(files.truth, files.truth_times));
  AddNotes(reading.notes, input);
  if (reading.trajectory.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(files.truth, " holds no pose"));
  }
  if (reading.poses_of.has_value() && poses_of.has_value() && *reading.poses_of != *poses_of) {
    return OtherFrame(files.truth, *reading.poses_of,
                      absl::StrCat("the estimates of ", Describe(*poses_of)));
  }
  input.truth = std::move(reading.trajectory);
  if (!files.from_frame.has_value()) return std::numeric_limits<int64_t>::min();
  if (*files.from_frame < input.truth.size()) return input.truth[*files.from_frame].timestamp_ns;
  return absl::InvalidArgumentError(
      absl::StrCat("--from-frame ", *files.from_frame, ": the truth has ", input.truth.size()));
}

}  // namespace

absl::StatusOr<EvaluationInput> ReadEvaluationInput(const EvaluationFiles& files) {
  EvaluationInput input;
  ASSIGN_OR_RETURN(const std::optional<PosesOf> poses_of, ReadEstimates(files, input));
  int64_t from_ns = 0;
  if (IsSequence(files.truth)) {
    ASSIGN_OR_RETURN(from_ns,
                     ReadRecordedTruth(files, poses_of.value_or(PosesOf::kRecordedCamera), input));
  } else {
    ASSIGN_OR_RETURN(from_ns, ReadTruthFile(files, poses_of, input));
  }
  for (Trajectory& estimate : input.estimates) estimate = KeepFrom(estimate, from_ns);
  return input;
}

}  // namespace corbslam::services
