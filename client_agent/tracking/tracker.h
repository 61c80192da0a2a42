// Tracks the camera in one local map: frame by frame, against the map that mapping builds
// (ORB-SLAM, T-RO 2015, section V; ORB-SLAM2, T-RO 2017, section III).
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_TRACKER_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_TRACKER_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "client_agent/map/guarded_map.h"
#include "client_agent/mapping/mapping_queue.h"
#include "client_agent/mapping/measurement_book.h"
#include "client_agent/mapping/point_statistics.h"
#include "client_agent/tracking/camera_doubt.h"
#include "client_agent/tracking/frame.h"
#include "client_agent/tracking/keyframe_policy.h"
#include "client_agent/tracking/local_map_view.h"
#include "client_agent/tracking/monocular_start.h"
#include "client_agent/tracking/others_scale.h"
#include "client_agent/tracking/others_shape.h"
#include "client_agent/tracking/patch_following.h"
#include "client_agent/tracking/patch_sources.h"
#include "client_agent/tracking/relocalisation.h"
#include "client_agent/tracking/tracking_result.h"
#include "slam/inertial/inertial_motion.h"
#include "slam/vocabulary/vocabulary.h"

namespace corbslam::client_agent {

struct TrackerOptions {
  // A local map begins with a frame of so many keypoints, a fifth of them with depth; of one camera
  // alone with two frames of so many.
  int min_keypoints_to_begin = 500;
  // Search radius around the constant-velocity prediction, pixels at the finest level.
  double previous_frame_radius_px = 7;
  // Multiplies the radius in which local map points are sought; RGB-D depths are coarser.
  double local_map_widening = 1;
  // False: a depth camera measures distances. Its own are off by a per cent here and there, so that
  // others' are not held against them.
  bool has_stereo = true;
  int min_local_map_inliers = 30;
  int min_local_map_inliers_after_relocalisation = 50;
  // A pose is doubtful if no larger share of the points in view agrees with it: other ways to it
  // are tried, and the best supported one is taken.
  double doubtful_share = 0.15;
  // A doubtful pose needs as many inliers as one found by relocalising, and this share of the
  // points in view. With thousands in view, some dozens agree with a wrong pose by chance.
  double min_doubtful_share = 0.05;
  // The local map is given up when the robot is lost for so many frames; at once where it is this
  // small.
  int max_lost_frames = 30;
  int min_keyframes_to_wait = 5;
  // True: the camera is tracked in what others made, and no map is begun or added to. Frames are
  // lost until one of them is found there.
  bool localise_only = false;
  // A tracker that begins lost (BeginLost) gives the map up when it has recognised no place in it
  // for so long, by the frames' own times.
  int64_t max_lost_at_start_ns = 10'000'000'000;
  // So many frames in a row at most are followed by patches; then one is searched for features. 0:
  // none is followed.
  int most_followed = 8;
  uint64_t seed = 1;
  KeyframePolicyOptions keyframe;
};

// What tracking shares with the robot's other parts; nothing is owned.
struct TrackerParts {
  GuardedMap* map = nullptr;
  MappingQueue* queue = nullptr;
  PointStatistics* statistics = nullptr;
  const Vocabulary* vocabulary = nullptr;
  // May be null: then a lost frame is not sought in the map.
  const PlaceFinder* places = nullptr;
  // May be null: then the measurements of frames that become no keyframe are not kept.
  MeasurementBook* measurements = nullptr;
};

// What tracking in one local map passes on to that in the next: a frame, with its pose in the old
// map's frame and without what it sees there, and what the camera moved up to it.
struct HandedFrame {
  Frame frame;
  std::optional<CameraMotion> motion;
};

// One thread may use it at a time. It waits for nothing but short locks.
class Tracker {
 public:
  Tracker(const TrackerOptions& options, std::shared_ptr<const Camera> camera,
          const TrackerParts& parts);

  // What was seen has no id and no camera: the camera is the tracker's.
  TrackingResult Track(KeyframePayload seen);

  // Returns whether Follow may do for the frame of this time, so that its picture need perhaps not
  // be searched for features.
  bool MayFollow(int64_t timestamp_ns) const;
  // Finds the frame's pose by what keyframes' pictures look like. Nullopt where that is not enough:
  // then it is to be tracked by its features.
  std::optional<TrackingResult> Follow(const FreshPicture& fresh);
  // Returns whether the frame that was followed last may be worth keeping: then Describe is to be
  // called with its features before the next frame.
  bool WantsFeatures() const { return wants_features_; }
  // Has the next frame searched for features in any case.
  void SearchNext() { followed_ = options_.most_followed; }
  // Returns the keyframe that the frame became; an invalid id: none.
  KeyframeId Describe(KeyframePayload seen);
  // Takes what an IMU says that the camera moved from the last frame that had a pose to the next
  // one; nullopt where nobody says it.
  void Expect(std::optional<InertialMotion> motion) { expected_ = std::move(motion); }
  // Keeps the picture of the keyframe that the last frame became, for Follow.
  void KeepPicture(const HalvedPicture& picture) { pictures_.Add(last_keyframe_, picture); }

