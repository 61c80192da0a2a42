#include "client_agent/push_client/corbslam/push.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "client_agent/push_client/connection.h"

using corbslam::push_client::AllSlots;
using corbslam::push_client::Await;
using corbslam::push_client::Bit;
using corbslam::push_client::ConnectSocket;
using corbslam::push_client::Deadline_ns;
using corbslam::push_client::Fail;
using corbslam::push_client::kPosesKept;
using corbslam::push_client::Lock;
using corbslam::push_client::MakeHello;
using corbslam::push_client::MakeMemory;
using corbslam::push_client::Now_ns;
using corbslam::push_client::SendFrame;
using corbslam::push_client::SendHello;
using corbslam::push_client::SendImu;
namespace wire = corbslam::push_wire;

namespace {

constexpr int64_t kMostTime_ns = int64_t{1} << 62;

bool IsTaken(const corbslam_push& c, uint32_t slot) {
  return slot < c.hello.slots && (c.taken_slots & Bit(slot)) != 0;
}

corbslam_push_status NotTaken(corbslam_push& c, uint32_t slot) {
  return Fail(c.error, CORBSLAM_PUSH_INVALID, "slot %u was not taken by corbslam_push_begin", slot);
}

corbslam_push* Make() {
  auto* const made = static_cast<corbslam_push*>(calloc(1, sizeof(corbslam_push)));
  if (made == nullptr) return nullptr;
  made->socket = -1;
  made->memory.file = -1;
  made->newest_ns = -1;
  made->newest_imu_ns = -1;
  pthread_mutex_init(&made->mutex, nullptr);
  pthread_condattr_t attributes;
  pthread_condattr_init(&attributes);
  pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
  pthread_cond_init(&made->changed, &attributes);
  pthread_condattr_destroy(&attributes);
  return made;
}

// Says where a sample is not above the one before, is of another clock, or no measurement.
corbslam_push_status CheckSample(corbslam_push& c, const corbslam_push_imu_sample& sample,
                                 int64_t before_ns) {
  for (int axis = 0; axis < 3; ++axis) {
    // Neither is true of what is no number, nor of infinity.
    const double turning = sample.angular_velocity_rps[axis];
    const double force = sample.specific_force_mps2[axis];
    if (turning - turning == 0 && force - force == 0) continue;
    return Fail(c.error, CORBSLAM_PUSH_INVALID, "a sample's value is no finite number");
  }
  if (sample.timestamp_ns <= before_ns || sample.timestamp_ns > kMostTime_ns) {
    return Fail(c.error, CORBSLAM_PUSH_INVALID,
                "timestamp_ns of a sample is %lld, the one before has %lld: times must grow, up to "
                "2^62",
                static_cast<long long>(sample.timestamp_ns), static_cast<long long>(before_ns));
  }
  const int64_t now_ns = Now_ns();
  if (sample.timestamp_ns <= now_ns || sample.timestamp_ns - now_ns <= wire::kMostAhead_ns) {
    return CORBSLAM_PUSH_OK;
  }
  return Fail(c.error, CORBSLAM_PUSH_INVALID,
              "timestamp_ns of a sample is %lld, which is more than a minute ahead of "
              "CLOCK_MONOTONIC, %lld: is it of another clock?",
              static_cast<long long>(sample.timestamp_ns), static_cast<long long>(now_ns));
}

corbslam_push_status Connect(const corbslam_push_options& options, corbslam_push& c) {
  const int64_t deadline_ns = Deadline_ns(options.timeout_ms);
  corbslam_push_status status = MakeHello(options, c.hello, c.error);
  if (status != CORBSLAM_PUSH_OK) return status;
  c.free_slots = AllSlots(c.hello.slots);
  status = MakeMemory(c.hello.memory_bytes, c.memory, c.error);
  if (status != CORBSLAM_PUSH_OK) return status;
  status = ConnectSocket(options.socket_path, deadline_ns, c.socket, c.error);
  if (status != CORBSLAM_PUSH_OK) return status;
  status = SendHello(c.socket, c.hello, options.rig_text, c.memory.file, c.error);
  if (status != CORBSLAM_PUSH_OK) return status;
  const Lock lock(c);
  status = Await(c, deadline_ns, [](const corbslam_push& self) { return self.welcome; });
  if (status != CORBSLAM_PUSH_TIMEOUT) return status;
  return Fail(c.error, CORBSLAM_PUSH_GONE, "the robot at %s does not answer", options.socket_path);
}

void CopyText(const char* text, char* to, size_t bytes) {
  if (to == nullptr || bytes == 0) return;
  const size_t length = strnlen(text, bytes - 1);
  memcpy(to, text, length);
  to[length] = 0;
}

void CopyRows(const wire::Picture& picture, const void* from, size_t stride, uint8_t* to) {
  const uint32_t pixel = picture.format == CORBSLAM_PUSH_GREY8  ? 1
                         : picture.format == CORBSLAM_PUSH_BGR8 ? 3
                                                                : 2;
  const size_t row = size_t{picture.width_px} * pixel;
  if (stride == 0) stride = row;
  for (uint32_t y = 0; y < picture.height_px; ++y) {
    memcpy(to + size_t{y} * picture.stride_bytes, static_cast<const uint8_t*>(from) + y * stride,
           row);
  }
}

}  // namespace

