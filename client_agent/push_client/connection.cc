#include "client_agent/push_client/connection.h"

#include <errno.h>
#include <linux/sockios.h>
#include <poll.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <time.h>

namespace corbslam::push_client {
namespace wire = push_wire;

namespace {

constexpr int kLongestPoll_ms = 100;

void KeepPose(corbslam_push& c, const wire::Pose& pose) {
  corbslam_push_pose& kept = c.poses[c.poses_came++ % kPosesKept];
  if (c.poses_came - c.poses_read > kPosesKept) ++c.poses_read;
  kept.timestamp_ns = pose.timestamp_ns;
  kept.state = pose.state;
  kept.points_matched = pose.points_matched;
  kept.local_map = pose.local_map;
  kept.dropped = pose.dropped;
  memcpy(kept.translation, pose.translation, sizeof(kept.translation));
  memcpy(kept.rotation, pose.rotation, sizeof(kept.rotation));
}

union Message {
  wire::Header header;
  wire::Welcome welcome;
  wire::SlotsFree slots_free;
  wire::Pose pose;
  char bytes[sizeof(wire::Refused) + wire::kMostTextBytes];
};

// Takes one message. What a later robot says beside these is passed over.
void Hear(corbslam_push& c, const Message& message, size_t bytes) {
  if (bytes < sizeof(wire::Header) || message.header.bytes != bytes) {
    c.ended = Fail(c.error, CORBSLAM_PUSH_SYSTEM, "what listens there is no robot");
    return;
  }
  const uint32_t kind = message.header.kind;
  if (kind == wire::kWelcome && bytes == sizeof(wire::Welcome)) {
    c.welcome = true;
    c.robot_takes = message.welcome.takes;
  } else if (kind == wire::kSlotsFree && bytes == sizeof(wire::SlotsFree)) {
    c.free_slots |= message.slots_free.slots & AllSlots(c.hello.slots) & ~c.taken_slots;
  } else if (kind == wire::kPose && bytes == sizeof(wire::Pose)) {
    KeepPose(c, message.pose);
  } else if (kind == wire::kRefused) {
    c.ended = Fail(c.error, CORBSLAM_PUSH_REFUSED, "%.*s",
                   static_cast<int>(bytes - sizeof(wire::Refused)),
                   message.bytes + sizeof(wire::Refused));
  }
}

// Reads all that is there.
void ReadWaiting(corbslam_push& c) {
  bool was_reset = false;
  while (c.ended == CORBSLAM_PUSH_OK) {
    Message message;
    const ssize_t bytes = recv(c.socket, &message, sizeof(message), MSG_DONTWAIT);
    if (bytes > 0) {
      Hear(c, message, static_cast<size_t>(bytes));
    } else if (bytes < 0 && errno == EINTR) {
      continue;
    } else if (bytes < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
      return;
    } else if (bytes < 0 && errno == ECONNRESET && !was_reset) {
      was_reset = true;  // The robot ended before it read all; its last words are behind this.
    } else {
      c.ended = Fail(c.error, CORBSLAM_PUSH_GONE, "the robot went away");
    }
  }
}

// Not for ever, since another thread may give a slot back, of which the socket says nothing.
int PollTime_ms(int64_t deadline_ns) {
  const int left = MillisecondsLeft(deadline_ns);
  return left < 0 || left > kLongestPoll_ms ? kLongestPoll_ms : left;
}

// Waits for news as the one that reads, or for the one that does.
void AwaitNews(corbslam_push& c, int64_t deadline_ns) {
  if (c.someone_reads) {
    if (deadline_ns < 0) {
      pthread_cond_wait(&c.changed, &c.mutex);
      return;
    }
    const timespec until = {static_cast<time_t>(deadline_ns / 1'000'000'000),
                            static_cast<long>(deadline_ns % 1'000'000'000)};
    pthread_cond_timedwait(&c.changed, &c.mutex, &until);
    return;
  }
  c.someone_reads = true;
  pthread_mutex_unlock(&c.mutex);
  pollfd waiting = {c.socket, POLLIN, 0};
  poll(&waiting, 1, PollTime_ms(deadline_ns));
  pthread_mutex_lock(&c.mutex);
  c.someone_reads = false;
  ReadWaiting(c);
  pthread_cond_broadcast(&c.changed);
}

}  // namespace

corbslam_push_status Await(corbslam_push& c, int64_t deadline_ns, IsThere is_there) {
  if (!c.someone_reads) ReadWaiting(c);
  while (true) {
    if (is_there(c)) return CORBSLAM_PUSH_OK;
    if (c.ended != CORBSLAM_PUSH_OK) return c.ended;
    if (MillisecondsLeft(deadline_ns) == 0) return CORBSLAM_PUSH_TIMEOUT;
    AwaitNews(c, deadline_ns);
  }
}

corbslam_push_status SendFrame(corbslam_push& c, uint32_t slot, int64_t timestamp_ns) {
  const wire::Frame frame = {{wire::kFrame, sizeof(wire::Frame)}, slot, 0, timestamp_ns};
  // Less than a socket holds: there is at most one message a slot that the robot has not read.
  while (send(c.socket, &frame, sizeof(frame), MSG_NOSIGNAL | MSG_DONTWAIT) < 0) {
    if (errno == EINTR) continue;
    const int why = errno;
    ReadWaiting(c);  // Says why the robot ended it, where it did.
    if (c.ended != CORBSLAM_PUSH_OK) return c.ended;
    return c.ended = Fail(c.error, CORBSLAM_PUSH_GONE, "can't send a frame: %s", strerror(why));
  }
  return CORBSLAM_PUSH_OK;
}

namespace {

// Half of the socket is the frames'.
bool HasRoomForImu(int socket) {
  int queued = 0;
  int most = 0;
  socklen_t bytes = sizeof(most);
  if (ioctl(socket, SIOCOUTQ, &queued) < 0) return true;
  if (getsockopt(socket, SOL_SOCKET, SO_SNDBUF, &most, &bytes) < 0) return true;
  return queued < most / 2;
}

}  // namespace

corbslam_push_status SendImu(corbslam_push& c, const corbslam_push_imu_sample* samples,
                             uint32_t count) {
  static_assert(sizeof(corbslam_push_imu_sample) == sizeof(wire::ImuSample));
  if (!HasRoomForImu(c.socket)) return CORBSLAM_PUSH_TIMEOUT;
  const size_t bytes = count * sizeof(wire::ImuSample);
  const auto all = static_cast<uint32_t>(sizeof(wire::Imu) + bytes);
  wire::Imu head = {{wire::kImu, all}, count, 0};
  iovec parts[2] = {{&head, sizeof(head)}, {const_cast<corbslam_push_imu_sample*>(samples), bytes}};
  msghdr message = {};
  message.msg_iov = parts;
  message.msg_iovlen = 2;
  while (sendmsg(c.socket, &message, MSG_NOSIGNAL | MSG_DONTWAIT) < 0) {
    if (errno == EINTR) continue;
    if (errno == EAGAIN || errno == EWOULDBLOCK) return CORBSLAM_PUSH_TIMEOUT;
    const int why = errno;
    ReadWaiting(c);  // Says why the robot ended it, where it did.
    if (c.ended != CORBSLAM_PUSH_OK) return c.ended;
    return c.ended = Fail(c.error, CORBSLAM_PUSH_GONE, "can't send samples: %s", strerror(why));
  }
  return CORBSLAM_PUSH_OK;
}

}  // namespace corbslam::push_client
