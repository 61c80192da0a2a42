#include "client_agent/source_checks/depth_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "slam/util/median.h"

namespace corbslam::client_agent {
namespace {

// The checks work on pictures of half the size: outlines of depth are no sharper than that.
constexpr double kScale = 0.5;
constexpr int kReach = 36;  // Largest shift, in half pixels: a delay times a motion, and an offset.
constexpr int kSide = 2 * kReach + 1;
constexpr int kMaxOffset = 12;
constexpr int kHereOffset = 3;
constexpr double kMaxLate_frames = 4;
constexpr double kLateStep_frames = 0.25;
constexpr double kNow_frames = 0.75;
constexpr size_t kMinEdges = 200;
constexpr size_t kMaxEdges = 500;
constexpr double kNoDepth = 65535;
// A pixel nearer than its neighbour by this share is an outline, not a slope.
constexpr float kEdgeStep = 1.1F;
constexpr int kEdgeReach_px = 3;

// How well one frame's outlines agree with its picture, by shift.
struct FrameAgreement {
  cv::Mat by_shift;  // CV_32FC1, kSide x kSide; the middle is no shift.
  size_t frame = 0;  // Index in the sample.
};

// Motion of the picture from each frame of the sample to the next, in half pixels; nothing where
// that isn't in the sample.
using Motions = std::vector<std::optional<cv::Point2d>>;

cv::Mat Halved(const cv::Mat& image, int interpolation) {
  cv::Mat half;
  cv::resize(image, half, {}, kScale, kScale, interpolation);
  return half;
}

// The depths beside (x, y) are both there and one is much nearer.
bool IsStep(float here, float beyond) { return here > 0 && beyond > kEdgeStep * here; }

// Finds pixels on the near side of a step in depth: the outlines of things, which a picture taken
// by the same eye at the same time shows too.
std::vector<cv::Point> FindDepthEdges(const cv::Mat& depth) {
  cv::Mat metres;
  depth.convertTo(metres, CV_32F);
  if (depth.type() == CV_16UC1) metres.setTo(0, depth == kNoDepth);
  std::vector<cv::Point> edges;
  for (int y = kEdgeReach_px; y < depth.rows - kEdgeReach_px; ++y) {
    const auto* row = metres.ptr<float>(y);
    const auto* above = metres.ptr<float>(y - kEdgeReach_px);
    const auto* below = metres.ptr<float>(y + kEdgeReach_px);
    for (int x = kEdgeReach_px; x < depth.cols - kEdgeReach_px; ++x) {
      const float here = row[x];
      if (IsStep(here, row[x - kEdgeReach_px]) || IsStep(here, row[x + kEdgeReach_px]) ||
          IsStep(here, above[x]) || IsStep(here, below[x])) {
        edges.emplace_back(x, y);
      }
    }
  }
  return edges;
}

// Returns how strongly grey values change at each pixel, 0 to 255, against their surroundings:
// CV_8UC1.
cv::Mat MeasureGreyEdges(const cv::Mat& grey) {
  cv::Mat smooth;
  cv::GaussianBlur(grey, smooth, {5, 5}, 1.0);
  cv::Mat across;
  cv::Mat along;
  cv::Sobel(smooth, across, CV_16S, 1, 0);
  cv::Sobel(smooth, along, CV_16S, 0, 1);
  cv::Mat edges;
  cv::Mat other;
  cv::convertScaleAbs(across, edges, 0.5);
  cv::convertScaleAbs(along, other, 0.5);
  cv::max(edges, other, edges);
  return edges;
}

std::vector<cv::Point> Thinned(std::vector<cv::Point> points) {
  const size_t step = points.size() / kMaxEdges + 1;
  std::vector<cv::Point> kept;
  for (size_t i = 0; i < points.size(); i += step) kept.push_back(points[i]);
  return kept;
}

// Returns nothing where there are too few outlines or no edges.
std::optional<cv::Mat> AgreementByShift(const SensorImages& images) {
  const std::vector<cv::Point> outlines = FindDepthEdges(Halved(images.depth, cv::INTER_NEAREST));
  if (outlines.size() < kMinEdges) return std::nullopt;
  const std::vector<cv::Point> points = Thinned(outlines);
  cv::Mat edges = MeasureGreyEdges(Halved(images.grey, cv::INTER_AREA));
  const double everywhere = cv::mean(edges)[0];
  if (everywhere <= 0) return std::nullopt;
  cv::copyMakeBorder(edges, edges, kReach, kReach, kReach, kReach, cv::BORDER_REFLECT);
  cv::Mat by_shift(kSide, kSide, CV_32FC1);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      uint32_t sum = 0;
      for (const cv::Point& point : points) sum += edges.at<uint8_t>(point.y + y, point.x + x);
      by_shift.at<float>(y, x) =
          static_cast<float>(sum / (static_cast<double>(points.size()) * everywhere));
    }
  }
  return by_shift;
}

// Returns by how much the picture moves from `a` to `b`, in half pixels (phase correlation).
cv::Point2d MeasureMotion(const cv::Mat& a, const cv::Mat& b) {
  constexpr double kQuarter = 0.25;
  cv::Mat small_a;
  cv::Mat small_b;
  cv::resize(a, small_a, {}, kQuarter, kQuarter, cv::INTER_AREA);
  cv::resize(b, small_b, {}, kQuarter, kQuarter, cv::INTER_AREA);
  small_a.convertTo(small_a, CV_32F);
  small_b.convertTo(small_b, CV_32F);
  cv::Mat window;
  cv::createHanningWindow(window, small_a.size(), CV_32F);
  return cv::phaseCorrelate(small_a, small_b, window) * (kScale / kQuarter);
}

