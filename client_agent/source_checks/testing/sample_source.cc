#include "client_agent/source_checks/testing/sample_source.h"

#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/source/frame_reader.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {

absl::StatusOr<SampleSource> OpenSampleSource(const std::string& spec) {
  ASSIGN_OR_RETURN(const SourceSpec parsed, ParseSourceSpec(spec));
  ASSIGN_OR_RETURN(std::unique_ptr<FrameReader> opened, OpenReader(parsed));
  const std::shared_ptr<FrameReader> reader = std::move(opened);
  return SampleSource{reader->calibration(), reader->frame_count(),
                      [reader](size_t frame) { return reader->Read(frame); }};
}

absl::StatusOr<Sample> TakeSample(const SampleSource& source, const std::string& damage,
                                  double amount, const SampleOptions& options) {
  const ReadFrame read = Damage(source.read, damage, amount);
  Sample sample;
  for (const size_t number : ChooseSampleFrames(source.calibration, 0, source.frames, options)) {
    ASSIGN_OR_RETURN(SensorImages images, read(number));
    sample.push_back({number, std::move(images)});
  }
  return sample;
}

std::vector<std::string> CodesOf(const SourceFindings& findings) {
  std::vector<std::string> codes;
  for (const SourceFinding& finding : findings) {
    codes.push_back(
        absl::StrCat(finding.level == FindingLevel::kError ? "error " : "warning ", finding.code));
  }
  return codes;
}

}  // namespace corbslam::client_agent
