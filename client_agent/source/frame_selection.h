// Says which frames of a sequence are played.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_FRAME_SELECTION_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_FRAME_SELECTION_H_

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace corbslam::client_agent {

// A robot's part of a sequence that several share, in the order in which it was driven.
struct SequencePart {
  size_t robot = 1;  // Number of the robot, from 1 on.
  size_t robots = 1;
  // Frames by which a part reaches beyond its share, on each side where there is another.
  size_t overlap = 20;
};

// Says which frames of a sequence are played, and in which order.
struct FrameSelection {
  size_t first = 0;            // The option frames=first:last, both included.
  std::optional<size_t> last;  // Nullopt: to the end.
  // Of these frames, those are played whose number in the sequence leaves `offset` when divided by
  // `stride`.
  size_t stride = 1;
  size_t offset = 0;
  // True: played from the last to the first. Timestamps stay the sequence's own, so they fall.
  bool reverse = false;
  // The options robot=2/3 and overlap=20: only this part of the frames between first and last.
  std::optional<SequencePart> part;
};

// The frames [begin, end). TakePart shares them so: part k of n, k from 0 on, is [begin + floor(k t
// / n) - overlap, begin + ceil((k + 1) t / n) + overlap), within [begin, end). For two robots and t
// frames: [0, t/2 + d] and [t/2 - d, t] (CORB-SLAM, section 4). An empty range stays empty.
struct FrameRange {
  size_t begin = 0;
  size_t end = 0;
};
FrameRange TakePart(const FrameRange& frames, const SequencePart& part);

// Returns what lies between first and last of `frame_count` frames, and only the selected part of
// that.
FrameRange SelectRange(const FrameSelection& selection, size_t frame_count);

// Returns the numbers of the selected frames, in the order in which they are played.
std::vector<size_t> SelectFrames(const FrameSelection& selection, size_t frame_count);

// Returns the options that differ from their defaults: "frames=0:9", "stride=2".
std::vector<std::string> FormatSelection(const FrameSelection& selection);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_FRAME_SELECTION_H_
