#include "slam/sensor/patch_refinement.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <type_traits>

namespace corbslam {
namespace {

constexpr double kWeightSigma_px = 2;
// A pixel whose grey value is off by this has a quarter of its weight (Geman and McClure's). Noise
// and resampling are below it, the step at an edge is above.
constexpr float kRobustGrey = 15;
// How far off the rows of a rectified pair are believed to be, pixels of the octave.
constexpr float kRowSigma_px = 0.3F;
// That belief is weighed as if grey values varied by at least this.
constexpr float kLeastGreyVariance = 4;
constexpr float kLeastInformation = 1;
constexpr float kMaxStray_px = 1;
constexpr float kEnough_px = 0.005F;
constexpr int kPlainSteps = 4;
constexpr int kRobustSteps = 6;

// Columns of an array are rows of the picture; each has some pixels more than a patch, so that it
// fills the processor's registers. They have no weight.
constexpr int kRow = (kPatchSide_px + 3) / 4 * 4;
using PatchRow = Eigen::Array<float, kRow, 1>;
using Patch = Eigen::Array<float, kRow, kPatchSide_px>;
// The patch's surroundings in the right picture: what it may move by, and a pixel to interpolate.
constexpr int kMargin_px = static_cast<int>(kMaxStray_px);
constexpr int kAroundRow = kRow + 2 * kMargin_px + 1;
constexpr int kAroundRows = kPatchSide_px + 2 * kMargin_px + 1;
using Around = Eigen::Array<float, kAroundRow, kAroundRows>;

// Pixels beyond the picture are those of its border.
template <typename Window>
Window CopyWindow(const cv::Mat& image, int first_x, int first_y) {
  Window window;
  const bool is_inside = first_x >= 0 && first_x + window.rows() <= image.cols;
  for (Eigen::Index v = 0; v < window.cols(); ++v) {
    const int y = std::clamp(first_y + static_cast<int>(v), 0, image.rows - 1);
    const uint8_t* const row = image.ptr<uint8_t>(y);
    for (Eigen::Index u = 0; u < window.rows(); ++u) {
      const int x = first_x + static_cast<int>(u);
      window(u, v) = row[is_inside ? x : std::clamp(x, 0, image.cols - 1)];
    }
  }
  return window;
}

Patch MakeWeights() {
  Patch weights = Patch::Zero();
  for (int v = 0; v < kPatchSide_px; ++v) {
    for (int u = 0; u < kPatchSide_px; ++u) {
      const double distance2 = std::pow(u - kPatchRadius_px, 2) + std::pow(v - kPatchRadius_px, 2);
      weights(u, v) =
          static_cast<float>(std::exp(-distance2 / (2 * kWeightSigma_px * kWeightSigma_px)));
    }
  }
  return weights;
}

const Patch& Weights() {
  static const Patch weights = MakeWeights();
  return weights;
}

// Where the patch is in its surroundings, and what to add to the right picture's grey values.
struct Shift {
  float x_px = 0;
  float y_px = 0;
  float grey = 0;
};

// The right picture at a shift, and its slopes there.
struct Sample {
  Patch grey;
  Patch slope_x;
  Patch slope_y;
};

void Interpolate(const Around& around, const Shift& shift, Sample& sample) {
  const float x = shift.x_px + kMargin_px;
  const float y = shift.y_px + kMargin_px;
  const auto whole_x = std::min(static_cast<Eigen::Index>(x), Eigen::Index{2 * kMargin_px});
  const auto whole_y = std::min(static_cast<Eigen::Index>(y), Eigen::Index{2 * kMargin_px});
  const float part_x = x - static_cast<float>(whole_x);
  const float part_y = y - static_cast<float>(whole_y);
  const auto slope_of = [&](Eigen::Index row) -> PatchRow {
    return around.block<kRow, 1>(whole_x + 1, row) - around.block<kRow, 1>(whole_x, row);
  };
  PatchRow slope = slope_of(whole_y);
  PatchRow grey = around.block<kRow, 1>(whole_x, whole_y) + part_x * slope;
  for (Eigen::Index v = 0; v < kPatchSide_px; ++v) {
    const PatchRow next_slope = slope_of(whole_y + v + 1);
    const PatchRow next_grey =
        around.block<kRow, 1>(whole_x, whole_y + v + 1) + part_x * next_slope;
    sample.grey.col(v) = grey + part_y * (next_grey - grey);
    sample.slope_x.col(v) = slope + part_y * (next_slope - slope);
    sample.slope_y.col(v) = next_grey - grey;
    slope = next_slope;
    grey = next_grey;
  }
}

// Sums over a patch's pixels, eight at a time: one pass over the patch makes all sums.
class GroupedSum {
 public:
  void Add(const Eigen::Array<float, 8, 1>& group) { sums_ += group; }
  // Adds the four pixels that are left.
  void Add(const Eigen::Array4f& group) { last_ = group; }
  float Total() const { return (sums_.head<4>() + sums_.tail<4>() + last_).sum(); }

