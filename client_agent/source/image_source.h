// Where an agent's pictures come from: a recorded sequence in one of the public layouts.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_IMAGE_SOURCE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_IMAGE_SOURCE_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/source_spec.h"
#include "slam/sensor/sensor.h"

namespace corbslam {

struct SourceFrame {
  size_t number = 0;         // In the whole sequence, from 0.
  int64_t timestamp_ns = 0;  // The sequence's own time.
  // FrameReader::drive: between frames of two drives nobody knows how the camera got there.
  int drive = 0;
};

// Frames that could not be read and were left out.
struct LeftOutFrames {
  size_t count = 0;
  std::string last;  // Why the last of them was.
};

// Plays a fixed list of frames once. Not thread-safe, though it may decode ahead on a thread of
// its own. The order of frames is the order of the list; times need not grow (a sequence may be
// played backwards), so nobody may take the differences of times to be positive.
class ImageSource {
 public:
  virtual ~ImageSource() = default;

  virtual const SensorCalibration& calibration() const = 0;
  // Frames in all, played or not.
  virtual size_t size() const = 0;
  // The i-th frame that is played, i < size().
  virtual SourceFrame frame(size_t i) const = 0;
  // The next frame's pictures, stamped with its time; nullopt after the last. Frames that can't be
  // read are left out, until there are kMaxUnreadableInARow: the error of the last of those names
  // its file, and none other follows.
  virtual absl::StatusOr<std::optional<SensorImages>> Next() = 0;
  // Of the frame that Next gave last, as for frame().
  virtual size_t position() const = 0;
  // So far.
  virtual LeftOutFrames left_out() const = 0;
};

constexpr size_t kMaxUnreadableInARow = 10;

// Plays the frames of `reader` that `spec` selects, disturbed as it says; starts decoding ahead.
// INVALID_ARGUMENT where it selects none.
absl::StatusOr<std::unique_ptr<ImageSource>> PlayReader(std::unique_ptr<FrameReader> reader,
                                                        const SourceSpec& spec);

// Opens what `spec` names and starts decoding ahead. Errors name the file, line and field.
absl::StatusOr<std::unique_ptr<ImageSource>> OpenSource(const SourceSpec& spec);
absl::StatusOr<std::unique_ptr<ImageSource>> OpenSource(absl::string_view spec);

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_IMAGE_SOURCE_H_
