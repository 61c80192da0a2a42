#include "client_agent/push_client/connecting.h"

#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

namespace corbslam::push_client {
namespace {

constexpr uint32_t kMostPixels = 16384;  // Of a side.
constexpr uint32_t kDefaultSlots = 4;
constexpr int64_t kBetweenTries_ns = 50'000'000;

uint64_t RoundUp(uint64_t bytes, uint64_t unit) { return (bytes + unit - 1) / unit * unit; }

// Fills in one picture behind `end`, which moves behind it.
corbslam_push_status LayOut(const char* which, const corbslam_push_picture& wanted,
                            push_wire::Picture& picture, uint64_t& end, ErrorText& error) {
  const uint32_t pixel = push_wire::BytesPerPixel(wanted.format);
  if (pixel == 0) {
    return Fail(error, CORBSLAM_PUSH_INVALID, "%s.format is %u, must be 1 to 4", which,
                wanted.format);
  }
  if (wanted.width_px < 1 || wanted.width_px > kMostPixels || wanted.height_px < 1 ||
      wanted.height_px > kMostPixels) {
    return Fail(error, CORBSLAM_PUSH_INVALID, "%s is of %ux%u pixels, must be 1 to %u each", which,
                wanted.width_px, wanted.height_px, kMostPixels);
  }
  const uint32_t row = wanted.width_px * pixel;
  const uint32_t stride = wanted.stride_bytes != 0 ? wanted.stride_bytes : row;
  if (stride < row || stride > 4 * kMostPixels) {
    return Fail(error, CORBSLAM_PUSH_INVALID, "%s.stride_bytes is %u, a row has %u, at most %u",
                which, stride, row, 4 * kMostPixels);
  }
  picture = {wanted.format, wanted.width_px, wanted.height_px, stride, RoundUp(end, 64)};
  end = picture.offset_bytes + uint64_t{stride} * wanted.height_px;
  return CORBSLAM_PUSH_OK;
}

bool IsNone(const corbslam_push_picture& picture) {
  return picture.format == 0 && picture.width_px == 0 && picture.height_px == 0;
}

corbslam_push_status CheckTexts(const corbslam_push_options& options, ErrorText& error) {
  sockaddr_un address;
  if (options.socket_path == nullptr || options.socket_path[0] == 0 ||
      strlen(options.socket_path) >= sizeof(address.sun_path)) {
    return Fail(error, CORBSLAM_PUSH_INVALID, "socket_path must have 1 to %zu bytes",
                sizeof(address.sun_path) - 1);
  }
  if (options.rig_text != nullptr && strlen(options.rig_text) > push_wire::kMostRigBytes) {
    return Fail(error, CORBSLAM_PUSH_INVALID, "rig_text has %zu bytes, at most %u are taken",
                strlen(options.rig_text), push_wire::kMostRigBytes);
  }
  if (options.name != nullptr && strlen(options.name) >= push_wire::kNameBytes) {
    return Fail(error, CORBSLAM_PUSH_INVALID, "name has %zu bytes, at most %u are taken",
                strlen(options.name), push_wire::kNameBytes - 1);
  }
  return CORBSLAM_PUSH_OK;
}

// Waits a moment, not beyond the deadline.
void Rest(int64_t deadline_ns) {
  int64_t rest_ns = kBetweenTries_ns;
  if (deadline_ns >= 0 && deadline_ns - Now_ns() < rest_ns) rest_ns = deadline_ns - Now_ns();
  if (rest_ns <= 0) return;
  const timespec rest = {0, static_cast<long>(rest_ns)};
  nanosleep(&rest, nullptr);
}

}  // namespace

corbslam_push_status Fail(ErrorText& error, corbslam_push_status status, const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(error.text, sizeof(error.text), format, arguments);
  va_end(arguments);
  return status;
}

int64_t Now_ns() {
  timespec now = {};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

int64_t Deadline_ns(int32_t timeout_ms) {
  return timeout_ms < 0 ? -1 : Now_ns() + int64_t{timeout_ms} * 1'000'000;
}

int MillisecondsLeft(int64_t deadline_ns) {
  if (deadline_ns < 0) return -1;
  const int64_t left_ns = deadline_ns - Now_ns();
  return left_ns <= 0 ? 0 : static_cast<int>((left_ns + 999'999) / 1'000'000);
}

corbslam_push_status MakeHello(const corbslam_push_options& options, push_wire::Hello& hello,
                               ErrorText& error) {
  corbslam_push_status status = CheckTexts(options, error);
  if (status != CORBSLAM_PUSH_OK) return status;
  if (options.slots > push_wire::kMostSlots) {
    return Fail(error, CORBSLAM_PUSH_INVALID, "slots is %u, must be 0 to %u", options.slots,
                push_wire::kMostSlots);
  }
  hello = {};
  uint64_t end = 0;
  status = LayOut("first", options.first, hello.first, end, error);
  if (status != CORBSLAM_PUSH_OK) return status;
  if (!IsNone(options.second)) {
    status = LayOut("second", options.second, hello.second, end, error);
    if (status != CORBSLAM_PUSH_OK) return status;
  }
  hello.magic = push_wire::kMagic;
  hello.version = push_wire::kVersion;
  hello.slots = options.slots != 0 ? options.slots : kDefaultSlots;
  hello.slot_bytes = RoundUp(end, 4096);
  hello.memory_bytes = hello.slots * hello.slot_bytes;
  if (options.rig_text != nullptr) {
    hello.rig_bytes = static_cast<uint32_t>(strlen(options.rig_text));
  }
  if (options.name != nullptr) memcpy(hello.name, options.name, strlen(options.name));
  hello.header = {push_wire::kHello, static_cast<uint32_t>(sizeof(hello)) + hello.rig_bytes};
  return CORBSLAM_PUSH_OK;
}

corbslam_push_status MakeMemory(size_t bytes, SharedMemory& memory, ErrorText& error) {
  memory.file = memfd_create("corbslam_push", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (memory.file < 0 || ftruncate(memory.file, static_cast<off_t>(bytes)) != 0 ||
      fcntl(memory.file, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0) {
    return Fail(error, CORBSLAM_PUSH_SYSTEM, "no shared memory of %zu bytes: %s", bytes,
                strerror(errno));
  }
  void* const mapped = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, memory.file, 0);
  if (mapped == MAP_FAILED) {
    return Fail(error, CORBSLAM_PUSH_SYSTEM, "can't map %zu bytes: %s", bytes, strerror(errno));
  }
  memory.bytes = static_cast<uint8_t*>(mapped);
  return CORBSLAM_PUSH_OK;
}

corbslam_push_status ConnectSocket(const char* path, int64_t deadline_ns, int& socket,
                                   ErrorText& error) {
  // Not one that waits: connect() would wait without end where the robot answers nobody.
  socket = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket < 0) return Fail(error, CORBSLAM_PUSH_SYSTEM, "no socket: %s", strerror(errno));
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  memcpy(address.sun_path, path, strlen(path));
  while (connect(socket, reinterpret_cast<sockaddr*>(&address), sizeof(address)) != 0) {
    const int why = errno;
    if (why == EINTR) continue;
    if (why != ENOENT && why != ECONNREFUSED && why != EAGAIN) {
      return Fail(error, CORBSLAM_PUSH_SYSTEM, "can't connect to %s: %s", path, strerror(why));
    }
    if (MillisecondsLeft(deadline_ns) == 0) {
      return Fail(error, CORBSLAM_PUSH_GONE,
                  "no robot listens at %s (client_agent --source push:%s): %s", path, path,
                  strerror(why));
    }
    Rest(deadline_ns);
  }
  return CORBSLAM_PUSH_OK;
}

corbslam_push_status SendHello(int socket, const push_wire::Hello& hello, const char* rig_text,
                               int memory_file, ErrorText& error) {
  iovec parts[2] = {{const_cast<push_wire::Hello*>(&hello), sizeof(hello)},
                    {const_cast<char*>(rig_text), hello.rig_bytes}};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  msghdr message = {};
  message.msg_iov = parts;
  message.msg_iovlen = 2;
  message.msg_control = control;
  message.msg_controllen = sizeof(control);
  cmsghdr* const rights = CMSG_FIRSTHDR(&message);
  rights->cmsg_level = SOL_SOCKET;
  rights->cmsg_type = SCM_RIGHTS;
  rights->cmsg_len = CMSG_LEN(sizeof(int));
  memcpy(CMSG_DATA(rights), &memory_file, sizeof(int));
  while (sendmsg(socket, &message, MSG_NOSIGNAL) < 0) {
    if (errno == EINTR) continue;
    // What the robot said before it went is read by the caller.
    if (errno == EPIPE || errno == ECONNRESET) return CORBSLAM_PUSH_OK;
    return Fail(error, CORBSLAM_PUSH_SYSTEM, "can't send the hello: %s", strerror(errno));
  }
  return CORBSLAM_PUSH_OK;
}

}  // namespace corbslam::push_client
