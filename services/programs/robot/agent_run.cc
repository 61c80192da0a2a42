#include "services/programs/robot/agent_run.h"

#include <glog/logging.h>

#include <chrono>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client_agent/source/kept_imu.h"
#include "client_agent/source/pictures/mask_picture.h"
#include "services/programs/robot/left_out_log.h"
#include "services/programs/robot/no_pose_log.h"
#include "services/programs/robot/pictures_time.h"
#include "services/server/process_usage.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::Agent;
using client_agent::AgentStatus;
using client_agent::FindingLevel;
using client_agent::FramePose;
using client_agent::FrameStream;
using client_agent::KeptImu;
using client_agent::LeftOutFrames;
using client_agent::MaskedPercent;
using client_agent::PoseListener;
using client_agent::SourceFindings;
using client_agent::SourceFrame;
using client_agent::StreamFrame;
using client_agent::TrackingResult;
using client_agent::TrackingState;
using client_agent::WhyNoPose;

namespace {

// Notes what is not the robot's doing: frames that `stream` passed over, and that it is slow.
void WatchStream(const FrameStream& stream, const PacedStream& paced, LeftOutLog& left_out,
                 SlowSourceLog& slow, const FrameRateLimit* limit, PlayedFrames& frames) {
  const absl::Time now = absl::Now();
  frames.left_out = left_out.Tell(stream, now);
  slow.Tell(paced.source_pace(), stream.interval_s(), now);
  frames.source_pace = paced.source_pace();
  frames.dropped = paced.dropped() + stream.overtaken();
  if (limit != nullptr) frames.dropped += limit->left_out();
}

// Begins a new local map when the frame is of another drive than the one `before` it.
void FollowDrive(const SourceFrame& frame, std::optional<SourceFrame>& before, Agent& agent) {
  if (before.has_value() && before->drive != frame.drive) {
    LOG(WARNING) << "the source's time jumps "
                 << (frame.timestamp_ns > before->timestamp_ns ? "ahead" : "back")
                 << " before frame " << frame.number << ": a new local map begins";
    agent.BeginLocalMap();
  }
  before = frame;
}

void TellListener(const TrackingResult& result, uint64_t dropped, FrameStream& stream) {
  PoseListener* const listener = stream.pose_listener();
  if (listener == nullptr) return;
  FramePose pose{.timestamp_ns = result.timestamp_ns,
                 .local_map = result.local_map,
                 .is_lost = result.state == TrackingState::kLost,
                 .points_matched = result.points_matched,
                 .dropped = dropped};
  if (result.state == TrackingState::kTracking) {
    pose.local_from_camera = result.camera_from_local.Inverse();
  }
  listener->OnPose(pose);
}

std::string AdviseOnPictures(const FrameStream& stream) {
  return stream.is_live() ? "corbslam rig check --rig FILE --source SOURCE says what is wrong with "
                            "what the camera gives"
                          : "Ask corbslam doctor --source what is wrong with the pictures";
}

// Says why a robot that only localises found none of its frames.
std::string WhyNotLocalised(const FrameStream& stream, const AgentStatus& status,
                            const RobotTask& task) {
  if (absl::IsNotFound(task.session)) {
    return absl::StrCat(task.session.message(),
                        ". Is --mission right? corbslam mission list says which there are; a robot "
                        "without --localise-only begins one");
  }
  if (!task.session.ok()) {
    return absl::StrCat("nothing of others' map came, as no session with the map store stands: ",
                        task.session.ToString());
  }
  if (status.why_no_pose == WhyNoPose::kAnotherCamera) {
    return "what others mapped shows these places, but to another camera than the rig's (the log "
           "says which fits): is the rig file this camera's, of this picture size? (docs/rig.md)";
  }
  const std::string show =
      absl::StrCat("corbslam mission show --mission ", task.mission, " says what is there");
  if (status.foreign_keyframes == 0 && task.shares_nearby) {
    return absl::StrCat("nothing of others' map came: nobody has mapped in mission ", task.mission,
                        " yet, or the map store did not recognise the place in any frame. ", show);
  }
  if (status.foreign_keyframes == 0) {
    return absl::StrCat("nobody has mapped in mission ", task.mission,
                        " yet, or nothing of it came in that time. ", show);
  }
  return absl::StrCat("it was recognised nowhere in the ", status.foreign_keyframes,
                      " keyframes of others that it has: is it a place that was mapped, seen from "
                      "where robots were, and the rig this camera's (docs/localize.md)? ",
                      AdviseOnPictures(stream));
}

std::string DescribeNothing(const FrameStream& stream, const PlayedFrames& played,
                            const AgentStatus& status, const RobotTask& task) {
  const std::string frames = played.played > 0
                                 ? absl::StrCat("none of ", played.played, " frames was tracked")
                                 : "there was no frame to track";
  if (played.played > 0 && task.localise_only) {
    return absl::StrCat(frames, ": ", WhyNotLocalised(stream, status, task));
  }
  if (played.played > 0 && task.resume && status.keyframes > 0) {
    return absl::StrCat(frames, ": the place was not recognised in the map of ", status.keyframes,
                        " keyframes that --resume took up. Is the robot where it was? A new local "
                        "map begins after ten seconds of good pictures. ",
                        AdviseOnPictures(stream));
  }
  if (played.played > 0 && status.why_no_pose == WhyNoPose::kLittleParallax) {
    return absl::StrCat(frames,
                        ": there is no map, for one camera alone sees no depth before it has moved "
                        "aside, by about a twentieth of how far away what it sees is. It stood, "
                        "turned on the spot, or saw far things only");
  }
  return absl::StrCat(frames, ": there is no map. ", AdviseOnPictures(stream));
}

}  // namespace