 private:
  Eigen::Array<float, 8, 1> sums_ = Eigen::Array<float, 8, 1>::Zero();
  Eigen::Array4f last_ = Eigen::Array4f::Zero();
};

// Calls visit(first pixel, number) for each group of eight pixels, and of the four that are left.
template <typename Visit>
void ForEachGroup(Visit visit) {
  static_assert(Patch::SizeAtCompileTime % 8 == 4);
  constexpr Eigen::Index kGrouped = Patch::SizeAtCompileTime - 4;
  for (Eigen::Index i = 0; i < kGrouped; i += 8) visit(i, std::integral_constant<int, 8>());
  visit(kGrouped, std::integral_constant<int, 4>());
}

// Makes one Gauss-Newton step of columns and grey offset; infinite where the patch cannot tell
// columns apart. It leaves the rows alone, and counts all pixels.
Shift PlainStep(const Patch& patch, const Sample& sample, const Shift& at) {
  const Patch& weights = Weights();
  static const float w = weights.sum();
  Patch weighted_x;
  GroupedSum sum_r, sum_xx, sum_xr;
  ForEachGroup([&](Eigen::Index i, auto size) {
    using Group = Eigen::Array<float, decltype(size)::value, 1>;
    const auto of = [i](const Patch& values) { return Eigen::Map<const Group>(&values(i)); };
    const Group slope_x = of(sample.slope_x);
    const Group residual = of(patch) - of(sample.grey);
    const Group x = of(weights) * slope_x;
    Eigen::Map<Group>(&weighted_x(i)) = x;
    sum_r.Add(Group(of(weights) * residual));
    sum_xx.Add(Group(x * slope_x));
    sum_xr.Add(Group(x * residual));
  });
  // The sums are of deviations from the means, which eliminates the grey offset.
  const float x = weighted_x.sum() / w;
  const float r = sum_r.Total() / w;
  const float xx = sum_xx.Total() - w * x * x;
  if (!(xx > kLeastInformation)) return {.x_px = INFINITY};
  Shift step;
  step.x_px = (sum_xr.Total() - w * x * r) / xx;
  step.grey = r - x * step.x_px - at.grey;
  return step;
}

// Makes the same step of columns, rows and grey offset, reweighted.
Shift RobustStep(const Patch& patch, const Sample& sample, const Shift& at) {
  Patch weights, weighted_x, weighted_y;
  GroupedSum sum_r, sum_rr, sum_xx, sum_xy, sum_yy, sum_xr, sum_yr;
  ForEachGroup([&](Eigen::Index i, auto size) {
    using Group = Eigen::Array<float, decltype(size)::value, 1>;
    const auto of = [i](const Patch& values) { return Eigen::Map<const Group>(&values(i)); };
    const Group slope_x = of(sample.slope_x);
    const Group slope_y = of(sample.slope_y);
    const Group residual = of(patch) - of(sample.grey);
    const Group weight =
        of(Weights()) / (1 + ((residual - at.grey) / kRobustGrey).square()).square();
    const Group x = weight * slope_x;
    const Group y = weight * slope_y;
    Eigen::Map<Group>(&weights(i)) = weight;
    Eigen::Map<Group>(&weighted_x(i)) = x;
    Eigen::Map<Group>(&weighted_y(i)) = y;
    sum_r.Add(Group(weight * residual));
    sum_rr.Add(Group(weight * residual.square()));
    sum_xx.Add(Group(x * slope_x));
    sum_xy.Add(Group(x * slope_y));
    sum_yy.Add(Group(y * slope_y));
    sum_xr.Add(Group(x * residual));
    sum_yr.Add(Group(y * residual));
  });
  const float w = weights.sum();
  const float x = weighted_x.sum() / w;
  const float y = weighted_y.sum() / w;
  const float r = sum_r.Total() / w;
  const float xx = sum_xx.Total() - w * x * x;
  const float xr = sum_xr.Total() - w * x * r;
  const float variance = sum_rr.Total() / w - r * r;
  const float belief = std::max(variance, kLeastGreyVariance) / (kRowSigma_px * kRowSigma_px);
  const float xy = sum_xy.Total() - w * x * y;
  const float yy = sum_yy.Total() - w * y * y + belief;
  const float yr = sum_yr.Total() - w * y * r - belief * at.y_px;
  const float information = xx - xy * xy / yy;
  if (!(information > kLeastInformation)) return {.x_px = INFINITY};
  Shift step;
  step.x_px = (xr - xy * yr / yy) / information;
  step.y_px = (yr - xy * step.x_px) / yy;
  step.grey = r - x * step.x_px - y * step.y_px - at.grey;
  return step;
}

// Takes up to `steps` steps; returns false where the patch strays.
bool Descend(const Patch& patch, const Around& around, int steps, bool robust, Shift& shift) {
  for (int i = 0; i < steps; ++i) {
    Sample sample;
    Interpolate(around, shift, sample);
    const Shift step = robust ? RobustStep(patch, sample, shift) : PlainStep(patch, sample, shift);
    shift = {shift.x_px + step.x_px, shift.y_px + step.y_px, shift.grey + step.grey};
    if (!(std::abs(shift.x_px) <= kMaxStray_px && std::abs(shift.y_px) <= kMaxStray_px)) {
      return false;
    }
    if (std::abs(step.x_px) < kEnough_px) break;
  }
  return true;
}

}  // namespace

std::optional<PatchShift> RefineAlignment(const cv::Mat& left, const cv::Mat& right, int left_x,
                                          int y, int right_x) {
  const auto patch = CopyWindow<Patch>(left, left_x - kPatchRadius_px, y - kPatchRadius_px);
  const auto around = CopyWindow<Around>(right, right_x - kPatchRadius_px - kMargin_px,
                                         y - kPatchRadius_px - kMargin_px);
  Shift shift;
  if (!Descend(patch, around, kPlainSteps, false, shift)) return std::nullopt;
  if (!Descend(patch, around, kRobustSteps, true, shift)) return std::nullopt;
  return PatchShift{shift.x_px, shift.y_px};
}

}  // namespace corbslam
