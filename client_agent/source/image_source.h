// Where an agent's pictures come from: a recorded sequence in one of the public layouts.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_IMAGE_SOURCE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_IMAGE_SOURCE_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/source/source_spec.h"
#include "slam/sensor/sensor.h"

namespace corbslam {

struct SourceFrame {
  size_t number = 0;         // In the whole sequence, from 0.
  int64_t timestamp_ns = 0;  // The sequence's own time.
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
  // The next frame's pictures, stamped with its time; nullopt after the last. Errors name the file.
  virtual absl::StatusOr<std::optional<SensorImages>> Next() = 0;
};

// Opens what `spec` names and starts decoding ahead. Errors name the file, line and field.
absl::StatusOr<std::unique_ptr<ImageSource>> OpenSource(const SourceSpec& spec);
absl::StatusOr<std::unique_ptr<ImageSource>> OpenSource(absl::string_view spec);

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_IMAGE_SOURCE_H_
