// The work that fusion gives away: pure functions from a request to a result that names the
// revision it was computed at. The fusion worker itself implements them, and so does a client of a
// remote one.
#ifndef CORBSLAM_SLAM_EXCHANGE_FUSION_WORKER_H_
#define CORBSLAM_SLAM_EXCHANGE_FUSION_WORKER_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/exchange/frame_location.h"
#include "slam/exchange/overlap.h"
#include "slam/map/map.h"

namespace corbslam {

// Every view is a Map: owners' graphs with fusion's poses, positions and landmarks.

struct VerifyOverlapRequest {
  uint64_t base_revision = 0;
  // The query keyframe, what is covisible with it, and their points; in its island's frame (or its
  // local map's). Payloads hold only features with points, or all; both work.
  // Never null; other requests may share it.
  std::shared_ptr<const Map> query_view = std::make_shared<const Map>();
  KeyframeId query;
  // The same around the candidates, in the frame of their island.
  Map candidate_view;
  struct Candidate {
    KeyframeId id;
    int shared_words = 0;
  };
  std::vector<Candidate> candidates;  // Best first.
  bool fix_scale = true;              // True: both sides are metric.
  // Whose request it is; workers take turns between missions. May be empty.
  std::string mission = {};
};

struct VerifyOverlapResult {
  uint64_t base_revision = 0;
  // One overlap for each candidate that was looked at, in the request's order; at most one is
  // accepted.
  std::vector<Overlap> overlaps;
};

struct KeyframePose {
  KeyframeId id;
  Similarity3d camera_from_map;
};
struct PointPosition {
  MapPointId id;
  Eigen::Vector3d position_in_map = Eigen::Vector3d::Zero();
};
struct RejectedObservation {
  MapPointId point;
  KeyframeId keyframe;
};

struct FuseMapsRequest {
  uint64_t base_revision = 0;
  // The island whose frame stays: all its keyframes and their covisibility; of its points at least
  // those that the neighbourhoods of the new overlaps' keyframes see, with all their observations,
  // and those of the overlaps.
  Map target;
  // The island that moves into it, with as much of it; empty when `overlaps` lie inside one island
  // (loops).
  Map source;
  // Accepted overlaps between the two (or inside `target`), earlier-fused ones included: all are
  // edges of the essential graph. The query is not always on the same side.
  std::vector<Overlap> overlaps;
  // Indices of the overlaps that called for this fusing; their duplicates get welded.
  std::vector<size_t> new_overlaps;
  bool fix_scale = true;
  // As VerifyOverlapRequest has it.
  std::string mission = {};
};

struct FuseMapsResult {
  uint64_t base_revision = 0;
  // False: the overlaps would bend the graph beyond what they can explain; nothing else is set.
  bool accepted = false;
  double worst_edge_chi2 = 0;
  Similarity3d target_from_source;
  // Poses in the target's frame: of every keyframe of the source, and of the target's that moved.
  std::vector<KeyframePose> poses;
  // Positions of the views' points: of all of the source, and of the target's that moved.
  std::vector<PointPosition> positions;
  struct Merge {
    MapPointId survivor;
    MapPointId member;
  };
  std::vector<Merge> merges;
  std::vector<RejectedObservation> rejected;
};

struct AdjustBundleRequest {
  uint64_t base_revision = 0;
  Map view;
  // Keyframes that are held fixed (gauge): at least one.
  std::vector<KeyframeId> fixed;
  int max_iterations = 20;
  // What FindRedundantKeyframes is asked for: keyframes that the others can do without. 0 and 0:
  // none.
  double redundant_share = 0;
  size_t target_keyframes = 0;
  int threads = 1;
  // As VerifyOverlapRequest has it.
  std::string mission = {};
};

struct AdjustBundleResult {
  uint64_t base_revision = 0;
  std::vector<KeyframePose> poses;
  std::vector<PointPosition> positions;
  std::vector<RejectedObservation> rejected;
  std::vector<KeyframeId> redundant;
  int keyframes = 0;
  int points = 0;
  int iterations = 0;
  double initial_cost = 0;
  double final_cost = 0;
  double seconds = 0;
};

// Is told a request's progress (0 to 1), from any thread, but never from two at once. It returns
// false to cancel the request.
using ProgressCallback = std::function<bool(double)>;

// Thread-safe: any number of requests may run at once. Calls block. Errors: INVALID_ARGUMENT (names
// the id), CANCELLED, UNAVAILABLE (no worker; try again), DEADLINE_EXCEEDED.
class FusionWorker {
 public:
  virtual ~FusionWorker() = default;

  virtual absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest& request,
                                                            const ProgressCallback& progress) = 0;
  virtual absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest& request,
                                                  const ProgressCallback& progress) = 0;
  virtual absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest& request,
                                                          const ProgressCallback& progress) = 0;
  // Workers that know nothing of pictures return UNIMPLEMENTED.
  virtual absl::StatusOr<LocateFrameResult> LocateFrame(const LocateFrameRequest& /*request*/,
                                                        const ProgressCallback& /*progress*/) {
    return absl::UnimplementedError("this worker looks up no pictures");
  }
  virtual absl::StatusOr<ExtractFeaturesResult> ExtractFeatures(
      const ExtractFeaturesRequest& /*request*/) {
    return absl::UnimplementedError("this worker looks at no pictures");
  }
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EXCHANGE_FUSION_WORKER_H_
