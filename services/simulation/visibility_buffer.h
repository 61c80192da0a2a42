// Holds which face is seen at each sample of a picture, and how near it is.
#ifndef CORBSLAM_SERVICES_SIMULATION_VISIBILITY_BUFFER_H_
#define CORBSLAM_SERVICES_SIMULATION_VISIBILITY_BUFFER_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "services/simulation/eight.h"

namespace corbslam {

// Where in a pixel a sample is taken, from the pixel's centre; within half a pixel.
struct SampleOffset {
  float right_px = 0;
  float down_px = 0;
};

// Pixels, both ends included.
struct PixelRect {
  int left, right, top, bottom;
};

// Nearness is 1 / depth in 1/m: linear over a face's pixels.
class VisibilityBuffer {
 public:
  static constexpr int32_t kNoFace = -1;
  static constexpr float kLeastNearness = 1.0F / 2000;
  static constexpr float kMostNearness = 20;

  VisibilityBuffer(int width_px, int height_px, std::vector<SampleOffset> samples);

  int width_px() const { return width_px_; }
  int height_px() const { return height_px_; }
  const std::vector<SampleOffset>& samples() const { return samples_; }

  // Return a row's pixels, eight a block. Behind the last column no face is drawn.
  Eight<float>* NearnessRow(size_t sample, int y) { return &nearness_[RowStart(sample, y)]; }
  Eight<int32_t>* FaceRow(size_t sample, int y) { return &faces_[RowStart(sample, y)]; }
  const float* Nearness(size_t sample, int y) const {
    return nearness_[RowStart(sample, y)].lanes.data();
  }
  const int32_t* Faces(size_t sample, int y) const {
    return faces_[RowStart(sample, y)].lanes.data();
  }

  // Must be called for every place that was written.
  void MarkChanged(const PixelRect& rect) {
    for (int row = rect.top / kTileRows; row <= rect.bottom / kTileRows; ++row) {
      for (int block = rect.left / kNumbers; block <= rect.right / kNumbers; ++block) {
        changed_[TileOf(block, row * kTileRows)] = 1;
      }
    }
  }
  // Returns whether something at least as near is drawn already at every sample.
  bool IsHidden(const PixelRect& rect, float nearness);
  // Answers the same from what IsHidden measured last: sometimes false when it is hidden.
  bool IsKnownHidden(const PixelRect& rect, float nearness) const {
    for (int row = rect.top / kTileRows; row <= rect.bottom / kTileRows; ++row) {
      for (int block = rect.left / kNumbers; block <= rect.right / kNumbers; ++block) {
        if (farthest_[TileOf(block, row * kTileRows)] < nearness) return false;
      }
    }
    return true;
  }

 private:
  static constexpr int kTileRows = 8;

  size_t RowStart(size_t sample, int y) const {
    return (sample * static_cast<size_t>(height_px_) + static_cast<size_t>(y)) *
           static_cast<size_t>(blocks_);
  }
  size_t TileOf(int block, int y) const {
    return static_cast<size_t>(y / kTileRows) * static_cast<size_t>(blocks_) +
           static_cast<size_t>(block);
  }
  float MeasureFarthest(int block, int tile_row);

  const int width_px_;
  const int height_px_;
  const int blocks_;
  const std::vector<SampleOffset> samples_;
  std::vector<Eight<float>> nearness_;
  std::vector<Eight<int32_t>> faces_;
  // Tiles of a block's width: the least nearness in each, and whether it may have grown.
  std::vector<float> farthest_;
  std::vector<uint8_t> changed_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_VISIBILITY_BUFFER_H_