  // Returns the newest frame, for the tracker of another local map to go on from. Nullopt where
  // that has no pose or shows too little for a map to begin with, while mapping is paused, and of
  // one camera alone: no map of it begins with one frame.
  std::optional<HandedFrame> HandOver() const;
  // Begins the map with a frame that another tracker handed over, at the pose that it has: poses go
  // on as if it had been tracked here. To be called instead of Track for the first frame. Returns
  // false, and does nothing, where mapping takes no keyframe.
  bool TakeOver(const HandedFrame& handed);

  // The map is not empty, and nobody knows where in it the camera is. To be called before the first
  // frame.
  void BeginLost();

  // While paused the map gets no keyframes, and none is begun or given up.
  void PauseMapping(bool paused) { mapping_paused_ = paused || options_.localise_only; }

  // Returns what the last frame showed; null before the first.
  std::shared_ptr<const KeyframePayload> last_payload() const { return last_payload_; }
  // While the camera is lost, looks at the map where somebody else says that an earlier lost frame
  // was. Returns whether the map agrees: tracking goes on from there.
  bool ResumeAt(std::shared_ptr<const KeyframePayload> payload, const Rigid3d& camera_from_map);

  // Returns those of others' local maps that turned out to contradict since the last call.
  std::vector<MapContradiction> TakeContradictions() { return std::exchange(contradictions_, {}); }

  // True when tracking will not find its way back, so that it is time for a new local map: not
  // while the pictures are such that none could begin, nor while an IMU knows where the camera is.
  // What covers the camera ends no map, and uses up half of the patience at most.
  bool IsLostForGood() const;

 private:
  WhyNoPose Begin(Frame& frame);
  // Begins the map of one camera, once it has moved aside.
  WhyNoPose BeginByParallax(Frame& frame);
  // Returns kHasOne for a frame that shows enough to begin a map with.
  WhyNoPose JudgePicture(const Frame& frame) const;
  // Frames after a relocalisation in which tracking must prove itself, by features.
  static constexpr int kProbation = 30;
  // A pose for the frame with what it rests on.
  struct Solution {
    Frame frame;
    LocalMapView local_map;
    InlierCount inliers;
    std::vector<MapPointId> visible;
    uint64_t corrections = 0;
    // The keyframe that the map goes on with behind a gap is not in it yet.
    bool waits_for_bridge = false;
  };
  using FirstPose = bool (Tracker::*)(Frame&) const;

