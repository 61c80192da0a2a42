// Limits of what is taken from the wire. docs/wire.md and the comments of the contract name them.
#ifndef CORBSLAM_SERVICES_CONVERT_LIMITS_H_
#define CORBSLAM_SERVICES_CONVERT_LIMITS_H_

#include <cstddef>
#include <cstdint>

namespace corbslam {

inline constexpr int kMaxKeypoints = 20000;
inline constexpr int kMaxLocalMapsOfMessage = 10000;
inline constexpr uint32_t kMaxCameraIndex = 1000;
// Far beyond what the map store takes from robots (docs/limits.md): what it has stored must not be
// refused by a worker or a robot that it is sent to, in whichever frame it stands.
inline constexpr double kMaxCoordinate = 1e10;
inline constexpr double kMinScale = 1e-6;
inline constexpr double kMaxScale = 1e6;
inline constexpr double kQuaternionTolerance = 0.01;
inline constexpr double kNormalTolerance = 0.02;
inline constexpr int64_t kMaxTimestamp_ns = int64_t{1} << 62;
// All parts of one batch or shared update together.
inline constexpr size_t kMaxUpdateBytes = 64u << 20;
// Entries of all its fields together. A byte on the wire can stand for 16 in memory.
inline constexpr size_t kMaxUpdateItems = 1'000'000;
// That one side of a stream names.
inline constexpr size_t kMaxCamerasOfStream = 10'000;
// What a robot may bound its shared updates to.
inline constexpr uint64_t kMinDownlink_Bps = 1'000;
inline constexpr uint64_t kMaxDownlink_Bps = uint64_t{1} << 40;
// Where our own writers begin another part of a batch or shared update.
inline constexpr size_t kPartBytes = 2u << 20;
// About what a keypoint takes as columns.
inline constexpr size_t kUncodedKeypointBytes = 42;
// A chunk to or from a worker at most, and where our own writers end one.
inline constexpr size_t kMaxChunkBytes = 1u << 20;
inline constexpr size_t kChunkTargetBytes = 768u << 10;
// All chunks of one request or result together.
inline constexpr size_t kMaxWorkBytes = 1u << 30;
inline constexpr int kMaxCandidates = 100;
inline constexpr int kMaxIterations = 1000;
inline constexpr int kMaxSolverThreads = 64;

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_CONVERT_LIMITS_H_
