#include "slam/coding/keypoint_model.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <limits>

namespace corbslam {
namespace {

constexpr int64_t kSteps = 64;
constexpr int kTurnBits = 14;
constexpr uint32_t kTurn = 1u << kTurnBits;

int64_t FloorDivide(int64_t a, int64_t b) { return a / b - (a % b < 0 ? 1 : 0); }

// Differences of 32-bit numbers wrap around, both ways alike.
int32_t Minus(int64_t a, int64_t b) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) - static_cast<uint32_t>(b));
}
int32_t Plus(int64_t a, int64_t b) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) + static_cast<uint32_t>(b));
}

}  // namespace

LevelGrid::LevelGrid(uint32_t side_px, int octave) : side0_px_(side_px) {
  // ScalePyramid::kFactor is 6 / 5.
  int64_t scale = 1;
  int64_t unscale = 1;
  for (int i = 0; i < std::min(octave, ScalePyramid::kLevels - 1); ++i) {
    scale *= 6;
    unscale *= 5;
  }
  side_px_ = std::max<int64_t>(1, (2 * side0_px_ * unscale + scale) / (2 * scale));
}

int64_t LevelGrid::PositionOf(int64_t pixel) const {
  // The position is (pixel + 1/2) * side0 / side - 1/2, rounded.
  const int64_t doubled = (2 * pixel + 1) * side0_px_ * kSteps;
  return FloorDivide(doubled + side_px_, 2 * side_px_) - kSteps / 2;
}

int64_t LevelGrid::PixelAt(int32_t position_px64) const {
  // Returns the pixel within whose width the position lies.
  return FloorDivide((int64_t{position_px64} + kSteps / 2) * side_px_, side0_px_ * kSteps);
}

NearbyKeypoints::NearbyKeypoints(const PictureSize& picture)
    : width_px64_(int64_t{picture.width_px} * kSteps),
      height_px64_(int64_t{picture.height_px} * kSteps),
      cells_(kCells * kCells) {}

int64_t NearbyKeypoints::ColumnOf(int32_t x_px64) const {
  return std::clamp<int64_t>(FloorDivide(int64_t{x_px64} * kCells, width_px64_), 0, kCells - 1);
}

int64_t NearbyKeypoints::RowOf(int32_t y_px64) const {
  return std::clamp<int64_t>(FloorDivide(int64_t{y_px64} * kCells, height_px64_), 0, kCells - 1);
}

void NearbyKeypoints::Add(const CodedKeypoint& keypoint) {
  Cell& cell =
      cells_[static_cast<size_t>(RowOf(keypoint.y_px64) * kCells + ColumnOf(keypoint.x_px64))];
  cell.keypoints[cell.added++ % kMaxKeypoints] = keypoint;
}

const CodedKeypoint* NearbyKeypoints::FindNearest(int32_t x_px64, int32_t y_px64) const {
  const int64_t column = ColumnOf(x_px64);
  const int64_t row = RowOf(y_px64);
  const CodedKeypoint* nearest = nullptr;
  int64_t least = std::numeric_limits<int64_t>::max();
  for (int64_t r = std::max<int64_t>(row - 1, 0); r <= std::min<int64_t>(row + 1, kCells - 1);
       ++r) {
    for (int64_t c = std::max<int64_t>(column - 1, 0);
         c <= std::min<int64_t>(column + 1, kCells - 1); ++c) {
      const Cell& cell = cells_[static_cast<size_t>(r * kCells + c)];
      for (size_t i = 0; i < std::min(cell.added, kMaxKeypoints); ++i) {
        const int64_t distance = std::abs(int64_t{cell.keypoints[i].x_px64} - x_px64) +
                                 std::abs(int64_t{cell.keypoints[i].y_px64} - y_px64);
        if (distance >= least) continue;
        least = distance;
        nearest = &cell.keypoints[i];
      }
    }
  }
  return nearest;
}

KeypointModel::KeypointModel(const PictureSize& picture, bool has_disparities)
    : has_disparities_(has_disparities), all_(picture), with_disparity_(picture) {
  for (size_t i = 0; i < levels_.size(); ++i) {
    levels_[i].columns = LevelGrid(picture.width_px, static_cast<int>(i));
    levels_[i].rows = LevelGrid(picture.height_px, static_cast<int>(i));
  }
}

