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
  StereoJudgement others;
  if (const auto* const stereo = std::get_if<StereoCalibration>(&calibration)) {
    others = JudgeStereoPair(*stereo, sample);
  } else if (const auto* const rgbd = std::get_if<RgbdCalibration>(&calibration)) {
    others.findings = CheckDepth(*rgbd, sample);
  }
  std::move(others.findings.begin(), others.findings.end(), std::back_inserter(findings));
  judgement.pairs = std::move(others.pairs);
  return judgement;
}

struct SampleRead {
  Sample frames;
  size_t asked_for = 0;
  size_t unreadable = 0;
  std::string why;  // Why the first could not be read.
};

SampleRead ReadFrames(const FrameReader& reader, const std::vector<size_t>& numbers) {
  SampleRead sample;
  sample.asked_for = numbers.size();
  for (const size_t number : numbers) {
    absl::StatusOr<SensorImages> images = reader.Read(number);
    if (images.ok()) {
      sample.frames.push_back({number, *std::move(images)});
    } else if (sample.unreadable++ == 0) {
      sample.why = std::string(images.status().message());
    }
  }
  return sample;
}

void TellUnreadable(const SampleRead& sample, SourceFindings& findings) {
  if (sample.unreadable == 0) return;
  const std::string text =
      absl::StrCat(sample.unreadable, " of ", sample.asked_for,
                   " frames that were looked at can't be read, the first because of ", sample.why);
  const bool all = sample.frames.empty();
  findings.push_back({all ? FindingLevel::kError : FindingLevel::kWarning, "pictures-unreadable",
                      all ? text : absl::StrCat(text, ": such frames are left out")});
}

SampleRead ReadChosen(const FrameReader& reader, const SourceSpec& spec,
                      const SampleOptions& options) {
  const FrameRange range = SelectRange(spec.selection, reader.frame_count());
  return ReadFrames(reader, ChooseSampleFrames(reader.calibration(), range.begin,
                                               std::max(range.begin, range.end), options));
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

Inspection LookIntoSource(const FrameReader& reader, const SourceSpec& spec,
                          const SampleOptions& options) {
  Inspection inspection;
  SourceFindings& findings = inspection.findings;
  findings = reader.description().remarks.findings;
  SampleRead read = ReadChosen(reader, spec, options);
  TellUnreadable(read, findings);
  inspection.sample = std::move(read.frames);
  if (inspection.sample.empty() || spec.layout == SourceLayout::kRegistered) return inspection;
  StereoJudgement seen = JudgeSample(reader.calibration(), inspection.sample);
  if (spec.layout == SourceLayout::kSevenScenes) {
    // 65535 is what this layout says where there is no depth.
    std::erase_if(seen.findings,
                  [](const SourceFinding& f) { return f.code == "depth-saturated"; });
  }
  std::move(seen.findings.begin(), seen.findings.end(), std::back_inserter(findings));
  inspection.pairs = std::move(seen.pairs);
  return inspection;
}

SourceFindings InspectSource(const FrameReader& reader, const SourceSpec& spec,
                             const SampleOptions& options) {
  if (spec.layout == SourceLayout::kRegistered) return reader.description().remarks.findings;
  return LookIntoSource(reader, spec, options).findings;
}

}  // namespace corbslam::client_agent