  bool FindPose(Frame& frame);
  std::optional<Rigid3d> FindRoughly(const FreshPicture& fresh, const Rigid3d& predicted,
                                     const std::vector<PatchSource>& sources);
  TrackingResult Take(Solution followed);
  void Accept(Solution solution, Frame& frame);
  // Takes the solution for what is known of the frame.
  void Adopt(Solution solution, Frame& frame);
  // Only with stereo; and a robot that only localises has nothing but others' map.
  void HoldAgainstOthers(const Frame& frame);
  std::optional<Solution> SolveInOneMap(const Frame& frame);
  std::optional<Solution> SolveTracking(const Frame& frame);
  std::optional<Solution> Solve(const std::vector<FirstPose>& ways, const Frame& frame,
                                std::optional<Solution> best) const;
  // Chooses between two ways to go on after a gap, and learns which the pictures agree with.
  std::optional<Solution> Choose(std::optional<Solution> in_time,
                                 std::optional<Solution> as_before);
  // How many frames' time has passed since the previous frame, over the same between that and the
  // one before: not 1 after or before a gap in which frames were dropped.
  double TimesOfMotion(int64_t timestamp_ns) const;
  // Forgets what was expected from another frame on than the previous one.
  void CheckExpected(int64_t timestamp_ns);
  // Returns camera_from_map of the frame that something is expected of.
  Rigid3d ExpectedPose() const;
  bool FollowExpected(Frame& frame) const;
  // Looks at the map from where the IMU takes a camera to be that was lost.
  bool ComeBackAsExpected(Frame& frame) const;
  bool FollowMotion(Frame& frame) const;
  bool FollowMotionInTime(Frame& frame) const;
  bool SearchAroundPrevious(Frame& frame) const;
  bool MatchReferenceKeyframe(Frame& frame) const;
  bool Relocalise(Frame& frame) const;
  bool TrackPreviousFrame(const Rigid3d& predicted, double radius_px, Frame& frame) const;
  bool TrackLocalMap(Solution& solution) const;
  // Returns how many of the inliers count: before mapping has inserted the first keyframe there are
  // only temporary points.
  static int Support(const Solution& solution);
  bool IsDoubtful(const Solution& solution) const;
  bool IsSure(const Solution& solution) const;
  // Points that agree, times their share of those in view.
  static double Evidence(const Solution& solution);
  // Returns false for a solution that is worse than no pose at all.
  bool IsBelievable(const Solution& solution) const;
  // Returns false for one in others' map that a look-up of the same picture would refuse.
  bool IsSupportedInOthers(const Solution& solution) const;
  bool IsInOthers(const Solution& solution) const;
  // Returns false for a place that the IMU can't have got to since the camera was lost, and for a
  // pose of few points that it contradicts.
  bool IsWithinReach(const Solution& solution) const;
  // Returns false for one in others' map that shows another camera than the rig's.
  bool IsOfThisCamera(const Solution& solution);
  void SetReference(Frame& frame) const;
  // Where the map does not show what the camera sees now, goes on with the map where the IMU takes
  // the camera to be, if that is known well.
  bool Bridge(Frame& frame);
  bool MayBridge() const;
  // The IMU knows well enough for that where the camera is.
  bool IsWellReckoned() const;
  // How a pose that was found differs from the one that is expected.
  struct Apart {
    double distance = 0;  // Squared, in units of both covariances.
    Vector6d step;        // From the expected pose to the one that both weigh, in the map's axes.
    Rigid3d map_from_expected;
  };
  std::optional<Apart> FromExpected(const Frame& frame) const;
  // Draws a pose that was found towards the one that is expected, each by its covariance: the first
  // picture behind a gap may show little of the map.
  void WeighExpected(Frame& frame) const;
  // Where the IMU takes the next frame to be.
  std::optional<ReckonedPose> Reckon() const;
  // Returns all of a frame's evidence but its close points.
  KeyframeEvidence EvidenceOf(const LocalMapView& local_map, int inliers,
                              int64_t timestamp_ns) const;
  void ConsiderKeyframe(Frame& frame);
  // Returns what keyframe evidence the frame's features would give.
  KeyframeEvidence Guess(const Solution& followed, size_t sought) const;
  // Learns from a frame that was searched for features how good guesses are.
  void LearnGuess(const KeyframeEvidence& evidence);
  void MakeKeyframe(Frame& frame, std::shared_ptr<const MapBeginning> beginning = nullptr);
  void EnsureWords(Frame& frame) const;
  void KeepMeasurements(const Frame& frame) const;
  // Returns what the camera moved since the previous frame, by the map as it is now.
  std::optional<CameraMotion> MotionTo(const Frame& frame) const;
  TrackingResult Conclude(Frame frame, WhyNoPose why_no_pose);
  void ConcludeLost(WhyNoPose why_no_pose);
  void ConcludeTracked(Frame frame, TrackingResult& result);

  const TrackerOptions options_;
  const std::shared_ptr<const Camera> camera_;
  const TrackerParts parts_;

  TrackingState state_ = TrackingState::kNotInitialised;
  std::optional<Frame> previous_;
  std::shared_ptr<const KeyframePayload> last_payload_;
  // The motion up to the frame before; none after a start or relocalisation.
  std::optional<CameraMotion> velocity_;
  std::optional<InertialMotion> expected_;
  std::optional<Matrix6d> previous_covariance_;  // Of the previous frame's pose, in the map's axes.
  KeyframeId bridge_;  // The newest keyframe that the map went on with behind a gap.
  int unrecognised_in_a_row_ = 0;
  FrameRhythm rhythm_;
  // Grows with each gap after which the camera was where the time that passed takes it, and falls
  // with each after which it was as far on as after one frame.
  int trust_in_stamps_ = 0;
  LocalMapView local_map_;
  InlierCount inliers_;
  int points_in_view_ = 0;
  // Map::corrections of the map that the last pose was found in.
  uint64_t corrections_ = 0;
  KeyframePictures pictures_;
  HalvedPicture last_picture_;  // Small levels alone, of the last one that was to be followed.
  int followed_ = 0;            // Frames in a row.
  // What the newest frame showed that was searched for features.
  KeyframeEvidence described_;
  int described_in_view_ = 0;
  // What was guessed of the frame that was followed last, and what guesses are multiplied by.
  std::optional<double> guessed_inliers_;
  double guess_factor_ = 1;
  bool wants_features_ = false;
  bool became_keyframe_ = false;  // The newest frame, after its result was returned.
  bool mapping_paused_ = false;
  MonocularStart monocular_start_;
  CameraDoubt camera_doubt_;
  OthersScale others_scale_;
  OthersShape others_shape_;
  std::vector<MapContradiction> contradictions_;
  KeyframeId last_keyframe_;
  int64_t last_keyframe_ns_ = 0;
  bool was_anothers_camera_ = false;  // In the newest frame.
  WhyNoPose why_lost_ = WhyNoPose::kHasOne;
  int lost_frames_ = 0;
  int frames_since_relocalisation_ = 1 << 20;
  // True: the camera was not found yet since BeginLost.
  bool begins_lost_ = false;
  std::optional<int64_t> first_lost_ns_;
  int64_t lost_at_start_ns_ = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_TRACKER_H_
