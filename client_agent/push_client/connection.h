// What stands behind a corbslam_push: the socket, who reads it, and what it said.
#ifndef CORBSLAM_CLIENT_AGENT_PUSH_CLIENT_CONNECTION_H_
#define CORBSLAM_CLIENT_AGENT_PUSH_CLIENT_CONNECTION_H_

#include <pthread.h>
#include <stdint.h>

#include "client_agent/push_client/connecting.h"
#include "client_agent/push_client/corbslam/push.h"
#include "client_agent/push_client/wire.h"

namespace corbslam::push_client {
constexpr uint32_t kPosesKept = 256;
}

// `mutex` protects what is below it.
struct corbslam_push {
  int socket;
  corbslam::push_client::SharedMemory memory;
  corbslam::push_wire::Hello hello;

  pthread_mutex_t mutex;
  pthread_cond_t changed;
  // One thread waits for the socket, and the others for it: nobody misses what another one has
  // read.
  bool someone_reads;
  bool welcome;
  uint32_t robot_takes;  // As Welcome::takes.
  uint64_t free_slots;
  uint64_t taken_slots;  // By the caller. What is neither is the robot's.
  int64_t newest_ns;
  int64_t newest_imu_ns;
  corbslam_push_pose poses[corbslam::push_client::kPosesKept];
  uint64_t poses_came;
  uint64_t poses_read;
  corbslam_push_status ended;  // OK: the connection stands.
  corbslam::push_client::ErrorText error;
};

namespace corbslam::push_client {

class Lock {
 public:
  explicit Lock(corbslam_push& connection) : mutex_(connection.mutex) {
    pthread_mutex_lock(&mutex_);
  }
  ~Lock() { pthread_mutex_unlock(&mutex_); }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

 private:
  pthread_mutex_t& mutex_;
};

inline uint64_t Bit(uint32_t slot) { return uint64_t{1} << slot; }
inline uint64_t AllSlots(uint32_t slots) { return slots == 64 ? ~uint64_t{0} : Bit(slots) - 1; }

// What follows is called with the connection's lock.

using IsThere = bool (*)(const corbslam_push&);
// Waits until is_there(c) holds: OK. TIMEOUT after the deadline, and why the connection ended where
// it did; what came before its end counts.
corbslam_push_status Await(corbslam_push& c, int64_t deadline_ns, IsThere is_there);

// Sends a frame's message. An error ends the connection.
corbslam_push_status SendFrame(corbslam_push& c, uint32_t slot, int64_t timestamp_ns);

// Sends what an IMU measured. TIMEOUT, without a word, where the socket holds so much already that
// frames could lack room.
corbslam_push_status SendImu(corbslam_push& c, const corbslam_push_imu_sample* samples,
                             uint32_t count);

}  // namespace corbslam::push_client

#endif  // CORBSLAM_CLIENT_AGENT_PUSH_CLIENT_CONNECTION_H_
