/* Gives a robot of CORB-SLAM pictures from a driver program on the same machine, and follows its
 * poses.
 *
 * The robot runs as `client_agent --source push:SOCKET_PATH`. A driver connects, then for each
 * frame of its cameras takes a free slot of shared memory, writes both pictures into it and commits
 * it with one time stamp. The robot copies the pictures out, which takes about a millisecond, and
 * gives the slot back. docs/push.md has an example and says what is guaranteed.
 *
 * Any thread may call any function at any time, apart from corbslam_push_close, which must be the
 * last. Nothing here prints, raises a signal or ends the program. Functions return CORBSLAM_PUSH_OK
 * or what went wrong, for which corbslam_push_error has a text.
 */
#ifndef CORBSLAM_PUSH_H_
#define CORBSLAM_PUSH_H_

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define CORBSLAM_PUSH_API __attribute__((visibility("default")))
#else
#define CORBSLAM_PUSH_API
#endif

typedef enum corbslam_push_status {
  CORBSLAM_PUSH_OK = 0,
  CORBSLAM_PUSH_TIMEOUT =
      1, /* No slot was free, or no pose came, in time. The connection stands. */
  CORBSLAM_PUSH_INVALID = 2, /* An argument is wrong; nothing was sent. The connection stands. */
  CORBSLAM_PUSH_REFUSED = 3, /* The robot refused a message and ended the connection. */
  CORBSLAM_PUSH_GONE = 4,    /* The robot went away, or was not there: connect again. */
  CORBSLAM_PUSH_SYSTEM = 5   /* The system refused something, for example memory. */
} corbslam_push_status;

typedef enum corbslam_push_format {
  CORBSLAM_PUSH_GREY8 = 1,  /* 1 byte a pixel. */
  CORBSLAM_PUSH_GREY16 = 2, /* 2 bytes, of which the pictures show how many bits are used: 8, 10,
                               12, 14 or 16, from the lowest; the robot tracks the upper 8. */
  CORBSLAM_PUSH_BGR8 = 3,   /* 3 bytes: blue, green, red. */
  CORBSLAM_PUSH_DEPTH16 = 4 /* 2 bytes, in the rig's depth.units_per_m; 0: not measured. */
} corbslam_push_format;

typedef struct corbslam_push_picture {
  uint32_t format; /* corbslam_push_format */
  uint32_t width_px;
  uint32_t height_px;
  uint32_t stride_bytes; /* From row to row in the slot; 0: rows follow each other. */
} corbslam_push_picture;

typedef struct corbslam_push_options {
  const char* socket_path; /* What the robot has behind push:. At most 107 bytes. */
  const char* rig_text;    /* A rig file's text (docs/rig.md); NULL: the robot has --rig. */
  const char* name;        /* This driver's, for the robot's log, at most 63 bytes; NULL: none. */
  corbslam_push_picture first;  /* Left, or the one beside the depth. */
  corbslam_push_picture second; /* Right, or depth. Of RGB-D rigs DEPTH16; of rigs with one camera
                                   (kind: monocular) all 0: a frame has one picture. */
  uint32_t slots;               /* 1 to 64 frames that fit the shared memory; 0: 4. */
  int32_t timeout_ms;           /* To wait for the robot's socket and answer; -1: for ever. */
} corbslam_push_options;

/* Where the pictures of a frame are to be written. */
typedef struct corbslam_push_slot {
  void* first;
  void* second; /* NULL where a frame has one picture. */
  uint32_t index;
} corbslam_push_slot;

typedef enum corbslam_push_state {
  CORBSLAM_PUSH_NOT_INITIALISED = 0, /* There is no local map yet. */
  CORBSLAM_PUSH_TRACKING = 1,
  CORBSLAM_PUSH_LOST = 2
} corbslam_push_state;

/* What became of a frame. One that a newer one replaced before it was tracked has none. */
typedef struct corbslam_push_pose {
  int64_t timestamp_ns; /* The frame's. */
  uint32_t state;       /* corbslam_push_state; the pose is valid while tracking. */
  uint32_t points_matched;
  uint64_t local_map;    /* Poses of one local map have one frame; 0: none. */
  uint64_t dropped;      /* Frames so far that a newer one replaced. */
  double translation[3]; /* local_from_camera, metres (of rigs with one camera in the local map's
                            own unit): x_local = R x_camera + t, with z forwards, */
  double rotation[4];    /* x right, y down, of the (left) camera as it records. x, y, z, w. */
} corbslam_push_pose;

