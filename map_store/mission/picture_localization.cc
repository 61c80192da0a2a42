#include "map_store/mission/picture_localization.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/synchronization/mutex.h"
#include "map_store/locating/place_search.h"
#include "map_store/mission/pausing_read.h"
#include "slam/util/status_macros.h"
#include "slam/verification/frame_location.h"

namespace corbslam::map_store {
namespace {

using Candidates = std::vector<LocateFrameRequest::Candidate>;

// Each request has so many: mostly the first one is right, and each is half a megabyte to send.
constexpr size_t kCandidatesOfRequest = 2;
// How often the map is read anew because it changed meanwhile.
constexpr int kMaxReads = 5;

absl::Status Cancelled() { return absl::CancelledError("the caller went away"); }

absl::StatusOr<Keyframe> MakeFrame(FusionWorker& worker, const Vocabulary& vocabulary,
                                   const LocalizeQuery& query) {
  Keyframe frame;
  if (const auto* given = std::get_if<Keyframe>(&query.picture)) {
    frame = *given;
  } else {
    ASSIGN_OR_RETURN(ExtractFeaturesResult found,
                     worker.ExtractFeatures(std::get<ExtractFeaturesRequest>(query.picture)));
    frame.payload = MakeKeyframePayload({}, 0, 0, std::make_shared<const Camera>(found.camera),
                                        std::move(found.features));
    frame.points.resize(frame.keypoints().size());
  }
  frame.words = std::make_shared<const Words>(vocabulary.Transform(frame.descriptors()));
  return frame;
}

// Returns those that lie in the first one's island; local maps may have been deleted.
Candidates InOneIsland(const MissionState& state, const Candidates& candidates) {
  Candidates together;
  for (const LocateFrameRequest::Candidate& candidate : candidates) {
    if (state.FindLocalMap(candidate.id.local_map) == nullptr) continue;
    if (!together.empty() && state.FindIslandOf(candidate.id.local_map) !=
                                 state.FindIslandOf(together.front().id.local_map)) {
      continue;
    }
    together.push_back(candidate);
  }
  return together;
}

class Search {
 public:
  Search(const MissionStrand& strand, FusionWorker& worker, const LocalizeQuery& query,
         const std::function<bool()>& goes_on)
      : strand_(strand), worker_(worker), query_(query), goes_on_(goes_on) {}

  absl::StatusOr<LocalizeAnswer> Run() {
    ASSIGN_OR_RETURN(frame_, MakeFrame(worker_, *strand_.environment().vocabulary, query_));
    if (frame_.keypoints().size() < FrameLocationOptions().min_features) {
      answer_.revision = strand_.Revision();
      answer_.stage = LocateStage::kFewFeatures;
      return answer_;
    }
    ASSIGN_OR_RETURN(const std::vector<PlacesOfIsland> islands, Places());
    for (const PlacesOfIsland& places : islands) {
      for (size_t i = 0; i < places.candidates.size(); i += kCandidatesOfRequest) {
        const auto begin = places.candidates.begin() + static_cast<ptrdiff_t>(i);
        const size_t count = std::min(kCandidatesOfRequest, places.candidates.size() - i);
        RETURN_IF_ERROR(Try({begin, begin + static_cast<ptrdiff_t>(count)}));
        if (answer_.stage == LocateStage::kLocated || answer_.fitting_camera.has_value()) {
          return answer_;
        }
      }
    }
    return answer_;
  }

 private:
  absl::StatusOr<std::vector<PlacesOfIsland>> Places() {
    return ReadCalmly<std::vector<PlacesOfIsland>>(
        [this](const MissionState& state, LongRead& read) {
          answer_.revision = state.global.revision;
          answer_.stage = LocateStage::kNoCandidates;
          return FindPlaces(state, frame_.words->bag,
                            {.prior = query_.prior, .all_islands = query_.all_islands},
                            strand_.options(), read);
        });
  }

