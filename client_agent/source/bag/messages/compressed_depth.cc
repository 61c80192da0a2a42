#include "client_agent/source/bag/messages/compressed_depth.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client_agent/source/bag/files/byte_cursor.h"
#include "client_agent/source/pictures/image_file.h"
#include "slam/sensor/picture_header.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr uint32_t kMostRvlSide_px = 16'384;
constexpr int64_t kMostDepthPixels = int64_t{1} << 27;

struct DepthPack {
  float a = 0;
  float b = 0;
  absl::string_view picture;
};

absl::StatusOr<DepthPack> OpenPack(const RosCompressedImage& image) {
  ByteCursor cursor(image.data);
  cursor.Take<int32_t>();
  DepthPack pack;
  pack.a = cursor.Take<float>();
  pack.b = cursor.Take<float>();
  pack.picture = cursor.rest();
  if (cursor.ok()) return pack;
  return absl::InvalidArgumentError(
      absl::StrCat("data of a compressedDepth has ", image.data.size(), " bytes, 12 come first"));
}

bool IsRvl(const RosCompressedImage& image) { return absl::StrContains(image.format, "rvl"); }

// Takes numbers that are written in groups of three bits, the lowest first, each with a bit in
// front that says whether one more follows; eight groups make a word of 32 bits.
class RvlNumbers {
 public:
  explicit RvlNumbers(absl::string_view bytes) : cursor_(bytes) {}

  bool ok() const { return cursor_.ok(); }
  uint32_t Take() {
    uint32_t number = 0;
    for (unsigned shift = 0; shift < 32 && ok(); shift += 3) {
      const uint32_t group = TakeGroup();
      number |= (group & 7) << shift;
      if ((group & 8) == 0) break;
    }
    return number;
  }

 private:
  uint32_t TakeGroup() {
    if (left_ == 0) {
      word_ = cursor_.Take<uint32_t>();
      left_ = 8;
    }
    --left_;
    return (word_ >> (4 * left_)) & 15;
  }

  ByteCursor cursor_;
  uint32_t word_ = 0;
  unsigned left_ = 0;
};

absl::StatusOr<cv::Size> RvlSize(absl::string_view bytes) {
  ByteCursor cursor(bytes);
  const auto width_px = cursor.Take<uint32_t>();
  const auto height_px = cursor.Take<uint32_t>();
  if (!cursor.ok() || std::min(width_px, height_px) < 1 ||
      std::max(width_px, height_px) > kMostRvlSide_px) {
    return absl::InvalidArgumentError(
        absl::StrCat("an RVL picture of ", width_px, "x", height_px, " pixels"));
  }
  return cv::Size(static_cast<int>(width_px), static_cast<int>(height_px));
}

absl::StatusOr<cv::Mat> UnpackRvl(absl::string_view bytes) {
  ASSIGN_OR_RETURN(const cv::Size size, RvlSize(bytes));
  cv::Mat depth = cv::Mat::zeros(size, CV_16UC1);
  RvlNumbers numbers(bytes.substr(8));
  auto* const pixels = depth.ptr<uint16_t>();
  const size_t count = depth.total();
  uint16_t previous = 0;
  for (size_t at = 0; at < count;) {
    const uint32_t zeros = numbers.Take();
    if (zeros > count - at) return absl::InvalidArgumentError("RVL: a run beyond the picture");
    at += zeros;
    const uint32_t others = numbers.Take();
    if (others > count - at) return absl::InvalidArgumentError("RVL: a run beyond the picture");
    for (uint32_t i = 0; i < others; ++i) {
      const uint32_t folded = numbers.Take();
      previous = static_cast<uint16_t>(previous + ((folded >> 1) ^ (~(folded & 1) + 1)));
      pixels[at++] = previous;
    }
    if (!numbers.ok()) return absl::InvalidArgumentError("RVL: it ends too early");
    if (zeros == 0 && others == 0) return absl::InvalidArgumentError("RVL: an empty run");
  }
  return depth;
}

cv::Mat ToMetres(const cv::Mat& packed, const DepthPack& pack) {
  cv::Mat depth(packed.size(), CV_32FC1);
  for (int y = 0; y < packed.rows; ++y) {
    for (int x = 0; x < packed.cols; ++x) {
      const uint16_t q = packed.at<uint16_t>(y, x);
      const float metres = pack.a / (static_cast<float>(q) - pack.b);
      depth.at<float>(y, x) =
          q == 0 || !(metres > 0) ? std::numeric_limits<float>::quiet_NaN() : metres;
    }
  }
  return depth;
}

}  // namespace

absl::StatusOr<cv::Size> CompressedDepthSize(const RosCompressedImage& image) {
  ASSIGN_OR_RETURN(const DepthPack pack, OpenPack(image));
  ASSIGN_OR_RETURN(const cv::Size size,
                   IsRvl(image) ? RvlSize(pack.picture) : PictureSize(pack.picture));
  if (int64_t{size.width} * size.height <= kMostDepthPixels) return size;
  return absl::InvalidArgumentError(
      absl::StrCat("data is a picture of ", size.width, "x", size.height, " pixels"));
}

absl::StatusOr<cv::Mat> UnpackCompressedDepth(const RosCompressedImage& image) {
  RETURN_IF_ERROR(CompressedDepthSize(image).status());
  ASSIGN_OR_RETURN(const DepthPack pack, OpenPack(image));
  ASSIGN_OR_RETURN(const cv::Mat packed,
                   IsRvl(image)
                       ? UnpackRvl(pack.picture)
                       : DecodeDepthImage(pack.picture, absl::StrCat("format ", image.format)));
  const bool is_float = absl::StartsWith(image.format, "32FC1");
  return is_float ? ToMetres(packed, pack) : packed;
}

}  // namespace corbslam::client_agent
