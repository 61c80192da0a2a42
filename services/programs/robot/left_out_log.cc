#include "services/programs/robot/left_out_log.h"

#include <glog/logging.h>

#include "absl/strings/str_cat.h"

namespace corbslam::services {

using client_agent::FrameStream;
using client_agent::LeftOutFrames;

namespace {

constexpr absl::Duration kBetweenLines = absl::Seconds(10);

}  // namespace

uint64_t LeftOutLog::Tell(const FrameStream& stream, absl::Time now) {
  const LeftOutFrames left_out = stream.left_out();
  if (left_out.count == told_) return left_out.count;
  if (!stream.is_live()) {
    LOG(WARNING) << "a frame that can't be read is left out, " << left_out.count
                 << " so far: " << left_out.last;
  } else if (now < next_) {
    return left_out.count;
  } else {
    LOG(WARNING) << left_out.count - told_ << " of the camera's pictures are left out, "
                 << left_out.count << " since it was opened: " << left_out.last;
    next_ = now + kBetweenLines;
  }
  told_ = left_out.count;
  return left_out.count;
}

std::string DescribeLeftOut(const FrameStream& stream, const LeftOutFrames& left_out) {
  if (stream.is_live()) {
    return absl::StrCat(left_out.count,
                        " of the camera's pictures were left out, at last: ", left_out.last);
  }
  return absl::StrCat(left_out.count,
                      " frames could not be read and were left out, the last because of ",
                      left_out.last);
}

}  // namespace corbslam::services
