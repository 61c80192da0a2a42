// Prints the statistics that the checks judge by, of a source as it is or damaged, what they find
// and how long they take: docs/sources_checks.md is made of its answers.
//
//   measure_source_checks SOURCE [PLACES|watch [DAMAGE AMOUNT [OTHER_SOURCE]]]
//
// Damage "other" takes right pictures and depths from OTHER_SOURCE. "-" is no damage.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source_checks/depth_alignment.h"
#include "client_agent/source_checks/depth_checks.h"
#include "client_agent/source_checks/depth_parallax.h"
#include "client_agent/source_checks/input_watch.h"
#include "client_agent/source_checks/pair_evidence.h"
#include "client_agent/source_checks/picture_checks.h"
#include "client_agent/source_checks/stereo_checks.h"
#include "client_agent/source_checks/testing/damage.h"

namespace corbslam::client_agent {
namespace {

double Now_ms() {
  return std::chrono::duration<double, std::milli>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

std::unique_ptr<FrameReader> Open(const std::string& source) {
  return OpenReader(ParseSourceSpec(source).value()).value();
}

std::map<std::string, std::vector<double>> columns;
void Note(const std::string& name, double v) { columns[name].push_back(v); }
void PrintColumns() {
  for (auto& [name, values] : columns) {
    std::sort(values.begin(), values.end());
    std::printf("  %-22s %8.3f %8.3f %8.3f\n", name.c_str(), values.front(),
                values[values.size() / 2], values.back());
  }
}
double Share(size_t part, size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

void NotePicture(const PictureStatistics& s) {
  Note("grey of 99 %", s.bright);
  Note("contrast", s.Contrast());
  Note("white share", s.white_share);
}

void NotePair(const PairEvidence& e) {
  Note("features", static_cast<double>(e.features));
  Note("matches of features", Share(e.matches, e.features));
  Note("related of features", Share(e.related, e.features));
  Note("related of matches", Share(e.related, e.matches));
  Note("score of matches", e.row_score / (static_cast<double>(e.matches) + 1e-9));
  Note("|offset| px", std::abs(e.fit.offset_px));
  Note("|roll| degrees", std::abs(e.fit.roll_rad) * 180 / std::numbers::pi);
  Note("|stretch|", std::abs(e.fit.stretch));
  Note("row error px", e.row_error_px);
  Note("residual px", e.residual_px);
  Note("negative of signed", Share(e.negative, e.negative + e.positive));
  Note("signed of related", Share(e.negative + e.positive, e.related));
  Note("unmoved of related", Share(e.unmoved, e.related));
  Note("disparity px", e.median_disparity_px);
}

void MeasureStereo(const StereoCalibration& calibration, const Sample& sample) {
  const PairPreparation preparation = PairPreparation::Make(calibration).value();
  for (const JudgedPair& pair : preparation.Judge(sample)) {
    NotePair(pair.evidence);
    if (pair.with_before.has_value()) {
      Note("score before", pair.with_before->row_score / (pair.evidence.row_score + 1e-9));
    }
    if (pair.with_after.has_value()) {
      Note("score after", pair.with_after->row_score / (pair.evidence.row_score + 1e-9));
    }
  }
}

void MeasureRgbd(const RgbdCalibration& calibration, const Sample& sample) {
  for (size_t i = 0; i < sample.size(); ++i) {
    const DepthStatistics s = MeasureDepth(sample[i].images.depth, calibration.depth_units_per_m);
    std::printf("%zu valid %.3f saturated %.3f near %.2f median %.2f far %.2f constant %d\n",
                sample[i].number, s.valid_share, s.saturated_share, s.near_m, s.median_m, s.far_m,
                s.is_constant);
  }
  const AlignmentEvidence e = AlignDepth(sample);
  for (size_t i = 0; i + 4 < sample.size(); i += 5) {
    const double at = Now_ms();
    const ParallaxEvidence p = CompareParallax(calibration, sample[i].images, sample[i + 4].images);
    std::printf("  parallax: rigid %zu with depths %zu with one %zu, %.1f ms\n", p.rigid,
                p.with_depths, p.with_one_depth, Now_ms() - at);
  }
  std::printf("frames %zu motion %.1f px\n", e.frames, e.motion_px);
  for (const DepthAlignment& a : {e.best, e.now, e.here}) {
    std::printf("  late %.1f offset %.0f %.0f agreement %.3f\n", a.late_frames, a.offset_px.x,
                a.offset_px.y, a.agreement);
  }
}

// Prints what a robot's sensor makes of the frames in turn.
void MeasureWatch(const SensorCalibration& calibration, const ReadFrame& read, size_t frames) {
  const bool is_stereo = KindOf(calibration) == SensorKind::kStereo;
  SensorOptions options;
  options.orb.features = is_stereo ? 2000 : 1000;
  const std::unique_ptr<Sensor> sensor = MakeSensor(calibration, options).value();
  InputWatch watch(calibration);
  double adding_ms = 0;
  for (size_t i = 0; i < frames; ++i) {
    const Features features = sensor->Process(read(i).value()).value();
    size_t with_depth = 0;
    size_t at_infinity = 0;
    for (const Keypoint& keypoint : features.keypoints) {
      with_depth += keypoint.HasDepth() ? 1 : 0;
      at_infinity += keypoint.HasDepth() && keypoint.disparity_px < 0.5F ? 1 : 0;
    }
    Note("features", static_cast<double>(features.keypoints.size()));
    Note("with depth", Share(with_depth, features.keypoints.size()));
    Note("at infinity", Share(at_infinity, with_depth));
    const double at = Now_ms();
    const std::optional<SourceFinding> finding = watch.Add(features);
    adding_ms += Now_ms() - at;
    if (finding.has_value()) std::printf("frame %zu: %s\n", i, finding->text.c_str());
  }
  PrintColumns();
  std::printf("InputWatch %.4f ms a frame\n", adding_ms / static_cast<double>(frames));
}

int Run(int argc, char** argv) {
  const absl::StatusOr<SourceSpec> spec = ParseSourceSpec(argv[1]);
  if (!spec.ok()) {
    std::cerr << spec.status().message() << "\n";
    return 2;
  }
  const std::unique_ptr<FrameReader> reader = Open(argv[1]);
  SampleOptions options;
  if (argc > 2) options.places = static_cast<size_t>(std::atoi(argv[2]));
  ReadFrame read = [&](size_t frame) { return reader->Read(frame); };
  std::unique_ptr<FrameReader> other;
  if (argc > 5) {
    other = Open(argv[5]);
    read = [&](size_t frame) -> absl::StatusOr<SensorImages> {
      SensorImages images = *reader->Read(frame);
      const SensorImages wrong = *other->Read(frame % other->frame_count());
      images.right = wrong.right;
      images.depth = wrong.depth;
      return images;
    };
  } else if (argc > 4 && std::string(argv[3]) != "-") {
    read = Damage(read, argv[3], std::atof(argv[4]));
  }
  if (argc > 2 && std::string(argv[2]) == "watch") {
    MeasureWatch(reader->calibration(), read, std::min<size_t>(reader->frame_count(), 70));
    return 0;
  }
  Sample sample;
  const double begin = Now_ms();
  for (const size_t number :
       ChooseSampleFrames(reader->calibration(), 0, reader->frame_count(), options)) {
    sample.push_back({number, read(number).value()});
  }
  std::printf("reading %.1f ms\n", Now_ms() - begin);
  const double middle = Now_ms();
  for (const SampleFrame& frame : sample) {
    for (const cv::Mat& picture : {frame.images.grey, frame.images.right}) {
      if (!picture.empty()) NotePicture(MeasurePicture(picture));
    }
  }
  if (const auto* stereo = std::get_if<StereoCalibration>(&reader->calibration())) {
    MeasureStereo(*stereo, sample);
  } else {
    MeasureRgbd(std::get<RgbdCalibration>(reader->calibration()), sample);
  }
  PrintColumns();
  const double end = Now_ms();
  SourceFindings findings = CheckPictures(reader->calibration(), sample);
  std::printf("CheckPictures %.1f ms\n", Now_ms() - end);
  if (const auto* stereo = std::get_if<StereoCalibration>(&reader->calibration())) {
    const double at = Now_ms();
    const StereoJudgement judgement = JudgeStereoPair(*stereo, sample);
    findings.insert(findings.end(), judgement.findings.begin(), judgement.findings.end());
    std::printf("JudgeStereoPair %.1f ms\n", Now_ms() - at);
  } else {
    const double at = Now_ms();
    for (const SourceFinding& f :
         CheckDepth(std::get<RgbdCalibration>(reader->calibration()), sample)) {
      findings.push_back(f);
    }
    std::printf("CheckDepth %.1f ms\n", Now_ms() - at);
  }
  for (const SourceFinding& f : findings) {
    std::printf("%s %s: %s\n", f.level == FindingLevel::kError ? "ERROR" : "WARNING",
                f.code.c_str(), f.text.c_str());
  }
  std::printf("measuring %.1f ms\n", Now_ms() - middle);
  return 0;
}

}  // namespace
}  // namespace corbslam::client_agent

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr
        << "usage: measure_source_checks SOURCE [PLACES|watch [DAMAGE AMOUNT [OTHER_SOURCE]]]\n";
    return 2;
  }
  return corbslam::client_agent::Run(argc, argv);
}
