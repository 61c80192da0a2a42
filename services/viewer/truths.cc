#include "services/viewer/truths.h"

#include <cstddef>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "services/convert/resource_names.h"
#include "slam/evaluation/trajectory.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr size_t kMostPoses = 1'000'000;

absl::StatusOr<std::shared_ptr<const std::string>> ReadRows(const std::string& path) {
  const absl::StatusOr<Trajectory> truth = ReadTumTrajectory(path);
  if (!truth.ok()) {
    return absl::InvalidArgumentError(absl::StrCat("--truth: ", truth.status().message()));
  }
  if (truth->size() > kMostPoses) {
    return absl::InvalidArgumentError(
        absl::StrCat("--truth: ", path, " has ", truth->size(), " poses, at most ", kMostPoses));
  }
  std::string rows;
  for (const StampedPose& pose : *truth) absl::StrAppend(&rows, TumRow(pose), "\n");
  return std::make_shared<const std::string>(std::move(rows));
}

}  // namespace

absl::StatusOr<Truths> ReadTruths(const std::vector<std::string>& flags) {
  Truths truths;
  for (const std::string& flag : flags) {
    const std::pair<std::string, std::string> parts = absl::StrSplit(flag, absl::MaxSplits('=', 1));
    if (parts.second.empty()) {
      return absl::InvalidArgumentError(
          absl::StrCat("--truth is \"", flag, "\", must be MISSION=FILE"));
    }
    RETURN_IF_ERROR(CheckNameSegment("--truth's mission", parts.first));
    ASSIGN_OR_RETURN(std::shared_ptr<const std::string> rows, ReadRows(parts.second));
    if (!truths.emplace(parts.first, std::move(rows)).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("--truth names mission ", parts.first, " twice"));
    }
  }
  return truths;
}

}  // namespace corbslam::services