bool AreNeighbours(const Sample& sample, size_t i, size_t k) {
  return k < sample.size() && sample[i].number + 1 == sample[k].number &&
         sample[i].images.grey.size() == sample[k].images.grey.size();
}

Motions MeasureMotions(const Sample& sample) {
  Motions motions(sample.size());
  for (size_t i = 0; i + 1 < sample.size(); ++i) {
    if (!AreNeighbours(sample, i, i + 1)) continue;
    motions[i] = MeasureMotion(sample[i].images.grey, sample[i + 1].images.grey);
  }
  return motions;
}

bool HasNeighbour(const Motions& motions, size_t frame) {
  return motions[frame].has_value() || (frame > 0 && motions[frame - 1].has_value());
}

std::vector<FrameAgreement> Agreements(const Sample& sample, const Motions& motions) {
  std::vector<FrameAgreement> agreements;
  for (size_t i = 0; i < sample.size(); ++i) {
    if (!HasNeighbour(motions, i)) continue;
    const std::optional<cv::Mat> by_shift = AgreementByShift(sample[i].images);
    if (by_shift.has_value()) agreements.push_back({*by_shift, i});
  }
  return agreements;
}

// Returns by how much the picture has moved since `late` frames before `frame` (or until as many
// after, where that is negative). Beyond the sample it goes on as it was last seen to move.
cv::Point2d MotionSince(const Motions& motions, size_t frame, double late) {
  const bool back = late > 0;
  cv::Point2d moved;
  cv::Point2d step;
  if (HasNeighbour(motions, frame)) {
    step = motions[frame].has_value() ? *motions[frame] : *motions[frame - 1];
  }
  size_t at = frame;
  for (double left = std::abs(late); left > 0; left -= 1) {
    const std::optional<size_t> between = !back    ? std::optional<size_t>(at)
                                          : at > 0 ? std::optional<size_t>(at - 1)
                                                   : std::nullopt;
    if (between.has_value() && *between < motions.size() && motions[*between].has_value()) {
      step = *motions[*between];
      at = back ? at - 1 : at + 1;
    }
    moved += step * std::min(left, 1.0);
  }
  return back ? moved : -moved;
}

// Returns the mean over all frames; a shift out of reach counts as agreement by chance.
double MeanAgreement(const std::vector<FrameAgreement>& frames, const std::vector<cv::Point>& moved,
                     const cv::Point& offset) {
  double sum = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    const cv::Point at = cv::Point(kReach, kReach) + offset + moved[i];
    const bool within = cv::Rect(0, 0, kSide, kSide).contains(at);
    sum += within ? static_cast<double>(frames[i].by_shift.at<float>(at)) : 1.0;
  }
  return sum / static_cast<double>(frames.size());
}

double MedianMotion_px(const Motions& motions) {
  std::vector<double> lengths;
  for (const std::optional<cv::Point2d>& motion : motions) {
    if (motion.has_value()) lengths.push_back(cv::norm(*motion) / kScale);
  }
  return lengths.empty() ? 0 : Median(std::move(lengths));
}

void Offer(const DepthAlignment& candidate, DepthAlignment& best) {
  if (candidate.agreement > best.agreement) best = candidate;
}

// Tries all offsets at one delay.
void TryOffsets(const std::vector<FrameAgreement>& frames, const Motions& motions, double late,
                OffsetEvidence& evidence, DepthAlignment* best) {
  std::vector<cv::Point> moved;
  for (const FrameAgreement& frame : frames) {
    moved.emplace_back(MotionSince(motions, frame.frame, late));
  }
  for (int y = -kMaxOffset; y <= kMaxOffset; ++y) {
    for (int x = -kMaxOffset; x <= kMaxOffset; ++x) {
      const DepthAlignment candidate{
          late, {x / kScale, y / kScale}, MeanAgreement(frames, moved, {x, y})};
      if (best != nullptr) Offer(candidate, *best);
      if (std::abs(late) > kNow_frames) continue;
      Offer(candidate, evidence.now);
      if (x * x + y * y <= kHereOffset * kHereOffset) Offer(candidate, evidence.here);
    }
  }
}

}  // namespace

AlignmentEvidence AlignDepth(const Sample& sample) {
  AlignmentEvidence evidence;
  const Motions motions = MeasureMotions(sample);
  const std::vector<FrameAgreement> frames = Agreements(sample, motions);
  evidence.frames = frames.size();
  if (frames.empty()) return evidence;
  evidence.motion_px = MedianMotion_px(motions);
  for (double late = -kMaxLate_frames; late <= kMaxLate_frames; late += kLateStep_frames) {
    TryOffsets(frames, motions, late, evidence, &evidence.best);
  }
  const auto middle = frames.begin() + static_cast<std::ptrdiff_t>(frames.size() / 2);
  const std::array<std::vector<FrameAgreement>, 2> halves = {
      std::vector<FrameAgreement>(frames.begin(), middle),
      std::vector<FrameAgreement>(middle, frames.end())};
  for (size_t half = 0; half < halves.size(); ++half) {
    evidence.halves[half].frames = halves[half].size();
    if (halves[half].empty()) continue;
    for (double late = -kNow_frames; late <= kNow_frames; late += kLateStep_frames) {
      TryOffsets(halves[half], motions, late, evidence.halves[half], nullptr);
    }
  }
  return evidence;
}

}  // namespace corbslam::client_agent
