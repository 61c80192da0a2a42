// An agent's connection to the map store, as the agent sees it. One implementation goes over a
// stream; another is direct, for a deterministic run in one process.
#ifndef CORBSLAM_SLAM_EXCHANGE_UPLINK_H_
#define CORBSLAM_SLAM_EXCHANGE_UPLINK_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "slam/camera/recorded_camera.h"
#include "slam/exchange/agent_report.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/shared_update.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

// What one side may send because the other has said that it understands it.
struct Capabilities {
  // A store that has it understands MapUpdateBatch::points_follow.
  bool points_follow = false;
  // Both sides understand coded columns of features and of descriptors (docs/wire.md).
  bool coded_features = false;
  // A store that has it understands SessionRequest::localise_only.
  bool localise_only = false;
  // A store that has it keeps what LocalisedFrames say of an agent's trajectory.
  bool keeps_localised = false;
  // A store that has it takes keyframes' pictures (Uplink::SendPicture).
  bool keyframe_pictures = false;
  // A store that has it takes Uplink::SendReport.
  bool takes_reports = false;
};

// What of the global layer an agent is told.
enum class ShareMode {
  kNone,         // Nothing: it has no global pose either.
  kCorrections,  // Where its own keyframes stand.
  kNearby,       // That, and others' keyframes near it, with their points.
  kEverything,   // That, and in time all others' keyframes and points.
};

struct ShareScope {
  ShareMode mode = ShareMode::kEverything;
  // With kNearby: how far keyframes may be from the newest one that the agent sent, in metres of
  // the island's frame, 1 to 1e6.
  double radius_m = 50;

  bool operator==(const ShareScope&) const = default;
};

// The first message of a session: opens or resumes.
struct SessionRequest {
  std::string mission;
  std::string agent;
  // Last revision of which a SharedUpdate was applied; 0: none.
  uint64_t last_revision = 0;
  // Local maps of which unacknowledged batches are held.
  std::vector<LocalMapId> local_maps;
  // A number that the agent's process draws at random, the same in all its sessions; 0: not known.
  uint64_t instance = 0;
  // True: a session that another process holds gives way.
  bool take_over = false;
  // What the agent understands.
  Capabilities capabilities = {};
  // At most about so many bytes of shared updates a second; 0: no bound.
  uint64_t downlink_bytes_per_second = 0;
  ShareScope share = {};
  // True: the agent changes nothing. It sends no batches, only where its frames were
  // (Uplink::SendLocalised), and what it is told is in the mission's global frame.
  bool localise_only = false;
  // SessionGrant::mission_uid of the mission in which the agent's process had a session before;
  // empty: it had none, or does not know.
  std::string mission_uid = "";
  // Where the request came from, for people. The store's transport says it, not the agent.
  std::string peer = "";
};

// Says up to which batch of a local map everything is durably stored.
struct Acknowledgement {
  LocalMapId local_map;
  uint64_t number = 0;
};

struct SessionGrant {
  std::vector<Acknowledgement> acknowledged;
  // What the store understands.
  Capabilities capabilities = {};
  // Tells the mission from earlier and later ones of its name; empty: the store does not say.
  std::string mission_uid = "";
};

// Where a frame was of an agent that changes nothing.
struct LocalisedFrame {
  int64_t timestamp_ns = 0;
  // In the mission's global frame as the agent was told it; nullopt: it was lost.
  std::optional<Rigid3d> camera_from_global;
};

// What an agent says that changes nothing.
struct LocalisedFrames {
  // Where it is, by time, so that what is near follows. The store forgets it.
  std::vector<LocalisedFrame> frames;
  // The rest is a part of its trajectory. Parts are numbered 1, 2, 3, ... within a run, which is a
  // random number of the agent's process; 0: there is no part.
  uint64_t run = 0;
  uint64_t number = 0;
  // What recorded the pictures; that of a run's first part counts. Nullopt: nobody said it.
  std::optional<RecordedCamera> recorded_camera;
  // Relative to others' keyframes, in units of the global frame.
  std::vector<TrackedFrame> tracked_frames;
  // Times at which there is no pose: the trajectory has a gap there.
  std::vector<int64_t> lost_frames_ns;
};

