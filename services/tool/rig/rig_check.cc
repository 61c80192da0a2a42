#include "services/tool/rig/rig_check.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client_agent/source/source_description.h"
#include "client_agent/source_checks/picture_checks.h"
#include "client_agent/source_checks/source_checks.h"
#include "services/tool/rig/live_sample.h"
#include "services/tool/rig/rig_findings.h"
#include "services/tool/rig/rig_picture.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::FindingLevel;
using client_agent::FrameReader;
using client_agent::FrameStream;
using client_agent::Inspection;
using client_agent::JudgeSample;
using client_agent::LookIntoSource;
using client_agent::PairPreparation;
using client_agent::PictureStatistics;
using client_agent::Sample;
using client_agent::SampleFrame;
using client_agent::SampleOptions;
using client_agent::SourceDescription;
using client_agent::SourceFinding;
using client_agent::SourceFindings;
using client_agent::SourceLayout;
using client_agent::SourceSpec;
using client_agent::StereoJudgement;

namespace {

constexpr SampleOptions kThorough = {.places = 16, .stereo_row = 3, .rgbd_row = 5};
// Fewer matches say nothing about a region.
constexpr size_t kFewMatches = 15;

// Says how bright the pictures are and how much that changes over the sample.
std::string DescribeExposure(const Sample& sample) {
  int least = 255;
  int most = 0;
  for (const SampleFrame& frame : sample) {
    if (frame.images.grey.type() != CV_8UC1 || frame.images.grey.empty()) continue;
    const PictureStatistics statistics = client_agent::MeasurePicture(frame.images.grey);
    least = std::min(least, statistics.median);
    most = std::max(most, statistics.median);
  }
  if (least > most) return "no picture could be read";
  return absl::StrCat("medians of the pictures from ", least, " to ", most, " of 255");
}

std::string FormatRegion(const RegionRows& region) {
  if (region.matches < kFewMatches) return absl::StrFormat("%17s", "too few");
  return absl::StrFormat("%6.2f (%+.2f)%4d", region.row_error_px, region.row_offset_px,
                         static_cast<int>(std::min<size_t>(region.matches, 9999)));
}

std::string FormatRegions(const PairRegions& measured) {
  std::string text = absl::StrFormat(
      "rows: %.2f px apart in the median, %+.2f in the mean, %d matches of %d pairs; by region of "
      "the "
      "picture, "
      "median (mean with its sign) and matches:\n",
      measured.all.row_error_px, measured.all.row_offset_px, measured.all.matches, measured.pairs);
  for (size_t row = 0; row < PairRegions::kRows; ++row) {
    for (size_t column = 0; column < PairRegions::kColumns; ++column) {
      absl::StrAppend(&text, "  ",
                      FormatRegion(measured.regions[row * PairRegions::kColumns + column]));
    }
    absl::StrAppend(&text, "\n");
  }
  absl::StrAppendFormat(
      &text,
      "disparities: %.1f to %.1f px (nine tenths of the matches); %.1f %% have the "
      "wrong sign\n",
      measured.low_disparity_px, measured.high_disparity_px, 100 * measured.negative_share);
  return text;
}

// What a late camera shows besides follows from it, and nothing right comes of such pictures.
void PutLateFirst(SourceFindings& findings) {
  const auto is_late = [](const SourceFinding& finding) { return finding.code == "pair-late"; };
  std::stable_partition(findings.begin(), findings.end(), is_late);
  for (SourceFinding& finding : findings) {
    if (is_late(finding)) finding.level = FindingLevel::kError;
  }
}

absl::StatusOr<RigCheck> Report(const SensorCalibration& calibration,
                                std::vector<std::pair<std::string, std::string>> description,
                                const Inspection& inspection) {
  RigCheck check;
  check.description = std::move(description);
  check.findings = inspection.findings;
  PutLateFirst(check.findings);
  check.description.push_back({"exposure", DescribeExposure(inspection.sample)});
  const auto* const stereo = std::get_if<StereoCalibration>(&calibration);
  if (stereo == nullptr) {
    if (KindOf(calibration) == SensorKind::kRgbd) check.picture = DrawDepth(inspection.sample);
    return check;
  }
  ASSIGN_OR_RETURN(const PairPreparation preparation, PairPreparation::Make(*stereo));
  const Camera& camera = preparation.camera();
  check.description.push_back(
      {"rectified", absl::StrFormat("fx %.5g fy %.5g cx %.5g cy %.5g px, %dx%d, baseline %.5g m",
                                    camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px,
                                    camera.width_px, camera.height_px, camera.baseline_m)});
  check.regions = MeasureRegions(preparation, inspection.pairs);
  for (SourceFinding& finding : FindingsOfRegions(*check.regions, check.findings)) {
    check.findings.push_back(std::move(finding));
  }
  check.picture = DrawPair(preparation, inspection.sample, inspection.pairs);
  return check;
}

std::string Verdict(const RigCheck& check) {
  if (!check.IsUsable()) return "WRONG: nothing right can come of this rig and these pictures.\n";
  if (!check.findings.empty()) return "USABLE, with what is improbable above.\n";
  if (!check.regions.has_value()) return "RIGHT: the pictures agree with the rig.\n";
  const size_t unseen = check.regions->regions.size() - JudgedRegions(*check.regions);
  const std::string where =
      unseen == 0 ? ""
                  : absl::StrCat(" ", unseen, " of ", check.regions->regions.size(),
                                 " regions had too few matches to say anything about the lens.");
  return absl::StrCat(
      "RIGHT: the pictures agree with the rig.", where,
      " Rows can't show a wrong baseline, nor the same wrong focal length or lens on both sides: "
      "measure a known length.\n");
}

}  // namespace

