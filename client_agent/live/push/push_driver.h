// A driver program that is connected with a push: source.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_PUSH_PUSH_DRIVER_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_PUSH_PUSH_DRIVER_H_

#include <cstdint>
#include <deque>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "client_agent/live/grey_scaler.h"
#include "client_agent/live/push/push_message.h"
#include "client_agent/live/push/shared_ring.h"
#include "client_agent/live/push/unix_socket.h"

namespace corbslam::client_agent {

// What becomes of what a driver says. Errors are told to the driver, whose connection they end.
class PushHost {
 public:
  virtual ~PushHost() = default;
  virtual absl::Status OnHello(const PushHello& hello) = 0;
  virtual absl::Status OnFrame(int64_t timestamp_ns, cv::Mat first, cv::Mat second) = 0;
  // Called only behind OnHello.
  virtual bool takes_imu() const = 0;
  virtual absl::Status OnImu(const ImuSamples& samples) = 0;
};

// One connection, used by one thread. It never waits.
class PushDriver {
 public:
  PushDriver(UniqueFd socket, PushHost& host);

  // Takes one message, where one is there, and answers it. An error is the connection's end: the
  // driver was told why, or is gone (UNAVAILABLE).
  absl::Status Read();
  // Ends a driver that has been silent for too long before its hello.
  absl::Status CheckHello(absl::Time now);
  // Sends what waits: slots, then poses, the oldest of which are dropped where a driver reads none.
  void Write();
  void AddPose(std::string message);

  int fd() const { return socket_.get(); }
  bool wants_to_write() const { return free_slots_ != 0 || !poses_.empty(); }
  bool is_welcome() const { return ring_.has_value(); }
  // For the log: "'camera' (process 123)".
  const std::string& who() const { return who_; }

 private:
  absl::Status Take(Packet packet);
  absl::Status TakeHello(const Packet& packet);
  absl::Status TakeFrame(const Packet& packet);
  absl::Status TakeImu(const Packet& packet);
  // Tells the driver why it is refused, and returns that.
  absl::Status Refuse(absl::Status why);

  UniqueFd socket_;
  PushHost& host_;
  std::string who_;
  const absl::Time hello_until_;
  PushLayout layout_;
  std::optional<SharedRing> ring_;  // From the hello on.
  GreyScaler grey_scaler_;
  uint64_t free_slots_ = 0;  // Of which the driver does not know yet.
  std::deque<std::string> poses_;
};

// Tells one who comes while another driver is connected, and ends the connection.
void TurnAway(UniqueFd socket, absl::string_view why);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_PUSH_PUSH_DRIVER_H_
