#include "services/tool/evaluation/evaluation_input.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>
#include <numeric>
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

struct Truth {
  Trajectory trajectory;
  int64_t from_ns = std::numeric_limits<int64_t>::min();  // Errors count from then on.
};

absl::StatusOr<Truth> ReadRecordedTruth(const std::string& sequence, std::optional<size_t> from,
                                        PosesOf poses_of, EvaluationInput& input) {
  ASSIGN_OR_RETURN(const SourceSpec source, ParseSourceSpec(sequence));
  ASSIGN_OR_RETURN(const std::optional<GroundTruth> recorded, ReadGroundTruth(source));
  if (!recorded.has_value()) {
    return absl::NotFoundError(absl::StrCat("no ground truth in ", source.directory));
  }
  AddNotes(recorded->notes, input);
  Truth truth;
  ASSIGN_OR_RETURN(truth.trajectory, TruthOf(*recorded, source, poses_of));
  if (from.has_value()) {
    ASSIGN_OR_RETURN(truth.from_ns, TimeOfFrame(source, *from));
  }
  return truth;
}

absl::StatusOr<Truth> ReadTruthFile(const std::string& file, const EvaluationFiles& files,
                                    const std::optional<PosesOf>& poses_of,
                                    EvaluationInput& input) {
  ASSIGN_OR_RETURN(TrajectoryReading reading, ReadTrajectoryFile(file, files.truth_times));
  AddNotes(reading.notes, input);
  if (reading.trajectory.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(file, " holds no pose"));
  }
  if (reading.poses_of.has_value() && poses_of.has_value() && *reading.poses_of != *poses_of) {
    return OtherFrame(file, *reading.poses_of,
                      absl::StrCat("the estimates of ", Describe(*poses_of)));
  }
  Truth truth = {std::move(reading.trajectory)};
  if (!files.from_frame.has_value()) return truth;
  if (*files.from_frame >= truth.trajectory.size()) {
    return absl::InvalidArgumentError(absl::StrCat("--from-frame ", *files.from_frame,
                                                   ": the truth has ", truth.trajectory.size()));
  }
  truth.from_ns = truth.trajectory[*files.from_frame].timestamp_ns;
  return truth;
}

absl::StatusOr<std::vector<Truth>> ReadTruths(const EvaluationFiles& files,
                                              const std::optional<PosesOf>& poses_of,
                                              EvaluationInput& input) {
  std::vector<Truth> truths;
  for (const std::string& truth : files.truths) {
    if (IsSequence(truth)) {
      ASSIGN_OR_RETURN(truths.emplace_back(),
                       ReadRecordedTruth(truth, files.from_frame,
                                         poses_of.value_or(PosesOf::kRecordedCamera), input));
    } else {
      ASSIGN_OR_RETURN(truths.emplace_back(), ReadTruthFile(truth, files, poses_of, input));
    }
  }
  return truths;
}

// Checks that the files say which truth is whose.
absl::Status CheckTruths(const EvaluationFiles& files) {
  const size_t truths = files.truths.size();
  if (truths == 1) return absl::OkStatus();
  if (!files.truth_times.empty()) {
    return absl::InvalidArgumentError(
        "--truth-times is of one --truth: put each one's beside it, "
        "as FILE.times");
  }
  if (truths == files.estimates.size()) return absl::OkStatus();
  if (!files.is_truth_shared) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--truth is given ", truths, " times for ", files.estimates.size(),
        " trajectories: give one for each in their order, or --truth-frame shared if all are in "
        "one frame and each is of a time of its own"));
  }
  if (!files.from_frame.has_value()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "--from-frame: which sequence's frame that is only a --truth for each trajectory says");
}

// Makes one truth of several. INVALID_ARGUMENT if two are of one time.
absl::StatusOr<Trajectory> JoinInTime(const std::vector<Truth>& truths,
                                      const std::vector<std::string>& names) {
  std::vector<size_t> order(truths.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto begin_ns = [&](size_t i) { return truths[i].trajectory.front().timestamp_ns; };
  std::sort(order.begin(), order.end(),
            [&](size_t a, size_t b) { return begin_ns(a) < begin_ns(b); });
  Trajectory joined;
  for (size_t i = 0; i < order.size(); ++i) {
    const Trajectory& next = truths[order[i]].trajectory;
    if (!joined.empty() && joined.back().timestamp_ns >= next.front().timestamp_ns) {
      return absl::InvalidArgumentError(
          absl::StrCat(names[order[i - 1]], " and ", names[order[i]],
                       " are of one time: give a --truth for each trajectory, in their order"));
    }
    joined.insert(joined.end(), next.begin(), next.end());
  }
  return joined;
}

}  // namespace

absl::StatusOr<EvaluationInput> ReadEvaluationInput(const EvaluationFiles& files) {
  RETURN_IF_ERROR(CheckTruths(files));
  EvaluationInput input;
  input.is_one_frame = files.truths.size() == 1 || files.is_truth_shared;
  ASSIGN_OR_RETURN(const std::optional<PosesOf> poses_of, ReadEstimates(files, input));
  ASSIGN_OR_RETURN(std::vector<Truth> truths, ReadTruths(files, poses_of, input));
  const bool is_one_each = truths.size() == input.estimates.size();
  for (size_t i = 0; i < input.estimates.size(); ++i) {
    const int64_t from_ns = truths[is_one_each ? i : 0].from_ns;
    input.estimates[i] = KeepFrom(input.estimates[i], from_ns);
  }
  if (is_one_each || truths.size() == 1) {
    for (Truth& truth : truths) input.truths.push_back(std::move(truth.trajectory));
  } else {
    ASSIGN_OR_RETURN(input.truths.emplace_back(), JoinInTime(truths, files.truths));
  }
  return input;
}

}  // namespace corbslam::services
