#include "map_store/ingest/picture_validation.h"

#include <cstddef>
#include <cstdint>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace corbslam::map_store {
namespace {

constexpr absl::string_view kBegin("\xff\xd8", 2);
constexpr absl::string_view kEnd("\xff\xd9", 2);
constexpr uint8_t kScan = 0xda;
constexpr double kMaxPictureScale = 64;

uint8_t ByteAt(absl::string_view bytes, size_t at) { return static_cast<uint8_t>(bytes[at]); }

int WordAt(absl::string_view bytes, size_t at) {
  return ByteAt(bytes, at) << 8 | ByteAt(bytes, at + 1);
}

absl::Status NoJpeg(absl::string_view why) {
  return absl::InvalidArgumentError(absl::StrCat("it is no grey JPEG: ", why));
}

// Baseline, extended and progressive frames of Huffman's code: what browsers decode.
bool IsFrame(uint8_t mark) { return mark >= 0xc0 && mark <= 0xc2; }
// Frames that are lossless, hierarchical or arithmetically coded. C4, C8 and CC are tables.
bool IsOtherFrame(uint8_t mark) {
  return mark >= 0xc3 && mark <= 0xcf && mark != 0xc4 && mark != 0xc8 && mark != 0xcc;
}

// `frame` is a frame's segment behind its length: precision, height, width, number of colours.
absl::Status CheckFrame(absl::string_view frame) {
  if (frame.size() < 6) return NoJpeg("its frame's header is too short");
  if (ByteAt(frame, 0) != 8) {
    return NoJpeg(absl::StrCat("it has ", ByteAt(frame, 0), " bits a pixel, not 8"));
  }
  if (ByteAt(frame, 5) != 1) {
    return NoJpeg(absl::StrCat("it has ", ByteAt(frame, 5), " colours, not 1"));
  }
  const int height = WordAt(frame, 1);
  const int width = WordAt(frame, 3);
  if (width >= 1 && width <= kMaxPictureSide_px && height >= 1 && height <= kMaxPictureSide_px) {
    return absl::OkStatus();
  }
  return NoJpeg(absl::StrCat("it has ", width, "x", height, " pixels, must be 1 to ",
                             kMaxPictureSide_px, " each way"));
}

}  // namespace

absl::Status ValidateGreyJpeg(absl::string_view jpeg) {
  if (!absl::StartsWith(jpeg, kBegin)) return NoJpeg("it does not begin as one");
  if (jpeg.size() < 4 || !absl::EndsWith(jpeg, kEnd)) return NoJpeg("it is cut short");
  bool has_frame = false;
  size_t at = kBegin.size();
  // A chain of segments: FF, a mark, the length of what follows, its two bytes included.
  while (at + 4 <= jpeg.size()) {
    if (ByteAt(jpeg, at) != 0xff) return NoJpeg(absl::StrCat("no segment begins at byte ", at));
    const uint8_t mark = ByteAt(jpeg, at + 1);
    const auto length = static_cast<size_t>(WordAt(jpeg, at + 2));
    if (length < 2 || at + 2 + length > jpeg.size()) {
      return NoJpeg(absl::StrCat("the segment at byte ", at, " is cut short"));
    }
    if (mark == kScan) return has_frame ? absl::OkStatus() : NoJpeg("it has no frame's header");
    if (IsOtherFrame(mark)) return NoJpeg("it is of a kind that browsers don't decode");
    if (IsFrame(mark)) {
      if (has_frame) return NoJpeg("it has two frames");
      const absl::Status frame = CheckFrame(jpeg.substr(at + 4, length - 2));
      if (!frame.ok()) return frame;
      has_frame = true;
    }
    at += 2 + length;
  }
  return NoJpeg("it has no scan");
}

absl::Status ValidatePicture(const KeyframePicture& picture) {
  const auto refuse = [&picture](absl::string_view what) {
    return absl::InvalidArgumentError(
        absl::StrCat("picture of keyframe ", ToString(picture.keyframe), ": ", what));
  };
  if (!picture.keyframe.IsValid()) return refuse("there is no such keyframe");
  // Written so that NaN is refused.
  if (!(picture.scale >= 1 && picture.scale <= kMaxPictureScale)) {
    return refuse(
        absl::StrCat("scale is ", picture.scale, ", must be from 1 to ", kMaxPictureScale));
  }
  if (picture.jpeg.size() > kMaxPictureBytes) {
    return refuse(
        absl::StrCat("it has ", picture.jpeg.size(), " bytes; the limit is ", kMaxPictureBytes));
  }
  const absl::Status jpeg = ValidateGreyJpeg(picture.jpeg);
  return jpeg.ok() ? jpeg : refuse(jpeg.message());
}

}  // namespace corbslam::map_store