extern "C" {

corbslam_push_status corbslam_push_connect(const corbslam_push_options* options,
                                           corbslam_push** connection, char* error,
                                           size_t error_bytes) {
  *connection = nullptr;
  corbslam_push* const made = Make();
  if (made == nullptr) {
    CopyText("no memory", error, error_bytes);
    return CORBSLAM_PUSH_SYSTEM;
  }
  const corbslam_push_status status = Connect(*options, *made);
  if (status == CORBSLAM_PUSH_OK) {
    *connection = made;
    return status;
  }
  CopyText(made->error.text, error, error_bytes);
  corbslam_push_close(made);
  return status;
}

corbslam_push_status corbslam_push_begin(corbslam_push* connection, int32_t timeout_ms,
                                         corbslam_push_slot* slot) {
  corbslam_push& c = *connection;
  const int64_t deadline_ns = Deadline_ns(timeout_ms);
  const Lock lock(c);
  const corbslam_push_status status = Await(c, deadline_ns, [](const corbslam_push& self) {
    return self.ended == CORBSLAM_PUSH_OK && self.free_slots != 0;
  });
  if (status == CORBSLAM_PUSH_TIMEOUT) {
    return Fail(c.error, status, "no slot was free within %d ms", timeout_ms);
  }
  if (status != CORBSLAM_PUSH_OK) return status;
  const auto index = static_cast<uint32_t>(__builtin_ctzll(c.free_slots));
  c.free_slots &= ~Bit(index);
  c.taken_slots |= Bit(index);
  uint8_t* const begin = c.memory.bytes + index * c.hello.slot_bytes;
  const bool has_second = c.hello.second.format != 0;
  *slot = {begin + c.hello.first.offset_bytes,
           has_second ? begin + c.hello.second.offset_bytes : nullptr, index};
  return CORBSLAM_PUSH_OK;
}

corbslam_push_status corbslam_push_commit(corbslam_push* connection, uint32_t index,
                                          int64_t timestamp_ns) {
  corbslam_push& c = *connection;
  const Lock lock(c);
  if (c.ended != CORBSLAM_PUSH_OK) return c.ended;
  if (!IsTaken(c, index)) return NotTaken(c, index);
  if (timestamp_ns <= c.newest_ns || timestamp_ns > kMostTime_ns) {
    return Fail(c.error, CORBSLAM_PUSH_INVALID,
                "timestamp_ns is %lld, the frame before has %lld: times must grow, up to 2^62",
                static_cast<long long>(timestamp_ns), static_cast<long long>(c.newest_ns));
  }
  const int64_t now_ns = Now_ns();
  if (timestamp_ns > now_ns && timestamp_ns - now_ns > wire::kMostAhead_ns) {
    return Fail(c.error, CORBSLAM_PUSH_INVALID,
                "timestamp_ns is %lld, which is more than a minute ahead of CLOCK_MONOTONIC, %lld: "
                "is it of another clock?",
                static_cast<long long>(timestamp_ns), static_cast<long long>(now_ns));
  }
  const corbslam_push_status status = SendFrame(c, index, timestamp_ns);
  if (status != CORBSLAM_PUSH_OK) return status;
  c.taken_slots &= ~Bit(index);
  c.newest_ns = timestamp_ns;
  return CORBSLAM_PUSH_OK;
}

corbslam_push_status corbslam_push_cancel(corbslam_push* connection, uint32_t index) {
  corbslam_push& c = *connection;
  const Lock lock(c);
  if (!IsTaken(c, index)) return NotTaken(c, index);
  c.taken_slots &= ~Bit(index);
  c.free_slots |= Bit(index);
  pthread_cond_broadcast(&c.changed);
  return CORBSLAM_PUSH_OK;
}

corbslam_push_status corbslam_push_frame(corbslam_push* connection, const void* first,
                                         size_t first_stride_bytes, const void* second,
                                         size_t second_stride_bytes, int64_t timestamp_ns,
                                         int32_t timeout_ms) {
  corbslam_push_slot slot;
  corbslam_push_status status = corbslam_push_begin(connection, timeout_ms, &slot);
  if (status != CORBSLAM_PUSH_OK) return status;
  const wire::Hello& hello = connection->hello;
  CopyRows(hello.first, first, first_stride_bytes, static_cast<uint8_t*>(slot.first));
  if (slot.second != nullptr) {
    CopyRows(hello.second, second, second_stride_bytes, static_cast<uint8_t*>(slot.second));
  }
  status = corbslam_push_commit(connection, slot.index, timestamp_ns);
  if (status != CORBSLAM_PUSH_OK) corbslam_push_cancel(connection, slot.index);
  return status;
}

corbslam_push_status corbslam_push_imu(corbslam_push* connection,
                                       const corbslam_push_imu_sample* samples, uint32_t count) {
  corbslam_push& c = *connection;
  const Lock lock(c);
  if (c.ended != CORBSLAM_PUSH_OK) return c.ended;
  if ((c.robot_takes & wire::kTakesImu) == 0) {
    return Fail(c.error, CORBSLAM_PUSH_INVALID,
                "the robot takes no samples of an IMU: its rig has no block imu: (docs/rig.md), or "
                "it is older than that");
  }
  if (count < 1 || count > wire::kMostImuSamples) {
    return Fail(c.error, CORBSLAM_PUSH_INVALID, "count is %u, must be 1 to %u", count,
                wire::kMostImuSamples);
  }
  int64_t newest_ns = c.newest_imu_ns;
  for (uint32_t i = 0; i < count; ++i) {
    const corbslam_push_status status = CheckSample(c, samples[i], newest_ns);
    if (status != CORBSLAM_PUSH_OK) return status;
    newest_ns = samples[i].timestamp_ns;
  }
  const corbslam_push_status status = SendImu(c, samples, count);
  if (status == CORBSLAM_PUSH_TIMEOUT) {
    return Fail(c.error, status, "the robot takes nothing at the moment; no sample was sent");
  }
  if (status == CORBSLAM_PUSH_OK) c.newest_imu_ns = newest_ns;
  return status;
}

corbslam_push_status corbslam_push_next_pose(corbslam_push* connection, int32_t timeout_ms,
                                             corbslam_push_pose* pose) {
  corbslam_push& c = *connection;
  const int64_t deadline_ns = Deadline_ns(timeout_ms);
  const Lock lock(c);
  const corbslam_push_status status = Await(
      c, deadline_ns, [](const corbslam_push& self) { return self.poses_read != self.poses_came; });
  if (status == CORBSLAM_PUSH_TIMEOUT) {
    return Fail(c.error, status, "no pose came within %d ms", timeout_ms);
  }
  if (status != CORBSLAM_PUSH_OK) return status;
  *pose = c.poses[c.poses_read++ % kPosesKept];
  return CORBSLAM_PUSH_OK;
}

void corbslam_push_error(corbslam_push* connection, char* error, size_t error_bytes) {
  const Lock lock(*connection);
  CopyText(connection->error.text, error, error_bytes);
}

void corbslam_push_close(corbslam_push* connection) {
  if (connection == nullptr) return;
  if (connection->socket >= 0) close(connection->socket);
  if (connection->memory.bytes != nullptr) {
    munmap(connection->memory.bytes, connection->hello.memory_bytes);
  }
  if (connection->memory.file >= 0) close(connection->memory.file);
  pthread_cond_destroy(&connection->changed);
  pthread_mutex_destroy(&connection->mutex);
  free(connection);
}

const char* corbslam_push_status_name(corbslam_push_status status) {
  switch (status) {
    case CORBSLAM_PUSH_OK:
      return "ok";
    case CORBSLAM_PUSH_TIMEOUT:
      return "timeout";
    case CORBSLAM_PUSH_INVALID:
      return "invalid";
    case CORBSLAM_PUSH_REFUSED:
      return "refused";
    case CORBSLAM_PUSH_GONE:
      return "gone";
    case CORBSLAM_PUSH_SYSTEM:
      return "system";
  }
  return "unknown";
}

}  // extern "C"
