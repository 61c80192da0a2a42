// The memory that a driver shares, from which a robot copies pictures.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_PUSH_SHARED_RING_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_PUSH_SHARED_RING_H_

#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "absl/status/statusor.h"
#include "client_agent/live/push/push_message.h"
#include "client_agent/live/push/unix_socket.h"

namespace corbslam::client_agent {

// Reads memory that another process may write at any time: pictures may be torn, never more.
class SharedRing {
 public:
  // Maps a layout that ParseHello gave. INVALID_ARGUMENT where the file is no memory that is sealed
  // against shrinking, which would end this process when it reads, or smaller than said.
  static absl::StatusOr<SharedRing> Map(const UniqueFd& memory, const PushLayout& layout);
  SharedRing(SharedRing&& other) noexcept;
  SharedRing& operator=(SharedRing&& other) noexcept;
  ~SharedRing();

  // Returns a copy: CV_8UC1, or CV_16UC1 of depth and of grey of 16 bits. `slot` is below the
  // layout's.
  cv::Mat CopyFirst(uint32_t slot) const { return Copy(slot, layout_.first); }
  cv::Mat CopySecond(uint32_t slot) const { return Copy(slot, layout_.second); }

 private:
  SharedRing(uint8_t* bytes, const PushLayout& layout) : bytes_(bytes), layout_(layout) {}
  cv::Mat Copy(uint32_t slot, const push_wire::Picture& picture) const;

  uint8_t* bytes_ = nullptr;
  PushLayout layout_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_PUSH_SHARED_RING_H_
