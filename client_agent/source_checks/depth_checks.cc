#include "client_agent/source_checks/depth_checks.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client_agent/source_checks/depth_alignment.h"
#include "client_agent/source_checks/depth_parallax.h"
#include "slam/util/median.h"

namespace corbslam::client_agent {
namespace {

// docs/sources_checks.md says what these limits were derived from.
constexpr double kLeastValid = 0.05;
constexpr double kMostSaturated = 0.01;
constexpr double kLeastMedian_m = 0.25;
constexpr double kMostFar_m = 12;
constexpr double kLeastAgreement = 1.4;
constexpr double kLate_frames = 1;
constexpr double kLateMotion_px = 6;
constexpr double kClearlyBetter = 1.08;
constexpr double kLeastParallaxGain = 0.1;
constexpr size_t kFewestAligned = 5;
// Two measurements of one offset differ by no more: they are in steps of two pixels.
constexpr double kSameOffset_px = 4;
constexpr int kStep_px = 3;
constexpr double kSaturated = 65535;

using Statistics = std::vector<DepthStatistics>;

double ValueAt(const cv::Mat& depth, int x, int y) {
  if (depth.type() == CV_16UC1) return depth.at<uint16_t>(y, x);
  const auto metres = static_cast<double>(depth.at<float>(y, x));
  return std::isfinite(metres) && metres > 0 ? metres : 0;
}

double Rank(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<size_t>(share * static_cast<double>(sorted.size() - 1))];
}

bool IsDepth(const cv::Mat& depth) { return depth.type() == CV_16UC1 || depth.type() == CV_32FC1; }

// Returns the frames whose depth can be judged, and adds a finding for the first of another size.
Sample KeepWhole(const Camera& camera, const Sample& sample, SourceFindings& findings) {
  const cv::Size size(camera.width_px, camera.height_px);
  Sample whole;
  for (const SampleFrame& frame : sample) {
    const cv::Mat& depth = frame.images.depth;
    if (depth.size() == size && IsDepth(depth)) {
      if (frame.images.grey.size() == size && frame.images.grey.type() == CV_8UC1) {
        whole.push_back(frame);
      }
    } else if (findings.empty()) {
      findings.push_back(
          {FindingLevel::kError, "depth-size",
           absl::StrFormat("frame %d: the depth image is %dx%d, the picture and the calibration "
                           "%dx%d: register depth to the picture, pixel for pixel",
                           frame.number, depth.cols, depth.rows, size.width, size.height)});
    }
  }
  return whole;
}

double MedianOf(const Statistics& frames, const std::function<double(const DepthStatistics&)>& of) {
  std::vector<double> values;
  for (const DepthStatistics& frame : frames) values.push_back(of(frame));
  return Median(std::move(values));
}

std::string Frames(const Sample& sample) {
  return absl::StrCat("median of ", sample.size(), " frames from ", sample.front().number, " to ",
                      sample.back().number);
}

size_t CountFrames(const Statistics& frames,
                   const std::function<bool(const DepthStatistics&)>& is) {
  return static_cast<size_t>(std::count_if(frames.begin(), frames.end(), is));
}

// Returns whether there is depth to speak of; the other checks need it.
bool CheckPresence(const Sample& sample, const Statistics& frames, SourceFindings& findings) {
  const double valid = MedianOf(frames, [](const DepthStatistics& s) { return s.valid_share; });
  const auto is_empty = [](const DepthStatistics& s) { return s.valid_share == 0; };
  const auto is_constant = [](const DepthStatistics& s) { return s.is_constant; };
  if (CountFrames(frames, is_empty) == frames.size()) {
    findings.push_back(
        {FindingLevel::kError, "depth-empty",
         absl::StrFormat("no pixel of the depth images has a depth in any of %d "
                         "frames from %d to %d. Are they the depth images, with 16 "
                         "bits a pixel?",
                         frames.size(), sample.front().number, sample.back().number)});
    return false;
  }
  if (CountFrames(frames, is_constant) == frames.size()) {
    findings.push_back(
        {FindingLevel::kError, "depth-constant",
         absl::StrFormat("all pixels of a depth image have one value, %.3f m, in all of %d frames "
                         "from %d to %d: nothing was measured",
                         MedianOf(frames, [](const DepthStatistics& s) { return s.median_m; }),
                         frames.size(), sample.front().number, sample.back().number)});
    return false;
  }
  if (valid < kLeastValid) {
    findings.push_back({FindingLevel::kWarning, "depth-sparse",
                        absl::StrFormat("only %.1f %% of the pixels have a depth (%s; less than "
                                        "%.0f %% hardly gives a map). Is the scene out of the "
                                        "sensor's range?",
                                        100 * valid, Frames(sample), 100 * kLeastValid)});
  }
  return true;
}

void CheckSaturation(const Sample& sample, const Statistics& frames, SourceFindings& findings) {
  const double saturated =
      MedianOf(frames, [](const DepthStatistics& s) { return s.saturated_share; });
  if (saturated <= kMostSaturated) return;
  findings.push_back({FindingLevel::kWarning, "depth-saturated",
                      absl::StrFormat("%.1f %% of the depths are 65535 (%s): taken as no depth, as "
                                      "0 is. If they were measured, give depth in coarser units",
                                      100 * saturated, Frames(sample))});
}

void CheckUnits(const RgbdCalibration& calibration, const Sample& sample, const Statistics& frames,
                SourceFindings& findings) {
  const double median_m = MedianOf(frames, [](const DepthStatistics& s) { return s.median_m; });
  const double far_m = MedianOf(frames, [](const DepthStatistics& s) { return s.far_m; });
  if (median_m >= kLeastMedian_m && far_m <= kMostFar_m) return;
  findings.push_back(
      {FindingLevel::kWarning, "depth-units-implausible",
       absl::StrFormat("with %g depth units a metre half of what is seen is nearer than %.3g m and "
                       "95 %% nearer than %.3g m (%s): such cameras see from %.2f to %.0f m. Set "
                       "depth_units_per_m: 5000 for TUM's files, 1000 for millimetres. Pictures "
                       "alone can't tell the unit, only that this one is improbable",
                       calibration.depth_units_per_m, median_m, far_m, Frames(sample),
                       kLeastMedian_m, kMostFar_m)});
}

SourceFinding TellUnrelated(const DepthAlignment& best, double gain, const Sample& sample) {
  return {FindingLevel::kWarning, "depth-unrelated",
          absl::StrFormat("depth images seem to have nothing to do with their pictures: grey edges "
                          "are %.2f times as strong along the outlines of depth as elsewhere (of "
                          "%d frames from %d to %d; 1 is chance, less than %.1f is too little), "
                          "and depths explain %.0f %% of the parallax of matches. Are they of one "
                          "recording?",
                          best.agreement, sample.size(), sample.front().number,
                          sample.back().number, kLeastAgreement, std::max(0.0, 100 * gain))};
}

SourceFinding TellLate(const AlignmentEvidence& evidence) {
  const double late = evidence.best.late_frames;
  return {FindingLevel::kWarning, "depth-late",
          absl::StrFormat("depth images are about %.1f frames %s their pictures: so moved, grey "
                          "edges along the outlines of depth are %.2f times as strong as "
                          "elsewhere, against %.2f as they are (%d frames, in which the picture "
                          "moves by %.0f px a frame). Associate pictures and depth by the time at "
                          "which they were taken",
                          std::abs(late), late > 0 ? "behind" : "ahead of", evidence.best.agreement,
                          evidence.now.agreement, evidence.frames, evidence.motion_px)};
}

bool IsElsewhere(const OffsetEvidence& evidence) {
  return evidence.now.agreement > kClearlyBetter * evidence.here.agreement;
}

// Returns true where the whole says so, or each half of it on its own.
bool IsUnregistered(const AlignmentEvidence& evidence) {
  return IsElsewhere(evidence) ||
         std::ranges::all_of(evidence.halves, [](const OffsetEvidence& half) {
           return half.frames >= kFewestAligned && half.now.agreement >= kLeastAgreement &&
                  IsElsewhere(half);
         });
}

// Returns true where both halves of the sample say the same offset.
bool IsOffsetStable(const AlignmentEvidence& evidence) {
  return IsElsewhere(evidence) &&
         std::ranges::all_of(evidence.halves, [&](const OffsetEvidence& half) {
           return cv::norm(half.now.offset_px - evidence.now.offset_px) <= kSameOffset_px;
         });
}

SourceFinding TellUnregistered(const AlignmentEvidence& evidence) {
  if (!IsOffsetStable(evidence)) {
    return {FindingLevel::kWarning, "depth-not-registered",
            absl::StrFormat("outlines of depth do not lie on those of the pictures, and no one "
                            "offset brings them there (%d frames): it is another one beside what "
                            "is near than beside what is far, as where depth is that of a second "
                            "camera. Register depth to the picture with the calibration between "
                            "the two cameras",
                            evidence.frames)};
  }
  return {FindingLevel::kWarning, "depth-not-registered",
          absl::StrFormat("depth images are %.0f px beside their pictures: moved by %.0f px to the "
                          "right and %.0f px down, grey edges along the outlines of depth are %.2f "
                          "times as strong as elsewhere, against %.2f as they are (%d frames). "
                          "Register depth to the picture with the calibration between the two "
                          "cameras",
                          cv::norm(evidence.now.offset_px), evidence.now.offset_px.x,
                          evidence.now.offset_px.y, evidence.now.agreement, evidence.here.agreement,
                          evidence.frames)};
}

void CheckAlignment(const RgbdCalibration& calibration, const Sample& sample,
                    SourceFindings& findings) {
  const AlignmentEvidence evidence = AlignDepth(sample);
  if (evidence.frames < kFewestAligned) return;
  const double late = std::abs(evidence.best.late_frames);
  if (evidence.best.agreement < kLeastAgreement) {
    const double gain = MeasureParallaxGain(calibration, sample);
    if (gain < kLeastParallaxGain) {
      findings.push_back(TellUnrelated(evidence.best, gain, sample));
    }
  } else if (late >= kLate_frames && late * evidence.motion_px >= kLateMotion_px &&
             evidence.best.agreement > kClearlyBetter * evidence.now.agreement) {
    findings.push_back(TellLate(evidence));
  } else if (IsUnregistered(evidence)) {
    findings.push_back(TellUnregistered(evidence));
  }
}

}  // namespace

