// Writes the pipelines of cameras that are named by a device instead of by GStreamer's elements.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_DEVICE_PIPELINES_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_DEVICE_PIPELINES_H_

#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace corbslam::client_agent {

// Which of a device's modes is asked for; what is empty is left to the device.
struct DeviceMode {
  std::string format;
  std::string size;  // "640x480"
  std::string rate;  // Frames a second, a whole number.
};

// INVALID_ARGUMENT for a size that is not WIDTHxHEIGHT, or a rate that is not 1 to 1000.
absl::Status ValidateSize(absl::string_view size);
absl::Status ValidateRate(absl::string_view rate);
// INVALID_ARGUMENT for a format that ::AravisPipeline doesn't know.
absl::Status ValidateAravisFormat(absl::string_view format);

// A camera of Linux: "/dev/video0". Format "mjpeg" is decoded.
std::string V4l2Pipeline(absl::string_view device, const DeviceMode& mode);

// A GenICam camera (GigE Vision, USB3 Vision) by the name that arv-tool-0.8 lists, or the address;
// "any": the first that is found. Formats are GStreamer's: GRAY8 (the default; the camera's Mono8),
// GRAY16_LE (Mono16), or the order of a colour filter's first pixels: rggb, bggr, grbg, gbrg
// (BayerRG8 and so on).
// `on_arrival`: pictures are stamped when they come, by the machine's clock; else by the device's
// own clock, which counts from its first picture.
std::string AravisPipeline(absl::string_view name, const DeviceMode& mode, bool on_arrival);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_GSTREAMER_DEVICE_PIPELINES_H_
