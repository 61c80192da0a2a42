// Sets limits of what is taken from the wire. docs/wire.md and the comments of the contract name
// them.
#ifndef CORBSLAM_SERVICES_CONVERT_LIMITS_H_
#define CORBSLAM_SERVICES_CONVERT_LIMITS_H_

#include <cstddef>
#include <cstdint>

#include "slam/util/number_range.h"

namespace corbslam::services {

inline constexpr int kMaxKeypoints = 20000;
inline constexpr int kMaxLocalMapsOfMessage = 10000;
inline constexpr int kMaxLocalisedFrames = 10000;
inline constexpr uint32_t kMaxCameraIndex = 1000;
// These are far beyond what the map store takes from robots (docs/limits.md): a worker or a robot
// must not refuse what the store has stored, in whichever frame it stands.
inline constexpr double kMaxCoordinate = 1e10;
inline constexpr double kMinScale = 1e-6;
inline constexpr double kMaxScale = 1e6;
inline constexpr double kQuaternionTolerance = 0.01;
inline constexpr double kNormalTolerance = 0.02;
inline constexpr int64_t kMaxTimestamp_ns = int64_t{1} << 62;
// Most bytes of all parts of one batch or shared update together.
inline constexpr size_t kMaxUpdateBytes = 64u << 20;
// Most entries of all fields of a batch or shared update together. A byte on the wire can stand for
// 16 in memory.
inline constexpr size_t kMaxUpdateItems = 1'000'000;
// Most cameras that one side of a stream names.
inline constexpr size_t kMaxCamerasOfStream = 10'000;
// A robot may bound its shared updates to so many bytes per second.
inline constexpr uint64_t kMinDownlink_Bps = 1'000;
inline constexpr uint64_t kMaxDownlink_Bps = uint64_t{1} << 40;
// A robot that wants what is near it says how near, within these limits.
inline constexpr NumberRange kShareRadius_m = {1, 1e6};
// What a link may carry, in thousands of bits a second.
inline constexpr NumberRange kLink_kbps = {8, 10'000'000, "no bound"};
// Our own writers begin another part of a batch or shared update after so many bytes.
inline constexpr size_t kPartBytes = 2u << 20;
// A keypoint takes about so many bytes as columns.
inline constexpr size_t kUncodedKeypointBytes = 42;
// Most bytes of a chunk to or from a worker, and the size at which our own writers end one.
inline constexpr size_t kMaxChunkBytes = 1u << 20;
inline constexpr size_t kChunkTargetBytes = 768u << 10;
// Most bytes of all chunks of one request or result together.
inline constexpr size_t kMaxWorkBytes = 1u << 30;
inline constexpr int kMaxCandidates = 100;
// Most bytes of a picture to be located.
inline constexpr size_t kMaxPictureBytes = 3u << 20;
inline constexpr int kMaxIterations = 1000;
inline constexpr int kMaxSolverThreads = 64;

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_LIMITS_H_
