// How keypoints are coded: against the pixel grid of their level of the pyramid, where corners are
// found, in the order in which the extractor gives them (by level, row and column), and against a
// neighbour that was coded before. Any numbers pass, others than those of corners in more bytes.
#ifndef CORBSLAM_SLAM_CODING_KEYPOINT_MODEL_H_
#define CORBSLAM_SLAM_CODING_KEYPOINT_MODEL_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "slam/coding/adaptive_models.h"
#include "slam/features/keypoint.h"

namespace corbslam {

// Size of the picture; only the length of the code depends on it.
struct PictureSize {
  uint32_t width_px = 0;
  uint32_t height_px = 0;
};
// Largest width or height that can be coded.
inline constexpr uint32_t kMaxCodedSide_px = 65535;

struct CodedKeypoint {
  int32_t x_px64 = 0;
  int32_t y_px64 = 0;
  uint32_t disparity_px128 = 0;  // 0: unknown; at most 2^31.
  uint32_t angle_turn14 = 0;     // Less than 2^14.
  uint8_t octave = 0;
};

// Knows where the pixels of one side of a level lie at level 0.
class LevelGrid {
 public:
  LevelGrid() = default;
  // `octave` may be any: beyond the pyramid's levels it is taken as the last.
  LevelGrid(uint32_t side_px, int octave);

  // Returns the pixel's position in 64ths of a pixel of level 0. Half a step rounds either way.
  int64_t PositionOf(int64_t pixel) const;
  // Returns the pixel next to that position.
  int64_t PixelAt(int32_t position_px64) const;
  int64_t side_px() const { return side_px_; }

 private:
  int64_t side0_px_ = 1;
  int64_t side_px_ = 1;
};

// Finds keypoints that were coded so far by their place. A crowded cell keeps the newest ones.
class NearbyKeypoints {
 public:
  explicit NearbyKeypoints(const PictureSize& picture);

  void Add(const CodedKeypoint& keypoint);
  // Returns the nearest of those in the same and the surrounding cells; null: there is none.
  const CodedKeypoint* FindNearest(int32_t x_px64, int32_t y_px64) const;

 private:
  static constexpr int kCells = 32;  // Cells along each side.
  static constexpr size_t kMaxKeypoints = 4;
  struct Cell {
    std::array<CodedKeypoint, kMaxKeypoints> keypoints;
    size_t added = 0;
  };

  int64_t ColumnOf(int32_t x_px64) const;
  int64_t RowOf(int32_t y_px64) const;

  int64_t width_px64_;
  int64_t height_px64_;
  std::vector<Cell> cells_;
};

class KeypointModel {
 public:
  KeypointModel(const PictureSize& picture, bool has_disparities);

  // Writes `keypoint`, or reads it.
  template <typename Coder>
  void Code(Coder& coder, CodedKeypoint& keypoint);

 private:
  static constexpr size_t kLevels = ScalePyramid::kLevels;
  // How near a neighbour is: none, or by powers of 2 of the distance.
  static constexpr size_t kNearness = 9;

  struct OfLevel {
    LevelGrid columns;
    LevelGrid rows;
    DifferenceModel row_step;
    DifferenceModel column_step;
    AdaptiveBit is_inside;
    BitsModel<5> column;
    DifferenceModel beside_column;
    DifferenceModel beside_row;
  };

  static size_t NearnessOf(const CodedKeypoint* neighbour, const CodedKeypoint& keypoint);
  template <typename Coder>
  void CodeOctave(Coder& coder, CodedKeypoint& keypoint);
  template <typename Coder>
  void CodePosition(Coder& coder, CodedKeypoint& keypoint);
  template <typename Coder>
  void CodeColumn(Coder& coder, OfLevel& level, bool same_row, int64_t& column);
  template <typename Coder>
  void CodeAngle(Coder& coder, CodedKeypoint& keypoint);
  template <typename Coder>
  void CodeDisparity(Coder& coder, CodedKeypoint& keypoint);

  const bool has_disparities_;
  NearbyKeypoints all_;
  NearbyKeypoints with_disparity_;
  std::array<OfLevel, kLevels> levels_;
  uint8_t octave_ = 0;
  int64_t row_ = 0;
  int64_t column_ = 0;
  AdaptiveBit same_octave_;
  BitsModel<8> octave_model_;
  std::array<BitsModel<6>, kNearness> turn_;
  std::array<AdaptiveBit, 2> is_known_;
  bool was_known_ = false;
  std::array<DifferenceModel, kNearness> disparity_step_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_CODING_KEYPOINT_MODEL_H_