absl::Status PlayStream(
    FrameStream& stream, Agent& agent, Pace pace, const absl::Notification& stop,
    PlayedFrames& frames,
    const std::function<void(const TrackingResult&, const FrameMoment&)>& on_frame,
    FrameRateLimit* limit) {
  PacedStream paced(stream, pace, stop);
  LeftOutLog left_out;
  SlowSourceLog slow;
  std::optional<SourceFrame> before;
  KeptImu kept_imu;  // Of frames that `limit` left out.
  NoPoseLog no_pose(MaskedPercent(stream.calibration()));
  while (true) {
    absl::StatusOr<std::optional<StreamFrame>> next = paced.Next();
    WatchStream(stream, paced, left_out, slow, limit, frames);
    RETURN_IF_ERROR(next.status());
    if (!next->has_value()) {
      frames.stopped = stop.HasBeenNotified();
      return absl::OkStatus();
    }
    if (limit != nullptr && !limit->Takes((*next)->images.timestamp_ns)) {
      kept_imu.Keep((*next)->frame.drive, std::move((*next)->images.imu));
      continue;
    }
    kept_imu.GiveTo((*next)->frame.drive, (*next)->images.imu);
    FollowDrive((*next)->frame, before, agent);
    const auto came = (*next)->came.value_or(std::chrono::steady_clock::now());
    ASSIGN_OR_RETURN(const TrackingResult result, agent.Track((*next)->images));
    ++frames.played;
    frames.relocalised.Add(result);
    if (const auto line = no_pose.Add(result, (*next)->images)) LOG(WARNING) << *line;
    if ((*next)->came.has_value()) {
      const std::chrono::duration<double, std::milli> latency =
          std::chrono::steady_clock::now() - came;
      frames.latency_ms.Add(latency.count());
    }
    TellListener(result, frames.dropped, stream);
    on_frame(result, {came, frames.dropped});
    RETURN_IF_ERROR(agent.UsePause());
  }
}

SourceFindings CollectWarnings(const SourceFindings& at_start, const Agent& agent,
                               const FrameStream& stream, const PlayedFrames& played,
                               const RobotTask& task) {
  SourceFindings warnings = at_start;
  const AgentStatus status = agent.GetStatus();
  warnings.insert(warnings.end(), status.input_findings.begin(), status.input_findings.end());
  const SourceFindings seen = stream.findings();
  warnings.insert(warnings.end(), seen.begin(), seen.end());
  if (const LeftOutFrames left_out = stream.left_out(); left_out.count > 0) {
    warnings.push_back(
        {FindingLevel::kWarning, "frames-left-out", DescribeLeftOut(stream, left_out)});
  }
  if (played.source_pace.IsTooSlow()) {
    warnings.push_back({FindingLevel::kWarning, "source-too-slow",
                        DescribeSlowSource(played.source_pace, stream.interval_s())});
  }
  if (status.upload.refused_items > 0) {
    warnings.push_back(
        {FindingLevel::kWarning, "items-refused",
         absl::StrCat(status.upload.refused_items,
                      " items of the map had impossible values and were not told to the map store; "
                      "the log names them")});
  }
  if (status.tracked > 0 && status.without_metres) {
    warnings.push_back(
        {FindingLevel::kWarning, "without-metres",
         absl::StrCat(
             "one camera alone: the robot's map is in a unit of its own",
             status.global_without_metres
                 ? ", and so is the mission's, for no stereo or RGB-D robot's map is merged "
                   "with it. Hold it against the truth with --align sim3"
                 : "; the mission's is in metres, by a map that it is merged with")});
  }
  const bool had_any = played.played > 0 || stream.left_out().count > 0 || !played.stopped;
  if (status.tracked == 0 && had_any) {
    warnings.push_back(
        {FindingLevel::kWarning, "nothing-tracked", DescribeNothing(stream, played, status, task)});
  }
  return warnings;
}

void AddRun(const FrameStream& stream, const PlayedFrames& played, const SourceFindings& warnings,
            RobotReport& report) {
  const uint64_t frames = played.played + played.dropped;
  report.frames = static_cast<int>(frames);
  report.dropped = static_cast<int>(played.dropped);
  report.left_out = static_cast<int>(played.left_out);
  report.relocalised = played.relocalised.all();
  report.shared_relocalised = played.relocalised.by_others();
  report.latency_ms = SpreadOf(played.latency_ms);
  report.pictures_s = PicturesTime_s(stream, frames);
  report.warnings = ToReportWarnings(warnings);
  const ProcessUsage usage = GetProcessUsage();
  report.peak_rss_mb = static_cast<double>(usage.peak_rss_bytes) / (1 << 20);
  report.cpu_s = usage.cpu_s;
}

}  // namespace corbslam::services
