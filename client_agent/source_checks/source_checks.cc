#include "client_agent/source_checks/source_checks.h"

#include <algorithm>
#include <iterator>
#include <opencv2/core.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/source_checks/depth_checks.h"
#include "client_agent/source_checks/picture_checks.h"

namespace corbslam::client_agent {

namespace {

StereoJudgement Judge(const SensorCalibration& calibration, const Sample& sample) {
  StereoJudgement judgement;
  SourceFindings& findings = judgement.findings;
  findings = CheckPictures(calibration, sample);
  const bool hopeless = std::any_of(findings.begin(), findings.end(), [](const SourceFinding& f) {
    return f.level == FindingLevel::kError;
  });
  if (hopeless) return judgement;
  const auto* const stereo = std::get_if<StereoCalibration>(&calibration);
  StereoJudgement others =
      stereo != nullptr
          ? JudgeStereoPair(*stereo, sample)
          : StereoJudgement{CheckDepth(std::get<RgbdCalibration>(calibration), sample), {}};
  std::move(others.findings.begin(), others.findings.end(), std::back_inserter(findings));
  judgement.pairs = std::move(others.pairs);
  return judgement;
}

}  // namespace

StereoJudgement JudgeSample(const SensorCalibration& calibration, const Sample& sample) {
  try {
    return Judge(calibration, sample);
  } catch (const cv::Exception& exception) {
    return {{{FindingLevel::kWarning, "pictures-not-judged",
              absl::StrCat("the pictures could not be judged: OpenCV: ", exception.what())}},
            {}};
  }
}

SourceFindings CheckSample(const SensorCalibration& calibration, const Sample& sample) {
  return JudgeSample(calibration, sample).findings;
}

}  // namespace corbslam::client_agent
