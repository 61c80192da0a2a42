#include "services/tool/run/plan.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client_agent/source/frame_reader.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::ApplyOptions;
using client_agent::FormatSourceSpec;
using client_agent::FrameRange;
using client_agent::FrameReader;
using client_agent::FrameSelection;
using client_agent::OpenReader;
using client_agent::SelectFrames;
using client_agent::SourceSpec;
using client_agent::TakePart;

namespace {

constexpr absl::string_view kNames[] = {
    "alpha",  "bravo", "charlie", "delta",  "echo",     "foxtrot", "golf",   "hotel",  "india",
    "juliet", "kilo",  "lima",    "mike",   "november", "oscar",   "papa",   "quebec", "romeo",
    "sierra", "tango", "uniform", "victor", "whiskey",  "xray",    "yankee", "zulu"};

// Least frames of the share that is one robot's own: fewer make no map.
constexpr size_t kMinOwnFrames = 10;

// Refuses shares that are too short.
absl::Status CheckShares(const SourceSpec& source, size_t end, const SplitOptions& options) {
  const size_t frames = SelectFrames(source.selection, end).size();
  const auto own_frames = [&](size_t robots) {
    const size_t share = frames / robots;
    return options.mode == SplitMode::kInterleaved ? share / robots : share;
  };
  if (options.robots == 1 || own_frames(options.robots) >= kMinOwnFrames) return absl::OkStatus();
  size_t most = 1;
  while (own_frames(most + 1) >= kMinOwnFrames) ++most;
  return absl::InvalidArgumentError(absl::StrCat(
      options.robots, " robots share ", frames, " frames of ", FormatSourceSpec(source),
      ": at most ", most, " can, for ", kMinOwnFrames, " frames of its own each"));
}

absl::StatusOr<std::vector<SourceSpec>> SplitSource(const SourceSpec& source,
                                                    const SplitOptions& options) {
  ASSIGN_OR_RETURN(const std::unique_ptr<FrameReader> reader, OpenReader(source));
  const size_t end =
      std::min(reader->frame_count(), source.selection.last.value_or(reader->frame_count()) + 1);
  if (options.mode == SplitMode::kInterleaved && source.selection.stride != 1) {
    return absl::InvalidArgumentError("an interleaved split sets the stride itself");
  }
  if (source.selection.part.has_value() && options.robots > 1) {
    return absl::InvalidArgumentError(absl::StrCat(FormatSourceSpec(source),
                                                   " is one robot's part: it can't be split among ",
                                                   options.robots));
  }
  RETURN_IF_ERROR(CheckShares(source, end, options));
  std::vector<SourceSpec> parts;
  for (const FrameSelection& selection : SplitFrames(source.selection.first, end, options)) {
    SourceSpec part = source;
    part.selection.first = selection.first;
    part.selection.last = selection.last;
    if (options.mode == SplitMode::kInterleaved) {
      part.selection.stride = selection.stride;
      part.selection.offset = selection.offset;
    }
    if (SelectFrames(part.selection, end).empty()) {
      return absl::InvalidArgumentError(absl::StrCat("robot ", parts.size() + 1, " of ",
                                                     options.robots, " gets none of the frames of ",
                                                     FormatSourceSpec(source)));
    }
    parts.push_back(part);
  }
  return parts;
}

// Truths of one simulated world are in one frame anyway.
void ShareTruthFrame(std::vector<SourceSpec>& sources) {
  for (SourceSpec& source : sources) {
    if (source.settings == nullptr && source.truth_frame.empty()) source.truth_frame = "shared";
  }
}

}  // namespace

std::vector<FrameSelection> SplitFrames(size_t begin, size_t end, const SplitOptions& options) {
  std::vector<FrameSelection> parts;
  for (size_t k = 0; k < options.robots && begin < end; ++k) {
    const FrameRange range = TakePart({begin, end}, {k + 1, options.robots, options.overlap});
    FrameSelection part;
    part.first = range.begin;
    part.last = range.end - 1;
    if (options.mode == SplitMode::kInterleaved) {
      part.stride = options.robots;
      part.offset = k;
    }
    parts.push_back(part);
  }
  return parts;
}

absl::StatusOr<std::vector<RobotPlan>> PlanRobots(const PlanOptions& options) {
  if (options.sources.empty()) return absl::InvalidArgumentError("no source is named");
  if (options.split.robots < 1 || options.split.robots > 100) {
    return absl::InvalidArgumentError(
        absl::StrCat(options.split.robots, " robots: 1 to 100 are possible"));
  }
  std::vector<SourceSpec> sources = options.sources;
  if (sources.size() == 1) {
    ASSIGN_OR_RETURN(sources, SplitSource(options.sources.front(), options.split));
    if (sources.empty()) return absl::InvalidArgumentError("the source has no frames");
  }
  if (options.is_truth_shared) ShareTruthFrame(sources);
  std::vector<RobotPlan> robots;
  for (SourceSpec& source : sources) {
    robots.push_back({RobotName(robots.size()), std::move(source)});
  }
  for (const auto& [robot, perturbation] : options.perturbations) {
    if (robot < 1 || robot > robots.size()) {
      return absl::InvalidArgumentError(
          absl::StrCat("perturbation of robot ", robot, ": there are ", robots.size()));
    }
    RETURN_IF_ERROR(ApplyOptions(perturbation, robots[robot - 1].source));
  }
  return robots;
}

std::string RobotName(size_t index) {
  return index < std::size(kNames) ? std::string(kNames[index]) : absl::StrCat("robot", index + 1);
}

absl::StatusOr<std::pair<size_t, std::string>> ParsePerturbation(absl::string_view text) {
  const std::pair<absl::string_view, absl::string_view> parts =
      absl::StrSplit(text, absl::MaxSplits(':', 1));
  uint32_t robot = 0;
  if (!absl::SimpleAtoi(parts.first, &robot) || parts.second.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("perturbation '", text, "' is not ROBOT:OPTIONS, for example 2:gamma=0.8"));
  }
  return std::pair<size_t, std::string>(robot, parts.second);
}

}  // namespace corbslam::services