/* What an IMU measured at one time, in its own right-handed axes. */
typedef struct corbslam_push_imu_sample {
  int64_t timestamp_ns;           /* On the clock of the frames, or a little off it (the rig's
                                     imu.time_offset_s). */
  double angular_velocity_rps[3]; /* x, y, z, rad/s */
  double
      specific_force_mps2[3]; /* x, y, z: acceleration less gravity, m/s2. At rest 9.8 upwards. */
} corbslam_push_imu_sample;

/* A connection with a robot. */
typedef struct corbslam_push corbslam_push;

/* Waits for the robot's socket, says hello and waits for the robot's answer. On success *connection
 * is to be closed; else it is NULL and `error` (may be NULL) has a text of at most error_bytes
 * bytes, the zero at its end included. REFUSED: another driver is connected, or the rig or the
 * layout is none that the robot takes; the text names the field. */
CORBSLAM_PUSH_API corbslam_push_status corbslam_push_connect(const corbslam_push_options* options,
                                                             corbslam_push** connection,
                                                             char* error, size_t error_bytes);

/* Takes a free slot, which stays the caller's until it is committed or cancelled. TIMEOUT where
 * none was free within timeout_ms (0: at once, -1: waits for ever): the robot takes no pictures at
 * the moment, and this frame is best dropped. */
CORBSLAM_PUSH_API corbslam_push_status corbslam_push_begin(corbslam_push* connection,
                                                           int32_t timeout_ms,
                                                           corbslam_push_slot* slot);

/* Gives a taken slot to the robot. timestamp_ns is when both pictures were exposed, on a clock that
 * never goes back (CLOCK_MONOTONIC), from 0 to 2^62. INVALID where it is not above the one before,
 * or more than a minute ahead of CLOCK_MONOTONIC: the slot stays the caller's. */
CORBSLAM_PUSH_API corbslam_push_status corbslam_push_commit(corbslam_push* connection,
                                                            uint32_t index, int64_t timestamp_ns);

/* Gives a taken slot back unused. */
CORBSLAM_PUSH_API corbslam_push_status corbslam_push_cancel(corbslam_push* connection,
                                                            uint32_t index);

/* Takes a slot, copies both pictures into it and commits it; where a frame has one picture `second`
 * is not read. Strides are those of the caller's pictures, 0: rows follow each other. */
CORBSLAM_PUSH_API corbslam_push_status corbslam_push_frame(
    corbslam_push* connection, const void* first, size_t first_stride_bytes, const void* second,
    size_t second_stride_bytes, int64_t timestamp_ns, int32_t timeout_ms);

/* Gives the robot what an IMU measured, at most 256 samples in the order of time, each later than
 * those before. Whatever is given before a frame is committed comes with it at the latest: frames
 * that a newer one replaced lose no samples. TIMEOUT where the robot takes nothing at the moment:
 * nothing was sent. INVALID, and nothing was sent: a value is not finite, a time is not above the
 * one before or more than a minute ahead of CLOCK_MONOTONIC; or the robot takes no samples, since
 * its rig has no block imu: (docs/rig.md), or since it is older than this function. */
CORBSLAM_PUSH_API corbslam_push_status corbslam_push_imu(corbslam_push* connection,
                                                         const corbslam_push_imu_sample* samples,
                                                         uint32_t count);

/* Waits for the next pose that was not read yet. The newest 256 are kept. */
CORBSLAM_PUSH_API corbslam_push_status corbslam_push_next_pose(corbslam_push* connection,
                                                               int32_t timeout_ms,
                                                               corbslam_push_pose* pose);

/* Copies the text of the last error of this connection, empty if there was none. */
CORBSLAM_PUSH_API void corbslam_push_error(corbslam_push* connection, char* error,
                                           size_t error_bytes);

/* Ends the connection and frees it. The robot waits for another driver. NULL is nothing. */
CORBSLAM_PUSH_API void corbslam_push_close(corbslam_push* connection);

/* Returns a word for people: "timeout". */
CORBSLAM_PUSH_API const char* corbslam_push_status_name(corbslam_push_status status);

#ifdef __cplusplus
}
#endif

#endif /* CORBSLAM_PUSH_H_ */