size_t KeypointModel::NearnessOf(const CodedKeypoint* neighbour, const CodedKeypoint& keypoint) {
  if (neighbour == nullptr) return 0;
  const int64_t dx = int64_t{neighbour->x_px64} - keypoint.x_px64;
  const int64_t dy = int64_t{neighbour->y_px64} - keypoint.y_px64;
  const auto apart_px =
      static_cast<uint64_t>(std::max(std::abs(dx), std::abs(dy))) / static_cast<uint64_t>(kSteps);
  return std::min<size_t>(1 + static_cast<size_t>(std::bit_width(apart_px)), kNearness - 1);
}

template <typename Coder>
void KeypointModel::CodeOctave(Coder& coder, CodedKeypoint& keypoint) {
  if (!same_octave_.Code(coder, keypoint.octave == octave_)) {
    keypoint.octave = static_cast<uint8_t>(octave_model_.Code(coder, 8, keypoint.octave));
    row_ = 0;
    column_ = 0;
  } else {
    keypoint.octave = octave_;
  }
  octave_ = keypoint.octave;
}

template <typename Coder>
void KeypointModel::CodeColumn(Coder& coder, OfLevel& level, bool same_row, int64_t& column) {
  if (same_row) {
    column = Plus(column_, level.column_step.Code(coder, Minus(column, column_)));
    return;
  }
  const int64_t side = level.columns.side_px();
  const auto bits = static_cast<int>(std::bit_width(static_cast<uint64_t>(side)));
  if (level.is_inside.Code(coder, column >= 0 && column < int64_t{1} << bits)) {
    column = level.column.Code(coder, bits, static_cast<uint32_t>(column));
  } else {
    column = level.column_step.Code(coder, static_cast<int32_t>(column));
  }
}

template <typename Coder>
void KeypointModel::CodePosition(Coder& coder, CodedKeypoint& keypoint) {
  OfLevel& level = levels_[std::min<size_t>(keypoint.octave, kLevels - 1)];
  int64_t row = level.rows.PixelAt(keypoint.y_px64);
  int64_t column = level.columns.PixelAt(keypoint.x_px64);
  const int32_t row_step = level.row_step.Code(coder, Minus(row, row_));
  row = Plus(row_, row_step);
  CodeColumn(coder, level, row_step == 0, column);
  const int64_t x = level.columns.PositionOf(column);
  const int64_t y = level.rows.PositionOf(row);
  keypoint.x_px64 = Plus(x, level.beside_column.Code(coder, Minus(keypoint.x_px64, x)));
  keypoint.y_px64 = Plus(y, level.beside_row.Code(coder, Minus(keypoint.y_px64, y)));
  row_ = row;
  column_ = column;
}

template <typename Coder>
void KeypointModel::CodeAngle(Coder& coder, CodedKeypoint& keypoint) {
  const CodedKeypoint* const neighbour = all_.FindNearest(keypoint.x_px64, keypoint.y_px64);
  const uint32_t base = neighbour == nullptr ? 0 : neighbour->angle_turn14;
  const uint32_t turn = turn_[NearnessOf(neighbour, keypoint)].Code(
      coder, kTurnBits, (keypoint.angle_turn14 - base) % kTurn);
  keypoint.angle_turn14 = (base + turn) % kTurn;
}

template <typename Coder>
void KeypointModel::CodeDisparity(Coder& coder, CodedKeypoint& keypoint) {
  if (!has_disparities_) return;
  was_known_ = is_known_[was_known_ ? 1 : 0].Code(coder, keypoint.disparity_px128 != 0);
  if (!was_known_) {
    keypoint.disparity_px128 = 0;
    return;
  }
  const CodedKeypoint* const neighbour =
      with_disparity_.FindNearest(keypoint.x_px64, keypoint.y_px64);
  const uint32_t base = neighbour == nullptr ? 0 : neighbour->disparity_px128;
  const int32_t step = disparity_step_[NearnessOf(neighbour, keypoint)].Code(
      coder, Minus(keypoint.disparity_px128, base));
  keypoint.disparity_px128 = static_cast<uint32_t>(Plus(base, step));
}

template <typename Coder>
void KeypointModel::Code(Coder& coder, CodedKeypoint& keypoint) {
  CodeOctave(coder, keypoint);
  CodePosition(coder, keypoint);
  CodeAngle(coder, keypoint);
  CodeDisparity(coder, keypoint);
  all_.Add(keypoint);
  if (has_disparities_ && keypoint.disparity_px128 != 0) with_disparity_.Add(keypoint);
}

template void KeypointModel::Code(BitWriter& coder, CodedKeypoint& keypoint);
template void KeypointModel::Code(BitReader& coder, CodedKeypoint& keypoint);

}  // namespace corbslam
