// Plays a sequence whose frames are all known before: recorded in one of the public layouts, or of
// a registered kind (source_kinds.h).
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_RECORDED_SEQUENCE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_RECORDED_SEQUENCE_H_

#include <cstddef>
#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/frame_stream.h"
#include "client_agent/source/source_spec.h"
#include "slam/sensor/sensor.h"

namespace corbslam::client_agent {

// A fixed list of frames, played once in the order of the list. All of them are there from the
// beginning: Next waits while one is decoded, whatever the deadline. Frames that can't be read are
// left out, until there are kMaxUnreadableInARow in a row: the error of the last of those names its
// file.
class RecordedSequence : public FrameStream {
 public:
  // Returns the number of all frames, played already or not.
  virtual size_t size() const = 0;
  // Returns the i-th frame that is played, i < size().
  virtual SourceFrame frame(size_t i) const = 0;

  // Returns the median interval of frames of one drive, so that pauses and playing backwards don't
  // count; nullopt where there are no two frames of one drive.
  std::optional<double> interval_s() const final;
  bool is_live() const final { return false; }
  // Does what Next does, for callers that need the pictures alone; returns nullopt after the last.
  absl::StatusOr<std::optional<SensorImages>> NextImages();
};

constexpr size_t kMaxUnreadableInARow = 10;

// Plays the frames of `reader` that `spec` selects, disturbed as it says; starts decoding ahead.
// Returns INVALID_ARGUMENT where it selects none.
absl::StatusOr<std::unique_ptr<RecordedSequence>> PlayReader(std::unique_ptr<FrameReader> reader,
                                                             const SourceSpec& spec);

// Opens what `spec` names and starts decoding ahead. Errors name the file, line and field.
absl::StatusOr<std::unique_ptr<RecordedSequence>> OpenSource(const SourceSpec& spec);
absl::StatusOr<std::unique_ptr<RecordedSequence>> OpenSource(absl::string_view spec);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_RECORDED_SEQUENCE_H_
