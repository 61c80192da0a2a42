#include "client_agent/source/frame_selection.h"

#include <algorithm>

#include "absl/strings/str_cat.h"

namespace corbslam::client_agent {

FrameRange TakePart(const FrameRange& frames, const SequencePart& part) {
  if (frames.end <= frames.begin) return frames;
  const size_t count = frames.end - frames.begin;
  const size_t k = part.robot - 1;
  const size_t share = k * count / part.robots;
  const size_t share_end = ((k + 1) * count + part.robots - 1) / part.robots;
  FrameRange range = frames;
  if (k > 0) range.begin = frames.begin + share - std::min(share, part.overlap);
  if (k + 1 < part.robots) {
    range.end = frames.begin + std::min(count, share_end + part.overlap);
  }
  return range;
}

FrameRange SelectRange(const FrameSelection& selection, size_t frame_count) {
  const FrameRange all = {selection.first,
                          std::min(frame_count, selection.last.value_or(frame_count) + 1)};
  return selection.part.has_value() ? TakePart(all, *selection.part) : all;
}

std::vector<size_t> SelectFrames(const FrameSelection& selection, size_t frame_count) {
  std::vector<size_t> frames;
  const FrameRange range = SelectRange(selection, frame_count);
  for (size_t frame = range.begin; frame < range.end; ++frame) {
    if (frame % selection.stride == selection.offset % selection.stride) frames.push_back(frame);
  }
  if (selection.reverse) std::reverse(frames.begin(), frames.end());
  return frames;
}

std::vector<std::string> FormatSelection(const FrameSelection& selection) {
  std::vector<std::string> options;
  if (selection.first != 0 || selection.last.has_value()) {
    options.push_back(absl::StrCat("frames=", selection.first, ":",
                                   selection.last ? absl::StrCat(*selection.last) : ""));
  }
  if (selection.stride != 1) options.push_back(absl::StrCat("stride=", selection.stride));
  if (selection.offset != 0) options.push_back(absl::StrCat("offset=", selection.offset));
  if (selection.reverse) options.push_back("reverse=1");
  if (selection.part.has_value()) {
    const SequencePart& part = *selection.part;
    options.push_back(absl::StrCat("robot=", part.robot, "/", part.robots));
    if (part.overlap != SequencePart().overlap) {
      options.push_back(absl::StrCat("overlap=", part.overlap));
    }
  }
  return options;
}

}  // namespace corbslam::client_agent