bool RigCheck::IsUsable() const {
  return std::none_of(findings.begin(), findings.end(), [](const SourceFinding& finding) {
    return finding.level == FindingLevel::kError;
  });
}

absl::StatusOr<RigCheck> CheckRig(const FrameReader& reader, const SourceSpec& spec) {
  Inspection inspection = LookIntoSource(reader, spec, kThorough);
  const bool is_pair = KindOf(reader.calibration()) == SensorKind::kStereo;
  if (is_pair && spec.layout == SourceLayout::kRegistered) {
    // What a simulation draws is not checked for what a camera does; its rows are measured.
    inspection.pairs = JudgeSample(reader.calibration(), inspection.sample).pairs;
  }
  return Report(reader.calibration(), DescribeInLines(reader.description()), inspection);
}

absl::StatusOr<RigCheck> CheckLiveRig(FrameStream& stream, const SourceDescription& description,
                                      absl::Duration duration) {
  const std::optional<double> interval_s = stream.interval_s();
  ASSIGN_OR_RETURN(LiveSample taken, TakeLiveSample(stream, duration, kThorough));
  const std::optional<double> expected_hz =
      interval_s.has_value() ? std::optional<double>(1 / *interval_s) : std::nullopt;
  StereoJudgement judged = JudgeSample(stream.calibration(), taken.frames);
  SourceFindings findings = stream.findings();
  for (SourceFinding& found : CheckLiveSample(taken, expected_hz)) {
    findings.push_back(std::move(found));
  }
  findings.insert(findings.end(), judged.findings.begin(), judged.findings.end());
  std::vector<std::pair<std::string, std::string>> lines = DescribeInLines(description);
  for (auto& line : DescribeInLines(taken)) lines.push_back(std::move(line));
  return Report(stream.calibration(), std::move(lines),
                {std::move(taken.frames), std::move(findings), std::move(judged.pairs)});
}

std::string FormatRigCheck(const RigCheck& check) {
  std::string text;
  for (const auto& [name, value] : check.description) {
    absl::StrAppend(&text, name, ": ", value, "\n");
  }
  if (check.regions.has_value()) absl::StrAppend(&text, FormatRegions(*check.regions));
  for (const SourceFinding& finding : check.findings) {
    absl::StrAppend(&text, finding.level == FindingLevel::kError ? "ERROR " : "WARNING ",
                    finding.code, ": ", finding.text, "\n");
  }
  return text + Verdict(check);
}

}  // namespace corbslam::services
