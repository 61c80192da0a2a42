#include "slam/sensor/picture_header.h"

#include <cstdint>
#include <limits>
#include <optional>

#include "absl/status/status.h"
#include "absl/strings/match.h"

namespace corbslam {
namespace {

constexpr absl::string_view kPngMark("\x89PNG\r\n\x1a\n", 8);
constexpr absl::string_view kJpegMark("\xff\xd8", 2);
constexpr absl::string_view kJpegEnd("\xff\xd9", 2);
// Bytes that may stand behind a picture's end: padding of file systems and of cameras.
constexpr size_t kMaxTrailer_bytes = 4096;

bool EndsWithMark(absl::string_view bytes, absl::string_view mark) {
  const size_t last = bytes.rfind(mark);
  return last != absl::string_view::npos && bytes.size() - last <= mark.size() + kMaxTrailer_bytes;
}

uint32_t BigEndian(absl::string_view bytes) {
  uint32_t value = 0;
  for (const char byte : bytes) value = value << 8 | static_cast<uint8_t>(byte);
  return value;
}

std::optional<cv::Size> MakeSize(uint32_t width, uint32_t height) {
  constexpr uint32_t kMost = std::numeric_limits<int32_t>::max();
  if (width == 0 || height == 0 || width > kMost || height > kMost) return std::nullopt;
  return cv::Size(static_cast<int>(width), static_cast<int>(height));
}

// The first chunk of a PNG is its header: length, "IHDR", width, height.
std::optional<cv::Size> PngSize(absl::string_view bytes) {
  if (bytes.size() < 24 || bytes.substr(12, 4) != "IHDR") return std::nullopt;
  return MakeSize(BigEndian(bytes.substr(16, 4)), BigEndian(bytes.substr(20, 4)));
}

// Frames begin with the marks C0 to CF, but for the tables C4, C8 and CC.
bool BeginsFrame(uint8_t mark) {
  return mark >= 0xc0 && mark <= 0xcf && mark != 0xc4 && mark != 0xc8 && mark != 0xcc;
}

// A JPEG is a chain of segments: FF, a mark, the length of what follows; a frame's segment has its
// height and width behind one byte of precision.
std::optional<cv::Size> JpegSize(absl::string_view bytes) {
  size_t at = kJpegMark.size();
  while (at + 9 <= bytes.size()) {
    if (bytes[at] != '\xff') return std::nullopt;
    const auto mark = static_cast<uint8_t>(bytes[at + 1]);
    if (mark == 0xff) {  // Padding.
      ++at;
      continue;
    }
    if (BeginsFrame(mark)) {
      return MakeSize(BigEndian(bytes.substr(at + 7, 2)), BigEndian(bytes.substr(at + 5, 2)));
    }
    at += 2 + BigEndian(bytes.substr(at + 2, 2));
  }
  return std::nullopt;
}

}  // namespace

bool IsCutShort(absl::string_view encoded) {
  if (absl::StartsWith(encoded, kJpegMark)) return !EndsWithMark(encoded, kJpegEnd);
  if (absl::StartsWith(encoded, kPngMark.substr(0, 4))) return !EndsWithMark(encoded, "IEND");
  return false;
}

absl::StatusOr<cv::Size> PictureSize(absl::string_view encoded) {
  std::optional<cv::Size> size;
  if (absl::StartsWith(encoded, kPngMark)) {
    size = PngSize(encoded);
  } else if (absl::StartsWith(encoded, kJpegMark)) {
    size = JpegSize(encoded);
  } else {
    return absl::InvalidArgumentError("the picture is neither a PNG nor a JPEG");
  }
  if (!size.has_value()) {
    return absl::InvalidArgumentError("the picture's header is damaged: it names no size");
  }
  return *size;
}

}  // namespace corbslam
