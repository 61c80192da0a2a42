#include "slam/features/corner_spread.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <tuple>

namespace corbslam {
namespace {

using Iterator = std::vector<Corner>::iterator;

// A part of the image and the range of corners in it.
struct Box {
  float left;
  float top;
  float right;
  float bottom;
  Iterator begin;
  Iterator end;
  int depth;
  int order;  // of creation

  auto size() const { return end - begin; }
};

struct SplitLater {
  bool operator()(const Box& a, const Box& b) const {
    return std::tuple(-a.depth, a.size(), -a.order) < std::tuple(-b.depth, b.size(), -b.order);
  }
};

// The four quarters, partitioning the box's corners in place.
std::array<Box, 4> Split(const Box& box) {
  const float middle_x = (box.left + box.right) / 2;
  const float middle_y = (box.top + box.bottom) / 2;
  const auto is_left = [=](const Corner& corner) { return corner.x_px < middle_x; };
  const auto is_above = [=](const Corner& corner) { return corner.y_px < middle_y; };
  const Iterator below = std::partition(box.begin, box.end, is_above);
  const Iterator above_right = std::partition(box.begin, below, is_left);
  const Iterator below_right = std::partition(below, box.end, is_left);
  const int depth = box.depth + 1;
  return {{{box.left, box.top, middle_x, middle_y, box.begin, above_right, depth, 0},
           {middle_x, box.top, box.right, middle_y, above_right, below, depth, 0},
           {box.left, middle_y, middle_x, box.bottom, below, below_right, depth, 0},
           {middle_x, middle_y, box.right, box.bottom, below_right, box.end, depth, 0}}};
}

Corner StrongestOf(const Box& box) {
  return *std::max_element(box.begin, box.end, [](const Corner& a, const Corner& b) {
    return std::tuple(a.score, -a.y_px, -a.x_px) < std::tuple(b.score, -b.y_px, -b.x_px);
  });
}

// Nearly square boxes side by side, since images are wider than high.
std::vector<Box> FirstBoxes(int width_px, int height_px, std::vector<Corner>& corners) {
  const int count = std::max(1, static_cast<int>(std::lround(double{1} * width_px / height_px)));
  const float width = static_cast<float>(width_px) / static_cast<float>(count);
  std::vector<Box> boxes;
  Iterator begin = corners.begin();
  for (int i = 0; i < count; ++i) {
    const float right = static_cast<float>(i + 1) * width;
    const Iterator end = i + 1 == count
                             ? corners.end()
                             : std::partition(begin, corners.end(), [right](const Corner& corner) {
                                 return corner.x_px < right;
                               });
    boxes.push_back(
        {static_cast<float>(i) * width, 0, right, static_cast<float>(height_px), begin, end, 0, i});
    begin = end;
  }
  return boxes;
}

}  // namespace

void SpreadCorners(int width_px, int height_px, int wanted, std::vector<Corner>& corners) {
  if (wanted <= 0) corners.clear();
  if (corners.size() <= static_cast<size_t>(wanted)) return;
  std::priority_queue<Box, std::vector<Box>, SplitLater> open;
  std::vector<Corner> kept;
  int order = 0;
  const auto add = [&](Box box) {
    if (box.size() == 0) return;
    box.order = order++;
    if (box.size() == 1) {
      kept.push_back(*box.begin);
    } else {
      open.push(box);
    }
  };
  for (const Box& box : FirstBoxes(width_px, height_px, corners)) add(box);
  while (!open.empty() && kept.size() + open.size() < static_cast<size_t>(wanted)) {
    const Box box = open.top();
    open.pop();
    for (const Box& quarter : Split(box)) add(quarter);
  }
  for (; !open.empty(); open.pop()) kept.push_back(StrongestOf(open.top()));

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
