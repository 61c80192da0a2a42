// Makes what a connection consists of: the shared memory and the socket. Without the standard
// library of C++, as all of this folder: what links it needs libc alone.
#ifndef CORBSLAM_CLIENT_AGENT_PUSH_CLIENT_CONNECTING_H_
#define CORBSLAM_CLIENT_AGENT_PUSH_CLIENT_CONNECTING_H_

#include <stddef.h>
#include <stdint.h>

#include "client_agent/push_client/corbslam/push.h"
#include "client_agent/push_client/wire.h"

namespace corbslam::push_client {

// What an error's text is written to; longer texts are cut.
struct ErrorText {
  char text[push_wire::kMostTextBytes + 64];
};

// Writes the text as printf does, and returns `status`.
corbslam_push_status Fail(ErrorText& error, corbslam_push_status status, const char* format, ...)
    __attribute__((format(printf, 3, 4)));

// Now and `timeout_ms` later on CLOCK_MONOTONIC, in ns; -1 is never.
int64_t Now_ns();
int64_t Deadline_ns(int32_t timeout_ms);
// Returns what poll() takes: the ms that are left, rounded up, at least 0; -1 for ever.
int MillisecondsLeft(int64_t deadline_ns);

// Lays pictures and slots out. INVALID names the field.
corbslam_push_status MakeHello(const corbslam_push_options& options, push_wire::Hello& hello,
                               ErrorText& error);

// Memory that can't shrink, so that the robot may read it whatever happens here.
struct SharedMemory {
  int file = -1;
  uint8_t* bytes = nullptr;
};
corbslam_push_status MakeMemory(size_t bytes, SharedMemory& memory, ErrorText& error);

// Waits until a robot listens at `path`. GONE where none did in time.
corbslam_push_status ConnectSocket(const char* path, int64_t deadline_ns, int& socket,
                                   ErrorText& error);

// Sends the hello, the rig's text and the memory's file as one message.
corbslam_push_status SendHello(int socket, const push_wire::Hello& hello, const char* rig_text,
                               int memory_file, ErrorText& error);

}  // namespace corbslam::push_client

#endif  // CORBSLAM_CLIENT_AGENT_PUSH_CLIENT_CONNECTING_H_