// Says up to which part of a run everything is durably kept; 0: nothing is.
struct LocalisedKept {
  uint64_t run = 0;
  uint64_t number = 0;
};

// What a keyframe's camera saw, for people to look at; no algorithm reads it.
struct KeyframePicture {
  KeyframeId keyframe;
  // A grey JPEG of the undistorted picture that the keypoints' positions are of.
  std::string jpeg;
  // Pixels of the keypoints' positions to one of the picture's, 1 to 64: what lies at x there lies
  // at (x + 0.5) / scale - 0.5 here.
  double scale = 1;
};

// Most bytes of KeyframePicture::jpeg.
inline constexpr size_t kMaxPictureBytes = 64 << 10;

// Hears what comes from the store. One thread at a time calls it, and never from inside a call of
// Uplink, but for the direct implementation.
class UplinkListener {
 public:
  virtual ~UplinkListener() = default;
  // A session stands: the agent sends everything after what `grant` acknowledges.
  virtual void OnSessionOpened(const SessionGrant& grant) = 0;
  virtual void OnAcknowledged(const Acknowledgement& acknowledgement) = 0;
  // Called for agents that only localise: the store keeps so much of what they told. Others need
  // not override it.
  virtual void OnLocalisedKept(const LocalisedKept& /*kept*/) {}
  virtual void OnShared(SharedUpdate update) = 0;
  // The store wants to be told where the points of the newest local map are, exactly.
  virtual void OnExactPlacesWanted() = 0;
  // The session is gone. ABORTED: a newer session of the same agent fenced it off, or the mission
  // is deleted (session_end.h), and then no session comes any more. PERMISSION_DENIED: the store
  // refuses this agent, which may ask again rarely. INVALID_ARGUMENT: likewise before
  // OnSessionOpened; after it a batch was refused. After anything else open again later, also after
  // ALREADY_EXISTS: another process holds a session of this agent.
  virtual void OnSessionClosed(const absl::Status& reason) = 0;
};

// No call blocks on the network. Thread-safe.
class Uplink {
 public:
  virtual ~Uplink() = default;
  // Starts connecting; the listener hears the outcome and must outlive the session.
  virtual void Open(const SessionRequest& request, UplinkListener* listener) = 0;
  // Returns false when no session stands, or the transport's queue is full: keep the batch, try
  // again.
  virtual bool Send(const MapUpdateBatch& batch) = 0;
  // Does the same with what an agent says that changes nothing.
  virtual bool SendLocalised(const LocalisedFrames& localised) = 0;
  // Does the same with a picture, which nobody answers: one that was taken may still be lost.
  virtual bool SendPicture(const KeyframePicture& picture) = 0;
  // Does the same with what an agent says of itself, of which only the newest counts.
  virtual bool SendReport(const AgentReport& report) = 0;
  // Reads nothing more from the store until ResumeReading, but for what is being read: the listener
  // has no room. Acknowledgements wait, too. May be called by the listener. A transport that brings
  // only what its owner asks for needs neither.
  virtual void PauseReading() {}
  virtual void ResumeReading() {}
  // Ends the session; no call to the listener is under way or follows once it returns.
  virtual void Close() = 0;
  // Returns the bytes on the wire since construction.
  virtual uint64_t bytes_up() const = 0;
  // Bytes that Send has taken and that are not on the wire yet; they never will be if the session
  // ends first. The default is for an uplink without such a queue.
  virtual uint64_t bytes_waiting() const { return 0; }
  virtual uint64_t bytes_down() const = 0;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EXCHANGE_UPLINK_H_
