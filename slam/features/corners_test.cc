// Compares detection and spreading of corners with plain programs of the same rules.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <random>
#include <tuple>
#include <vector>

#include "slam/features/corner_spread.h"
#include "slam/features/fast_corners.h"
#include "slam/features/pixel_kernels.h"

namespace corbslam {
namespace {

cv::Mat RandomImage(int width, int height, uint64_t seed) {
  std::mt19937_64 random(seed);
  cv::Mat image(height, width, CV_8UC1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto contrast = static_cast<int>(random() % static_cast<uint64_t>(2 + x / 2));
      image.at<uint8_t>(y, x) = static_cast<uint8_t>(100 + contrast);
    }
  }
  return image;
}

int ScoreAt(const cv::Mat& image, int x, int y, int threshold) {
  const uint8_t* rows[7];
  for (int i = 0; i < 7; ++i) rows[i] = image.ptr<uint8_t>(y + i - 3);
  std::vector<uint8_t> scores(static_cast<size_t>(image.cols));
  PortablePixelKernels().fast_scores(rows, x, x + 1, threshold, scores.data());
  return scores[static_cast<size_t>(x)];
}

// Later neighbours in reading order may be equal.
bool IsMaximum(const cv::Mat& image, int x, int y, int threshold) {
  const int score = ScoreAt(image, x, y, threshold);
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const bool is_before = dy < 0 || (dy == 0 && dx < 0);
      const int other = ScoreAt(image, x + dx, y + dy, threshold);
      if ((dy != 0 || dx != 0) && (is_before ? other >= score : other > score)) return false;
    }
  }
  return score > 0;
}

std::vector<Corner> DetectPlainly(const cv::Mat& image, const FastOptions& options) {
  const auto cell_of = [&](int position, int size) {
    const int length = size - 2 * options.margin_px;
    return (position - options.margin_px) * std::max(1, length / options.cell_px) / length;
  };
  std::vector<Corner> all;
  for (int y = options.margin_px; y < image.rows - options.margin_px; ++y) {
    for (int x = options.margin_px; x < image.cols - options.margin_px; ++x) {
      if (!IsMaximum(image, x, y, options.min_threshold)) continue;
      const int score = ScoreAt(image, x, y, options.min_threshold);
      all.push_back(
          {static_cast<int16_t>(x), static_cast<int16_t>(y), static_cast<uint8_t>(score)});
    }
  }
  std::vector<Corner> kept;
  for (const Corner& corner : all) {
    const bool is_beaten = std::ranges::any_of(all, [&](const Corner& other) {
      return other.score > options.threshold &&
             cell_of(other.x_px, image.cols) == cell_of(corner.x_px, image.cols) &&
             cell_of(other.y_px, image.rows) == cell_of(corner.y_px, image.rows);
    });
    if (corner.score > options.threshold || !is_beaten) kept.push_back(corner);
  }
  return kept;
}

TEST(FastDetectorTest, FindsTheCornersOfTheDefinition) {
  FastDetector detector;  // One detector serves all images, whose buffers must not show through.
  for (const auto& [width, height] : {std::pair(131, 77), std::pair(64, 90), std::pair(40, 33)}) {
    const cv::Mat image = RandomImage(width, height, 1);
    const FastOptions options = {.threshold = 25, .min_threshold = 7, .cell_px = 12};
    std::vector<Corner> corners;
    detector.Detect(image, options, corners);
    EXPECT_EQ(corners, DetectPlainly(image, options)) << width;
  }
  std::vector<Corner> corners;
  detector.Detect(RandomImage(131, 77, 1), {.threshold = 25, .cell_px = 12}, corners);
  EXPECT_GT(corners.size(), 20U);
}

struct Box {
  float left, top, right, bottom;
  std::vector<Corner> corners;
  int depth;
};

// Returns the box to split next: the largest, then the fullest, then the first made.
std::vector<Box>::iterator NextToSplit(std::vector<Box>& boxes) {
  auto best = boxes.end();
  for (auto it = boxes.begin(); it != boxes.end(); ++it) {
    if (it->corners.size() < 2) continue;
    if (best == boxes.end() || std::tuple(-it->depth, it->corners.size()) >
                                   std::tuple(-best->depth, best->corners.size())) {
      best = it;
    }
  }
  return best;
}

void AddBox(const Box& from, float left, float top, float right, float bottom,
            std::vector<Box>& boxes) {
  Box box = {left, top, right, bottom, {}, from.depth + 1};
  for (const Corner& corner : from.corners) {
    const bool is_inside =
        corner.x_px >= left && corner.x_px < right && corner.y_px >= top && corner.y_px < bottom;
    if (is_inside) box.corners.push_back(corner);
  }
  if (!box.corners.empty()) boxes.push_back(box);
}

std::vector<Corner> SpreadPlainly(int width, int height, size_t wanted,
                                  const std::vector<Corner>& corners) {
  const auto w = static_cast<float>(width), h = static_cast<float>(height);
  const Box whole = {0, 0, w, h, corners, -1};
  const auto count = static_cast<int>(std::lround(w / h));
  std::vector<Box> boxes;
  for (int i = 0; i < count; ++i) {
    const float side = w / static_cast<float>(count);
    AddBox(whole, static_cast<float>(i) * side, 0, static_cast<float>(i + 1) * side, h, boxes);
  }
  for (auto it = NextToSplit(boxes); it != boxes.end() && boxes.size() < wanted;
       it = NextToSplit(boxes)) {
    const Box box = *it;
    boxes.erase(it);
    const float x = (box.left + box.right) / 2, y = (box.top + box.bottom) / 2;
    AddBox(box, box.left, box.top, x, y, boxes);
    AddBox(box, x, box.top, box.right, y, boxes);
    AddBox(box, box.left, y, x, box.bottom, boxes);
    AddBox(box, x, y, box.right, box.bottom, boxes);
  }
  const auto key = [](const Corner& c) { return std::tuple(-c.score, c.y_px, c.x_px); };
  std::vector<Corner> kept;
  for (const Box& box : boxes) kept.push_back(*std::ranges::min_element(box.corners, {}, key));
  std::ranges::sort(kept, {}, key);
  kept.resize(std::min(kept.size(), wanted));
  std::ranges::sort(kept, {}, [](const Corner& c) { return std::tuple(c.y_px, c.x_px); });
  return kept;
}

std::vector<Corner> RandomCorners(int width, int height, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Corner> corners;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      // Corners are denser on the left; they have few scores, so that many are equal.
      if (random() % static_cast<uint64_t>(8 + x) != 0) continue;
      corners.push_back({static_cast<int16_t>(x), static_cast<int16_t>(y),
                         static_cast<uint8_t>(8 + random() % 6)});
    }
  }
  return corners;
}

TEST(CornerSpreadTest, AgreesWithAPlainQuadtree) {
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    const std::vector<Corner> corners = RandomCorners(203, 77, seed);
    for (const int wanted : {1, 2, 3, 5, 17, 64, 100, 301}) {
      std::vector<Corner> spread = corners;
      SpreadCorners(203, 77, wanted, spread);
      EXPECT_EQ(spread, SpreadPlainly(203, 77, static_cast<size_t>(wanted), corners))
          << seed << " " << wanted;
    }
  }
}

}  // namespace
}  // namespace corbslam
