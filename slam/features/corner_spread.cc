#include "slam/features/corner_spread.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

namespace corbslam {
namespace {

// A part of the image and where its corners are among all of them.
struct Box {
  float left;
  float top;
  float right;
  float bottom;
  size_t begin;
  size_t end;

  size_t size() const { return end - begin; }
};

// Splits boxes, and keeps the corners of each side by side.
class Splitter {
 public:
  explicit Splitter(std::vector<Corner>& corners) : corners_(corners) {}

  // Splits a box into its four quarters; without branches, which the corners' places would
  // mispredict at every turn.
  std::array<Box, 4> Split(const Box& box) {
    const float middle_x = (box.left + box.right) / 2;
    const float middle_y = (box.top + box.bottom) / 2;
    const int first_right = static_cast<int>(std::ceil(middle_x));
    const int first_below = static_cast<int>(std::ceil(middle_y));
    const auto quarter_of = [=](const Corner& corner) {
      return static_cast<size_t>(2 * (corner.y_px >= first_below) + (corner.x_px >= first_right));
    };
    const auto from = corners_.begin() + static_cast<std::ptrdiff_t>(box.begin);
    unsorted_.assign(from, from + static_cast<std::ptrdiff_t>(box.size()));
    std::array<size_t, 4> counts = {};
    for (const Corner& corner : unsorted_) ++counts[quarter_of(corner)];
    std::array<size_t, 4> next = {box.begin};
    for (size_t i = 1; i < 4; ++i) next[i] = next[i - 1] + counts[i - 1];
    const std::array<size_t, 4> begin = next;
    for (const Corner& corner : unsorted_) corners_[next[quarter_of(corner)]++] = corner;
    return {{{box.left, box.top, middle_x, middle_y, begin[0], next[0]},
             {middle_x, box.top, box.right, middle_y, begin[1], next[1]},
             {box.left, middle_y, middle_x, box.bottom, begin[2], next[2]},
             {middle_x, middle_y, box.right, box.bottom, begin[3], next[3]}}};
  }

 private:
  std::vector<Corner>& corners_;
  std::vector<Corner> unsorted_;
};

Corner StrongestOf(const Box& box, const std::vector<Corner>& corners) {
  const auto begin = corners.begin();
  return *std::max_element(
      begin + static_cast<std::ptrdiff_t>(box.begin), begin + static_cast<std::ptrdiff_t>(box.end),
      [](const Corner& a, const Corner& b) {
        return std::tuple(a.score, -a.y_px, -a.x_px) < std::tuple(b.score, -b.y_px, -b.x_px);
      });
}

// Returns nearly square boxes side by side, since images are wider than high.
std::vector<Box> FirstBoxes(int width_px, int height_px, std::vector<Corner>& corners) {
  const int count = std::max(1, static_cast<int>(std::lround(double{1} * width_px / height_px)));
  const float width = static_cast<float>(width_px) / static_cast<float>(count);
  std::vector<Box> boxes;
  auto begin = corners.begin();
  for (int i = 0; i < count; ++i) {
    const float right = static_cast<float>(i + 1) * width;
    const auto end = i + 1 == count
                         ? corners.end()
                         : std::partition(begin, corners.end(), [right](const Corner& corner) {
                             return corner.x_px < right;
                           });
    boxes.push_back({static_cast<float>(i) * width, 0, right, static_cast<float>(height_px),
                     static_cast<size_t>(begin - corners.begin()),
                     static_cast<size_t>(end - corners.begin())});
    begin = end;
  }
  return boxes;
}

// Keeps one corner of each of so many boxes, or of up to three more.
std::vector<Corner> KeepOneOfEachBox(int width_px, int height_px, size_t wanted,
                                     std::vector<Corner>& corners) {
  Splitter splitter(corners);
  std::vector<Corner> kept;
  std::vector<Box> deeper;
  const auto add = [&](const Box& box) {
    if (box.size() == 1) kept.push_back(corners[box.begin]);
    if (box.size() > 1) deeper.push_back(box);
  };
  for (const Box& box : FirstBoxes(width_px, height_px, corners)) add(box);
  std::vector<Box> level;
  size_t split = 0;  // Boxes of the level that were split so far.
  const auto is_enough = [&] {
    return kept.size() + (level.size() - split) + deeper.size() >= wanted;
  };
  while (!deeper.empty() && !is_enough()) {
    level = std::exchange(deeper, {});
    split = 0;
    // The fullest boxes are split first.
    std::stable_sort(level.begin(), level.end(),
                     [](const Box& a, const Box& b) { return a.size() > b.size(); });
    for (; split < level.size() && !is_enough(); ++split) {
      for (const Box& quarter : splitter.Split(level[split])) add(quarter);
    }
  }
  deeper.insert(deeper.end(), level.begin() + static_cast<std::ptrdiff_t>(split), level.end());
  for (const Box& box : deeper) kept.push_back(StrongestOf(box, corners));
  return kept;
}

}  // namespace

void SpreadCorners(int width_px, int height_px, int wanted, std::vector<Corner>& corners) {
  if (wanted <= 0) corners.clear();
  if (corners.size() <= static_cast<size_t>(wanted)) return;
  std::vector<Corner> kept =
      KeepOneOfEachBox(width_px, height_px, static_cast<size_t>(wanted), corners);
  // The last split may have made up to three boxes too many: the weakest corners go.
  const auto stronger = [](const Corner& a, const Corner& b) {
    return std::tuple(-a.score, a.y_px, a.x_px) < std::tuple(-b.score, b.y_px, b.x_px);
  };
  if (kept.size() > static_cast<size_t>(wanted)) {
    std::nth_element(kept.begin(), kept.begin() + wanted, kept.end(), stronger);
    kept.resize(static_cast<size_t>(wanted));
  }
  std::sort(kept.begin(), kept.end(), [](const Corner& a, const Corner& b) {
    return std::tuple(a.y_px, a.x_px) < std::tuple(b.y_px, b.x_px);
  });
  corners = std::move(kept);
}

}  // namespace corbslam
