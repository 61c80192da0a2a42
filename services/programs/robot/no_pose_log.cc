#include "services/programs/robot/no_pose_log.h"

#include <cmath>
#include <opencv2/core.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client_agent/source_checks/picture_checks.h"

namespace corbslam::services {

using client_agent::MeasurePicture;
using client_agent::PictureStatistics;
using client_agent::TrackingResult;
using client_agent::TrackingState;
using client_agent::WhyNoPose;

namespace {

constexpr double kFirst_s = 1;
constexpr double kEvery_s = 10;
// A picture darker, flatter or whiter than this has its few corners from that
// (docs/sources_checks.md has the measurements behind these limits).
constexpr int kDark = 40;
constexpr int kFlat = 32;
constexpr double kWhiteShare = 0.5;
// What a robot sees of itself is less.
constexpr double kMostMasked_percent = 50;

// Says what a picture without corners looks like.
std::string DescribePicture(const cv::Mat& grey) {
  if (grey.empty() || grey.type() != CV_8UC1) return "it shows too little";
  const PictureStatistics picture = MeasurePicture(grey);
  if (picture.white_share > kWhiteShare) {
    return absl::StrFormat("%.0f %% of it are white: it is overexposed", 100 * picture.white_share);
  }
  if (picture.bright < kDark) {
    return absl::StrFormat(
        "it is dark (99 %% of it are below %d of 255): it needs light, a longer "
        "exposure, or nothing before the lens",
        picture.bright + 1);
  }
  if (picture.Contrast() < kFlat) {
    return absl::StrFormat(
        "it has almost no contrast (%d of 255): something covers the lens, or it "
        "sees a bare wall",
        picture.Contrast());
  }
  return "it is blurred, or what it shows is bare";
}

std::string ExplainFewKeypoints(const cv::Mat& grey, double masked_percent) {
  if (masked_percent <= kMostMasked_percent) return DescribePicture(grey);
  return absl::StrFormat(
      "the rig's mask leaves %.0f %% of it out: is it black where the robot sees itself alone?",
      masked_percent);
}

std::string Explain(const TrackingResult& result, const SensorImages& images,
                    double masked_percent) {
  switch (result.why_no_pose) {
    case WhyNoPose::kHasOne:
      return "";
    case WhyNoPose::kFewKeypoints:
      return absl::StrCat("the picture has too few corners; ",
                          ExplainFewKeypoints(images.grey, masked_percent));
    case WhyNoPose::kFewDepths:
      return images.right.empty()
                 ? "too few corners of the picture have a depth; is the depth camera covered, or "
                   "are "
                   "things out of its reach?"
                 : "too few corners of the left picture are found in the right one; is it covered, "
                   "late, or the rig another camera's (corbslam rig check)?";
    case WhyNoPose::kLittleParallax:
      return "one camera alone sees no depth before it has moved aside: move it sideways, by about "
             "a twentieth of how far away what it sees is; turning on the spot does not help";
    case WhyNoPose::kMappingBusy:
      return "mapping still works on earlier frames";
    case WhyNoPose::kMappingPaused:
      return "there is no map, and mapping is paused";
    case WhyNoPose::kNotRecognised:
      return "the picture is good, and the map doesn't show this place from here";
    case WhyNoPose::kAnotherCamera:
      return "what others mapped shows this place, but to another camera than the rig's: is the "
             "rig "
             "file this camera's, of this picture size? (docs/rig.md)";
  }
  return "";
}

}  // namespace

double NoPoseLog::Since_s(int64_t timestamp_ns) const {
  // The frames of a sequence that is played backwards have falling times.
  return 1e-9 * std::abs(static_cast<double>(timestamp_ns - *missing_since_ns_));
}

std::optional<std::string> NoPoseLog::Add(const TrackingResult& result,
                                          const SensorImages& images) {
  if (result.state == TrackingState::kTracking) return AddTracked(result);
  if (!missing_since_ns_.has_value()) missing_since_ns_ = result.timestamp_ns;
  const double since_s = Since_s(result.timestamp_ns);
  if (since_s < (told_s_ == 0 ? kFirst_s : told_s_ + kEvery_s)) return std::nullopt;
  told_s_ = since_s;
  const bool is_lost = result.state == TrackingState::kLost;
  return absl::StrFormat("%s for %.1f s: %s", is_lost ? "lost" : "no map begun", since_s,
                         Explain(result, images, masked_percent_));
}

std::optional<std::string> NoPoseLog::AddTracked(const TrackingResult& result) {
  std::optional<std::string> line;
  if (told_s_ > 0) {
    // A map that is begun has points of its own alone.
    const bool is_others =
        result.foreign_points_matched > 0 && result.foreign_points_matched == result.points_matched;
    const char* const how = last_map_ == result.local_map ? "found again in its map"
                            : is_others                   ? "found in what others mapped"
                                                          : "a map is begun";
    line = absl::StrFormat("%s after %.1f s", how, Since_s(result.timestamp_ns));
  }
  missing_since_ns_ = std::nullopt;
  told_s_ = 0;
  last_map_ = result.local_map;
  return line;
}

}  // namespace corbslam::services
