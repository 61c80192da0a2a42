#include "client_agent/live/gstreamer/device_pipelines.h"

#include <algorithm>
#include <array>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "client_agent/live/live_options.h"

namespace corbslam::client_agent {
namespace {

constexpr std::array<absl::string_view, 4> kColourFilters = {"rggb", "bggr", "grbg", "gbrg"};

bool IsColourFilter(absl::string_view format) {
  return std::find(kColourFilters.begin(), kColourFilters.end(), format) != kColourFilters.end();
}

// Returns what capabilities say of a picture's size and rate.
std::string SizeAndRate(const DeviceMode& mode) {
  std::string caps;
  const std::vector<std::string> sides = absl::StrSplit(mode.size, 'x');
  if (sides.size() == 2) absl::StrAppend(&caps, ",width=", sides[0], ",height=", sides[1]);
  if (!mode.rate.empty()) absl::StrAppend(&caps, ",framerate=", mode.rate, "/1");
  return caps;
}

}  // namespace

absl::Status ValidateSize(absl::string_view size) {
  const std::vector<std::string> sides = absl::StrSplit(size, 'x');
  int width = 0;
  int height = 0;
  if (sides.size() == 2 && absl::SimpleAtoi(sides[0], &width) && width >= 1 &&
      absl::SimpleAtoi(sides[1], &height) && height >= 1) {
    return absl::OkStatus();
  }
  return BadLiveOption("size", size, "WIDTHxHEIGHT, as 1280x480");
}

absl::Status ValidateRate(absl::string_view rate) {
  int whole = 0;
  if (absl::SimpleAtoi(rate, &whole) && whole >= 1 && whole <= 1000) return absl::OkStatus();
  return BadLiveOption("rate", rate, "frames a second, 1 to 1000");
}

absl::Status ValidateAravisFormat(absl::string_view format) {
  if (format == "GRAY8" || format == "GRAY16_LE" || IsColourFilter(format)) {
    return absl::OkStatus();
  }
  return BadLiveOption("format", format, "GRAY8, GRAY16_LE, rggb, bggr, grbg or gbrg");
}

std::string V4l2Pipeline(absl::string_view device, const DeviceMode& mode) {
  const bool is_jpeg = mode.format == "mjpeg";
  std::string caps = is_jpeg ? "image/jpeg" : "video/x-raw";
  if (!mode.format.empty() && !is_jpeg) absl::StrAppend(&caps, ",format=", mode.format);
  return absl::StrCat("v4l2src device=", device, " ! ", caps, SizeAndRate(mode),
                      is_jpeg ? " ! jpegdec" : "");
}

std::string AravisPipeline(absl::string_view name, const DeviceMode& mode, bool on_arrival) {
  const std::string format = mode.format.empty() ? "GRAY8" : mode.format;
  const bool is_filtered = IsColourFilter(format);
  std::string source = "aravissrc";
  if (name != "any") {
    absl::StrAppend(&source, " camera-name=\"",
                    absl::StrReplaceAll(name, {{"\\", "\\\\"}, {"\"", "\\\""}}), "\"");
  }
  if (on_arrival) absl::StrAppend(&source, " do-timestamp=true");
  return absl::StrCat(source, " ! ", is_filtered ? "video/x-bayer" : "video/x-raw",
                      ",format=", format, SizeAndRate(mode), is_filtered ? " ! bayer2rgb" : "");
}

}  // namespace corbslam::client_agent
