#include "client_agent/source_checks/source_checks.h"

#include <algorithm>
#include <iterator>
#include <opencv2/core.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/source_checks/depth_checks.h"
#include "client_agent/source_checks/picture_checks.h"
#include "client_agent/source_checks/stereo_checks.h"

namespace corbslam::client_agent {

namespace {

SourceFindings Check(const SensorCalibration& calibration, const Sample& sample) {
  SourceFindings findings = CheckPictures(calibration, sample);
  const bool hopeless = std::any_of(findings.begin(), findings.end(), [](const SourceFinding& f) {
    return f.level == FindingLevel::kError;
  });
  if (hopeless) return findings;
  const auto* stereo = std::get_if<StereoCalibration>(&calibration);
  SourceFindings others = stereo != nullptr
                              ? CheckStereoPair(*stereo, sample)
                              : CheckDepth(std::get<RgbdCalibration>(calibration), sample);
  std::move(others.begin(), others.end(), std::back_inserter(findings));
  return findings;
}

}  // namespace

SourceFindings CheckSample(const SensorCalibration& calibration, const Sample& sample) {
  try {
    return Check(calibration, sample);
  } catch (const cv::Exception& exception) {
    return {{FindingLevel::kWarning, "pictures-not-judged",
             absl::StrCat("the pictures could not be judged: OpenCV: ", exception.what())}};
  }
}

}  // namespace corbslam::client_agent
