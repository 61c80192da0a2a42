// Prints the statistics that the checks judge by, of a source as it is or damaged, what they find
// and how long they take: docs/sources_checks.md is made of its answers.
//
//   measure_source_checks SOURCE [PLACES [DAMAGE AMOUNT [OTHER_SOURCE]]]
//
// Damage "other" takes right pictures and depths from OTHER_SOURCE. "-" is no damage.
#include <chrono>
#include <cstdio>
#include <iostream>
#include <memory>
#include <string>
#include <utility>

#include "absl/strings/numbers.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source_checks/depth_evidence.h"
#include "client_agent/source_checks/pair_evidence.h"
#include "client_agent/source_checks/testing/damage.h"
#include "slam/camera/rectification.h"

namespace corbslam {
namespace {

double Now_ms() {
  return std::chrono::duration<double, std::milli>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

std::unique_ptr<FrameReader> Open(const std::string& source) {
  return OpenReader(ParseSourceSpec(source).value()).value();
}

void PrintPair(const char* which, size_t number, const PairEvidence& e) {
  std::printf(
      "%zu %s features %zu matches %zu related %zu on_rows %zu offset %.2f roll %.4f "
      "stretch %.4f row_error %.2f residual %.2f + %zu - %zu 0 %zu disparity %.1f\n",
      number, which, e.features, e.matches, e.related, e.on_rows, e.fit.offset_px, e.fit.roll_rad,
      e.fit.stretch, e.row_error_px, e.residual_px, e.positive, e.negative, e.unmoved,
      e.median_disparity_px);
}

void MeasureStereo(const StereoCalibration& calibration, const Sample& sample) {
  std::vector<CheckFeatures> left;
  std::vector<CheckFeatures> right;
  std::optional<StereoRectifier> rectifier;
  if (calibration.raw.has_value()) rectifier = StereoRectifier::Make(*calibration.raw).value();
  for (const SampleFrame& frame : sample) {
    cv::Mat l = frame.images.grey;
    cv::Mat r = frame.images.right;
    if (rectifier.has_value()) {
      cv::Mat rect;
      (void)rectifier->RectifyLeft(l, rect);
      l = rect.clone();
      (void)rectifier->RectifyRight(r, rect);
      r = rect.clone();
    }
    left.push_back(ExtractCheckFeatures(l));
    right.push_back(ExtractCheckFeatures(r));
  }
  const double begin = Now_ms();
  for (size_t i = 0; i < sample.size(); ++i) {
    const cv::Size size = sample[i].images.grey.size();
    PrintPair("same", sample[i].number, GatherPairEvidence(left[i], right[i], size));
    if (i > 0 && sample[i - 1].number + 1 == sample[i].number) {
      PrintPair("before", sample[i].number, GatherPairEvidence(left[i], right[i - 1], size));
    }
    if (i + 1 < sample.size() && sample[i + 1].number == sample[i].number + 1) {
      PrintPair("after", sample[i].number, GatherPairEvidence(left[i], right[i + 1], size));
    }
  }
  std::printf("matching %.1f ms\n", Now_ms() - begin);
}

void MeasureRgbd(const RgbdCalibration& calibration, const Sample& sample) {
  for (size_t i = 0; i < sample.size(); ++i) {
    const DepthStatistics s = MeasureDepth(sample[i].images.depth, calibration.depth_units_per_m);
    std::printf("%zu valid %.3f saturated %.3f near %.2f median %.2f far %.2f constant %d\n",
                sample[i].number, s.valid_share, s.saturated_share, s.near_m, s.median_m, s.far_m,
                s.is_constant);
    const cv::Mat grey = MeasureGreyEdges(sample[i].images.grey);
    for (size_t k = 0; k < sample.size(); ++k) {
      if (std::max(sample[i].number, sample[k].number) -
              std::min(sample[i].number, sample[k].number) >
          4) {
        continue;
      }
      const std::vector<cv::Point> edges = FindDepthEdges(sample[k].images.depth);
      double best = 0;
      cv::Point at;
      for (int y = -16; y <= 16; y += 2) {
        for (int x = -16; x <= 16; x += 2) {
          const double agreement = EdgeAgreement(edges, grey, {x, y});
          if (agreement <= best) continue;
          best = agreement;
          at = {x, y};
        }
      }
      std::printf("  depth %+d edges %zu agree %.3f best %.3f at %d %d\n",
                  static_cast<int>(sample[k].number) - static_cast<int>(sample[i].number),
                  edges.size(), EdgeAgreement(edges, grey, {0, 0}), best, at.x, at.y);
    }
  }
}

int Run(int argc, char** argv) {
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
  Sample sample;
  const double begin = Now_ms();
  for (const size_t number :
       ChooseSampleFrames(reader->calibration(), 0, reader->frame_count(), options)) {
    sample.push_back({number, read(number).value()});
  }
  std::printf("reading %.1f ms\n", Now_ms() - begin);
  const double middle = Now_ms();
  if (const auto* stereo = std::get_if<StereoCalibration>(&reader->calibration())) {
    MeasureStereo(*stereo, sample);
  } else {
    MeasureRgbd(std::get<RgbdCalibration>(reader->calibration()), sample);
  }
  std::printf("measuring %.1f ms\n", Now_ms() - middle);
  return 0;
}

}  // namespace
}  // namespace corbslam

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: measure_source_checks SOURCE [PLACES [DAMAGE AMOUNT [OTHER_SOURCE]]]\n";
    return 2;
  }
  return corbslam::Run(argc, argv);
}