  // Islands may have merged or split since the candidates were found: whose frame it is, is asked
  // of the state that the poses are of.
  absl::Status Try(const Candidates& candidates) {
    IslandId island;
    bool in_reference = false;
    ASSIGN_OR_RETURN(LocateFrameRequest request,
                     ReadCalmly<LocateFrameRequest>([&](const MissionState& state, LongRead& read) {
                       const Candidates together = InOneIsland(state, candidates);
                       if (!together.empty()) {
                         island = state.FindIslandOf(together.front().id.local_map)->id;
                         in_reference = state.ReferenceIsland() == island;
                       }
                       return BuildLocateRequest(state, together, read);
                     }));
    if (request.candidates.empty() || !(in_reference || query_.LooksEverywhere())) {
      return absl::OkStatus();
    }
    request.frame = frame_;
    request.mission = strand_.name();
    ASSIGN_OR_RETURN(LocateFrameResult result,
                     worker_.LocateFrame(request, [this](double) { return GoesOn(); }));
    if (result.stage == LocateStage::kLocated && IsOutsidePrior(result.camera_from_map)) {
      result.stage = LocateStage::kOutsidePrior;
    }
    if (result.fitting_camera.has_value() || GotFarther(result, answer_)) {
      Take(island, in_reference, std::move(result));
    }
    return absl::OkStatus();
  }

  // Reads the state in pieces, anew where another revision was committed meanwhile.
  template <typename Result>
  absl::StatusOr<Result> ReadCalmly(
      absl::FunctionRef<absl::StatusOr<Result>(const MissionState&, LongRead&)> look) {
    for (int i = 0; i < kMaxReads; ++i) {
      if (!GoesOn()) return Cancelled();
      absl::StatusOr<Result> result = ReadOnce(look);
      if (!absl::IsAborted(result.status())) return result;
    }
    return absl::UnavailableError("the map changed each time that it was read: try again");
  }

  template <typename Result>
  absl::StatusOr<Result> ReadOnce(
      absl::FunctionRef<absl::StatusOr<Result>(const MissionState&, LongRead&)> look) {
    absl::ReaderMutexLock lock(&strand_.mutex());
    if (strand_.deleted()) return strand_.Deleted();
    const uint64_t revision = strand_.state().global.revision;
    PausingRead read(strand_, [this, revision]() ABSL_NO_THREAD_SAFETY_ANALYSIS -> absl::Status {
      if (strand_.deleted()) return strand_.Deleted();
      if (strand_.state().global.revision == revision) return absl::OkStatus();
      return absl::AbortedError("another revision was committed");
    });
    return look(strand_.state(), read);
  }

  bool IsOutsidePrior(const Rigid3d& camera_from_island) const {
    if (!query_.prior.has_value()) return false;
    const Eigen::Vector3d expected = query_.prior->camera_from_global.Inverse().translation;
    return (camera_from_island.Inverse().translation - expected).norm() > query_.prior->radius_m;
  }

  void Take(IslandId island, bool in_reference, LocateFrameResult result) {
    answer_.stage = result.stage;
    answer_.revision = result.base_revision;
    answer_.word_matches = result.word_matches;
    answer_.pose_inliers = result.pose_inliers;
    answer_.inliers = result.inliers;
    answer_.inliers_needed = result.inliers_needed;
    answer_.visible_points = result.visible_points;
    answer_.chance_inliers = result.chance_inliers;
    answer_.fitting_camera = result.fitting_camera;
    if (result.stage != LocateStage::kLocated) return;
    answer_.island = island;
    answer_.in_reference_island = in_reference;
    answer_.camera_from_island = result.camera_from_map;
    answer_.covariance = std::move(result.covariance);
    answer_.keyframes = std::move(result.keyframes);
  }

  bool GoesOn() const { return goes_on_ == nullptr || goes_on_(); }

  const MissionStrand& strand_;
  FusionWorker& worker_;
  const LocalizeQuery& query_;
  const std::function<bool()>& goes_on_;
  Keyframe frame_;
  LocalizeAnswer answer_;
};

}  // namespace

absl::StatusOr<LocalizeAnswer> LocalizePicture(const MissionStrand& strand, FusionWorker& worker,
                                               const LocalizeQuery& query,
                                               const std::function<bool()>& goes_on) {
  return Search(strand, worker, query, goes_on).Run();
}

}  // namespace corbslam::map_store
