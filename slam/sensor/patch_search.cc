#include "slam/sensor/patch_search.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace corbslam {
namespace {

constexpr int kSide_px = 8;
constexpr int kPixels = kSide_px * kSide_px;
// With one more pixel at each side, for slopes.
constexpr int kFramed_px = kSide_px + 2;
constexpr int kMostSteps = 8;
constexpr double kEnough_px = 0.02;
constexpr double kMostStray_px = 4;
// The least information of a direction: of a step of four grey values through the whole patch.
constexpr double kLeastInformation = kPixels * 4 * 4;
// Of what the patch is, this share is what it is expected to look like.
constexpr double kLeastCorrelation = 0.8;

using Values = Eigen::Array<float, kPixels, 1>;

// What a patch looks like, without its mean, and what a step does to that.
struct Template {
  Values grey;
  Values slope_x;
  Values slope_y;
  double energy = 0;  // Sum of squares of `grey`.
  Eigen::Matrix2d step_from_slopes;
};

double AtLevel(double level_0, int level) { return (level_0 + 0.5) / (1 << level) - 0.5; }
Eigen::Vector2d AtLevel(const Eigen::Vector2d& level_0, int level) {
  return {AtLevel(level_0.x(), level), AtLevel(level_0.y(), level)};
}

Eigen::Vector2d FromLevel(const Eigen::Vector2d& at, int level) {
  return (at + Eigen::Vector2d::Constant(0.5)) * (1 << level) - Eigen::Vector2d::Constant(0.5);
}

// Returns false where the point, with the pixel after it, is not inside.
bool IsInside(const cv::Mat& picture, const Eigen::Vector2d& at) {
  return at.x() >= 0 && at.y() >= 0 && at.x() < picture.cols - 1 && at.y() < picture.rows - 1;
}

float Interpolate(const cv::Mat& picture, float x, float y) {
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(y);
  const float right = x - static_cast<float>(column);
  const float lower = y - static_cast<float>(row);
  const uint8_t* const above = picture.ptr<uint8_t>(row) + column;
  const uint8_t* const below = above + picture.step[0];
  const float upper_row = above[0] + right * static_cast<float>(above[1] - above[0]);
  const float lower_row = below[0] + right * static_cast<float>(below[1] - below[0]);
  return upper_row + lower * (lower_row - upper_row);
}

void TakeMeanAway(Values& values) { values -= values.mean(); }

double Dot(const Values& a, const Values& b) { return (a * b).sum(); }

// Samples the source around `at`; a step of a pixel of the patch is `step` there.
std::optional<Eigen::Array<float, kFramed_px, kFramed_px>> SampleFramed(
    const cv::Mat& picture, const Eigen::Vector2d& at, const Eigen::Matrix2d& step) {
  constexpr double kHalf = (kFramed_px - 1) / 2.0;
  for (const double u : {-kHalf, kHalf}) {
    for (const double v : {-kHalf, kHalf}) {
      if (!IsInside(picture, at + step * Eigen::Vector2d(u, v))) return std::nullopt;
    }
  }
  Eigen::Array<float, kFramed_px, kFramed_px> framed;
  const Eigen::Vector2f across = step.col(0).cast<float>();
  const Eigen::Vector2f down = step.col(1).cast<float>();
  Eigen::Vector2f row = (at - step * Eigen::Vector2d(kHalf, kHalf)).cast<float>();
  for (int v = 0; v < kFramed_px; ++v, row += down) {
    Eigen::Vector2f pixel = row;
    for (int u = 0; u < kFramed_px; ++u, pixel += across) {
      framed(u, v) = Interpolate(picture, pixel.x(), pixel.y());
    }
  }
  return framed;
}

// Steps are told from the slopes that brightness and contrast do not explain. Returns false where
// these tell too little.
bool InvertSlopes(Template& patch) {
  const double share_x = Dot(patch.slope_x, patch.grey) / patch.energy;
  const double share_y = Dot(patch.slope_y, patch.grey) / patch.energy;
  patch.slope_x -= static_cast<float>(share_x) * patch.grey;
  patch.slope_y -= static_cast<float>(share_y) * patch.grey;
  Eigen::Matrix2d information;
  information(0, 0) = Dot(patch.slope_x, patch.slope_x);
  information(1, 1) = Dot(patch.slope_y, patch.slope_y);
  information(0, 1) = information(1, 0) = Dot(patch.slope_x, patch.slope_y);
  const double half_trace = information.trace() / 2;
  const double least =
      half_trace - std::sqrt(std::max(0.0, half_trace * half_trace - information.determinant()));
  if (!(least > kLeastInformation)) return false;
  patch.step_from_slopes = information.inverse();
  return true;
}

std::optional<Template> MakeTemplate(const HalvedPicture& source, const PatchSearch& search,
                                     int level) {
  // A surface that is much larger in the source is taken from a smaller picture of it.
  const double scale = std::sqrt(std::abs(search.source_from_now.determinant()));
  const int smaller = level + static_cast<int>(std::lround(std::log2(std::max(scale, 1e-3))));
  const int from = std::clamp(smaller, 0, PatchSearch::kLevels - 1);
  const cv::Mat& picture = source.levels[static_cast<size_t>(from)];
  const auto framed = SampleFramed(picture, AtLevel(search.source_px, from),
                                   search.source_from_now * (std::exp2(level) / std::exp2(from)));
  if (!framed.has_value()) return std::nullopt;
  Template patch;
  for (int v = 0; v < kSide_px; ++v) {
    for (int u = 0; u < kSide_px; ++u) {
      const int i = v * kSide_px + u;
      patch.grey(i) = (*framed)(u + 1, v + 1);
      patch.slope_x(i) = ((*framed)(u + 2, v + 1) - (*framed)(u, v + 1)) / 2;
      patch.slope_y(i) = ((*framed)(u + 1, v + 2) - (*framed)(u + 1, v)) / 2;
    }
  }
  TakeMeanAway(patch.grey);
  TakeMeanAway(patch.slope_x);
  TakeMeanAway(patch.slope_y);
  patch.energy = Dot(patch.grey, patch.grey);
  if (!(patch.energy > kLeastInformation) || !InvertSlopes(patch)) return std::nullopt;
  return patch;
}

// Samples the picture around `middle`. Returns false where it ends.
bool Sample(const cv::Mat& picture, const Eigen::Vector2d& middle, Values& values) {
  constexpr double kHalf = (kSide_px - 1) / 2.0;
  const Eigen::Vector2d first = middle - Eigen::Vector2d::Constant(kHalf);
  if (!IsInside(picture, first)) return false;
  if (!IsInside(picture, middle + Eigen::Vector2d::Constant(kHalf))) return false;
  const int column = static_cast<int>(first.x());
  const int row = static_cast<int>(first.y());
  const auto right = static_cast<float>(first.x() - column);
  const auto lower = static_cast<float>(first.y() - row);
  const float w00 = (1 - right) * (1 - lower);
  const float w01 = right * (1 - lower);
  const float w10 = (1 - right) * lower;
  const float w11 = right * lower;
  for (int v = 0; v < kSide_px; ++v) {
    const uint8_t* const above = picture.ptr<uint8_t>(row + v) + column;
    const uint8_t* const below = above + picture.step[0];
    for (int u = 0; u < kSide_px; ++u) {
      values(v * kSide_px + u) =
          w00 * static_cast<float>(above[u]) + w01 * static_cast<float>(above[u + 1]) +
          w10 * static_cast<float>(below[u]) + w11 * static_cast<float>(below[u + 1]);
    }
  }
  return true;
}

// Moves `middle` to where the picture looks like the patch. Returns the correlation there; below 0
// where it strays.
double Descend(const Template& patch, const cv::Mat& picture, Eigen::Vector2d& middle) {
  constexpr double kStrayed = -1;
  const Eigen::Vector2d began = middle;
  Values seen;
  for (int i = 0; i < kMostSteps; ++i) {
    if (!Sample(picture, middle, seen)) return kStrayed;
    TakeMeanAway(seen);
    // How much more contrast the picture has than the patch.
    const double contrast = Dot(seen, patch.grey) / patch.energy;
    if (!(contrast > 0.1)) return kStrayed;
    const Eigen::Vector2d along(Dot(patch.slope_x, seen), Dot(patch.slope_y, seen));
    const Eigen::Vector2d step = -(patch.step_from_slopes * along) / contrast;
    middle += step;
    if (!((middle - began).squaredNorm() < kMostStray_px * kMostStray_px)) return kStrayed;
    if (step.squaredNorm() < kEnough_px * kEnough_px) break;
  }
  if (!Sample(picture, middle, seen)) return kStrayed;
  TakeMeanAway(seen);
  return Dot(seen, patch.grey) / std::sqrt(patch.energy * std::max(1e-6, Dot(seen, seen)));
}

}  // namespace

std::optional<Eigen::Vector2d> FindPatch(const HalvedPicture& source, const HalvedPicture& now,
                                         const PatchSearch& search) {
  Eigen::Vector2d found = search.predicted_px;
  bool is_found = false;
  for (int level = search.first_level; level >= 0; --level) {
    const std::optional<Template> patch = MakeTemplate(source, search, level);
    // What has no structure where it is large may have some where it is small, and the reverse.
    if (!patch.has_value()) continue;
    Eigen::Vector2d middle = AtLevel(found, level);
    const cv::Mat& picture = now.levels[static_cast<size_t>(level)];
    is_found = Descend(*patch, picture, middle) >= kLeastCorrelation;
    if (is_found) found = FromLevel(middle, level);
  }
  if (!is_found) return std::nullopt;
  return found;
}

}  // namespace corbslam