DepthStatistics MeasureDepth(const cv::Mat& depth, double units_per_m) {
  DepthStatistics statistics;
  const double units = depth.type() == CV_16UC1 ? units_per_m : 1;
  std::vector<double> values;
  size_t pixels = 0;
  size_t saturated = 0;
  for (int y = kStep_px / 2; y < depth.rows; y += kStep_px) {
    for (int x = kStep_px / 2; x < depth.cols; x += kStep_px) {
      const double value = ValueAt(depth, x, y);
      ++pixels;
      if (depth.type() == CV_16UC1 && value == kSaturated) {
        ++saturated;
      } else if (value > 0) {
        values.push_back(value / units);
      }
    }
  }
  if (pixels == 0) return statistics;
  statistics.saturated_share = static_cast<double>(saturated) / static_cast<double>(pixels);
  statistics.valid_share = static_cast<double>(values.size()) / static_cast<double>(pixels);
  if (values.empty()) return statistics;
  std::sort(values.begin(), values.end());
  statistics.near_m = Rank(values, 0.05);
  statistics.median_m = Rank(values, 0.5);
  statistics.far_m = Rank(values, 0.95);
  statistics.is_constant = values.front() == values.back();
  return statistics;
}

SourceFindings CheckDepth(const RgbdCalibration& calibration, const Sample& sample) {
  SourceFindings findings;
  const Sample whole = KeepWhole(calibration.camera, sample, findings);
  if (whole.empty()) return findings;
  Statistics frames;
  for (const SampleFrame& frame : whole) {
    frames.push_back(MeasureDepth(frame.images.depth, calibration.depth_units_per_m));
  }
  if (!CheckPresence(whole, frames, findings)) return findings;
  CheckSaturation(whole, frames, findings);
  CheckUnits(calibration, whole, frames, findings);
  CheckAlignment(calibration, whole, findings);
  return findings;
}

}  // namespace corbslam::client_agent
