// Learns the binary tests of the descriptor from pictures and prints learned_brief_pattern.cc.
//
//   learn_brief_pattern FOLDER_OF_PICTURES > slam/features/learned_brief_pattern.cc
//
// After rBRIEF (Rublee et al., ICCV 2011, 4.3): of many random tests the greedy choice takes those
// of high variance that correlate little with the ones taken. Here variance alone does not rank
// the tests, but how many more bits differ between unrelated patches than between two views of
// the same corner, the second view being a turned, scaled and noisy copy of the picture.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "slam/features/gaussian_blur.h"
#include "slam/features/orb_extractor.h"
#include "slam/features/steered_brief.h"

namespace corbslam {
namespace {

constexpr int kSide_px = 2 * kBriefRadius_px + 1;
constexpr size_t kPatchesPerPicture = 120;
constexpr size_t kCandidates = 60000;
constexpr double kFirstCorrelation = 0.10;
constexpr double kCorrelationStep = 0.02;

// Turned patches, stored by pixel so that a test compares two rows.
struct Patches {
  std::vector<std::vector<uint8_t>> grey_of_pixel{kSide_px * kSide_px};

  size_t size() const { return grey_of_pixel[0].size(); }
};

struct View {
  Features features;
  ImagePyramid pyramid;
  std::vector<cv::Mat> blurred;
};

View MakeView(const cv::Mat& picture) {
  View view;
  OrbExtractor extractor(OrbOptions{.features = 1500});
  if (!extractor.Extract(picture, view.features, view.pyramid).ok()) return view;
  for (const cv::Mat& level : view.pyramid.levels) {
    if (level.empty()) break;
    BlurGaussian7x7(level, view.blurred.emplace_back());
  }
  return view;
}

// Returns a uniform number in [low, high); the same on every platform, which std distributions are
// not.
double Uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

// Makes a second look at the picture: turned by up to 20 degrees, scaled by up to 12 %, squeezed a
// little, with other gain and with noise.
cv::Mat WarpAndDegrade(const cv::Mat& picture, const cv::Matx23d& warp, std::mt19937_64& random) {
  cv::Mat warped;
  cv::warpAffine(picture, warped, warp, picture.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT_101);
  const double gain = Uniform(random, 0.8, 1.2);
  for (int y = 0; y < warped.rows; ++y) {
    for (int x = 0; x < warped.cols; ++x) {
      // The sum of three uniform values is near enough to a normal one of sigma 5.
      double noise = 0;
      for (int i = 0; i < 3; ++i) noise += Uniform(random, -5, 5);
      warped.at<uint8_t>(y, x) =
          cv::saturate_cast<uint8_t>(gain * warped.at<uint8_t>(y, x) + noise);
    }
  }
  return warped;
}

cv::Matx23d RandomWarp(const cv::Size& size, std::mt19937_64& random) {
  const double angle = Uniform(random, -20, 20) * std::numbers::pi / 180;
  const double scale = Uniform(random, 0.88, 1.12);
  const double squeeze = Uniform(random, 0.92, 1.0);
  const cv::Matx22d turn(scale * std::cos(angle), -scale * squeeze * std::sin(angle),
                         scale * std::sin(angle), scale * squeeze * std::cos(angle));
  const cv::Vec2d centre(size.width / 2.0, size.height / 2.0);
  const cv::Vec2d shift = centre - turn * centre;
  return {turn(0, 0), turn(0, 1), shift[0], turn(1, 0), turn(1, 1), shift[1]};
}

std::optional<size_t> FindCounterpart(const View& view, const Keypoint& keypoint,
                                      const cv::Matx23d& warp) {
  const cv::Vec2d expected = warp * cv::Vec3d(keypoint.x_px, keypoint.y_px, 1);
  double least = 1.5 * ScalePyramid::Scale(keypoint.octave);
  std::optional<size_t> found;
  for (size_t i = 0; i < view.features.keypoints.size(); ++i) {
    const Keypoint& other = view.features.keypoints[i];
    if (std::abs(other.octave - keypoint.octave) > 1) continue;
    const double distance = std::hypot(other.x_px - expected[0], other.y_px - expected[1]);
    if (distance < least) {
      least = distance;
      found = i;
    }
  }
  return found;
}

void AppendPatch(const View& view, const Keypoint& keypoint, Patches& patches) {
  const cv::Mat& level = view.blurred[keypoint.octave];
  const long x = std::lround(view.pyramid.FromLevel0X(keypoint.x_px, keypoint.octave));
  const long y = std::lround(view.pyramid.FromLevel0Y(keypoint.y_px, keypoint.octave));
  const double cosine = std::cos(keypoint.angle_rad);
  const double sine = std::sin(keypoint.angle_rad);
  for (int v = -kBriefRadius_px; v <= kBriefRadius_px; ++v) {
    for (int u = -kBriefRadius_px; u <= kBriefRadius_px; ++u) {
      const bool inside = u * u + v * v <= kBriefRadius_px * kBriefRadius_px;
      const long turned_x = x + std::lround(cosine * u - sine * v);
      const long turned_y = y + std::lround(sine * u + cosine * v);
      const size_t pixel =
          static_cast<size_t>((v + kBriefRadius_px) * kSide_px + u + kBriefRadius_px);
      patches.grey_of_pixel[pixel].push_back(
          inside ? level.at<uint8_t>(static_cast<int>(turned_y), static_cast<int>(turned_x))
                 : uint8_t{0});
    }
  }
}

// Appends two views of the same corners of one picture.
void CollectPatches(const cv::Mat& picture, std::mt19937_64& random, Patches& first,
                    Patches& second) {
  const cv::Matx23d warp = RandomWarp(picture.size(), random);
  const View view = MakeView(picture);
  const View other = MakeView(WarpAndDegrade(picture, warp, random));
  std::vector<size_t> order(view.features.keypoints.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = i;
  for (size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  size_t taken = 0;
  for (const size_t i : order) {
    const Keypoint& keypoint = view.features.keypoints[i];
    const std::optional<size_t> counterpart = FindCounterpart(other, keypoint, warp);
    if (!counterpart.has_value()) continue;
    AppendPatch(view, keypoint, first);
    AppendPatch(other, other.features.keypoints[*counterpart], second);
    if (++taken == kPatchesPerPicture) break;
  }
}

struct Candidate {
  BriefTest test;
  std::vector<uint64_t> bits;  // The test's results on all first patches.
  double mean = 0;
  double gain = 0;
};

std::vector<uint64_t> ComputeBits(const Patches& patches, const BriefTest& test) {
  const auto row = [&](int x, int y) -> const std::vector<uint8_t>& {
    return patches
        .grey_of_pixel[static_cast<size_t>((y + kBriefRadius_px) * kSide_px + x + kBriefRadius_px)];
  };
  const std::vector<uint8_t>& a = row(test.x1, test.y1);
  const std::vector<uint8_t>& b = row(test.x2, test.y2);
  std::vector<uint64_t> bits((a.size() + 63) / 64);
  for (size_t i = 0; i < a.size(); ++i) {
    bits[i / 64] |= static_cast<uint64_t>(a[i] < b[i]) << (i % 64);
  }
  return bits;
}

Candidate Evaluate(const Patches& first, const Patches& second, const BriefTest& test) {
  Candidate candidate{.test = test, .bits = ComputeBits(first, test)};
  const std::vector<uint64_t> other = ComputeBits(second, test);
  int set = 0;
  int flipped = 0;
  for (size_t i = 0; i < other.size(); ++i) {
    set += std::popcount(candidate.bits[i]);
    flipped += std::popcount(candidate.bits[i] ^ other[i]);
  }
  const double count = static_cast<double>(first.size());
  candidate.mean = set / count;
  candidate.gain = 2 * candidate.mean * (1 - candidate.mean) - flipped / count;
  return candidate;
}

BriefTest RandomTest(std::mt19937_64& random) {
  const auto offset = [&] { return static_cast<int8_t>(random() % kSide_px) - kBriefRadius_px; };
  while (true) {
    const int x1 = offset(), y1 = offset(), x2 = offset(), y2 = offset();
    constexpr int kSquare = kBriefRadius_px * kBriefRadius_px;
    if (x1 * x1 + y1 * y1 > kSquare || x2 * x2 + y2 * y2 > kSquare) continue;
    if (x1 == x2 && y1 == y2) continue;
    return {static_cast<int8_t>(x1), static_cast<int8_t>(y1), static_cast<int8_t>(x2),
            static_cast<int8_t>(y2)};
  }
}

double AbsoluteCorrelation(const Candidate& a, const Candidate& b, double count) {
  int both = 0;
  for (size_t i = 0; i < a.bits.size(); ++i) both += std::popcount(a.bits[i] & b.bits[i]);
  const double covariance = both / count - a.mean * b.mean;
  return std::abs(covariance) / std::sqrt(a.mean * (1 - a.mean) * b.mean * (1 - b.mean));
}

// Chooses greedily; the limit on correlation is raised until it yields enough tests.
std::vector<BriefTest> Choose(const std::vector<Candidate>& ranked, double count) {
  for (double limit = kFirstCorrelation; limit < 1; limit += kCorrelationStep) {
    std::vector<const Candidate*> taken;
    for (const Candidate& candidate : ranked) {
      const bool independent = std::none_of(taken.begin(), taken.end(), [&](const auto* other) {
        return AbsoluteCorrelation(*other, candidate, count) > limit;
      });
      if (independent) taken.push_back(&candidate);
      if (taken.size() == kBriefTests) break;
    }
    std::cerr << "correlation <= " << limit << ": " << taken.size() << " tests\n";
    if (taken.size() < kBriefTests) continue;
    std::vector<BriefTest> tests;
    for (const Candidate* candidate : taken) tests.push_back(candidate->test);
    return tests;
  }
  return {};
}

void Print(const std::vector<BriefTest>& tests, size_t pictures, size_t patches) {
  std::cout << "// Written by learn_brief_pattern: " << patches << " pairs of patches of "
            << pictures << " pictures. Do not edit.\n#include \"slam/features/steered_brief.h\"\n\n"
            << "namespace corbslam {\n\nconst BriefPattern& LearnedBriefPattern() {\n"
            << "  // clang-format off\n  static constexpr BriefPattern kPattern = {{\n";
  for (const BriefTest& t : tests) {
    std::cout << "      {" << int{t.x1} << ", " << int{t.y1} << ", " << int{t.x2} << ", "
              << int{t.y2} << "},\n";
  }
  std::cout << "  }};\n  // clang-format on\n  return kPattern;\n}\n\n}  // namespace corbslam\n";
}

int Run(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::mt19937_64 random(1);
  Patches first;
  Patches second;
  size_t pictures = 0;
  for (const auto& file : files) {
    const cv::Mat picture = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
    if (picture.empty() || std::min(picture.cols, picture.rows) < 200) continue;
    CollectPatches(picture, random, first, second);
    ++pictures;
  }
  std::cerr << first.size() << " pairs of patches of " << pictures << " pictures\n";
  if (first.size() < 1000) return 1;

  std::vector<Candidate> candidates;
  candidates.reserve(kCandidates);
  while (candidates.size() < kCandidates) {
    candidates.push_back(Evaluate(first, second, RandomTest(random)));
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.gain > b.gain; });
  const std::vector<BriefTest> tests = Choose(candidates, static_cast<double>(first.size()));
  Print(tests, pictures, first.size());
  return tests.empty() ? 1 : 0;
}

}  // namespace
}  // namespace corbslam

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: learn_brief_pattern FOLDER_OF_PICTURES\n";
    return 2;
  }
  return corbslam::Run(argv[1]);
}
