#include "tests/bench/replayed_mission.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "services/programs/default_vocabulary.h"
#include "services/tool/evaluation/accuracy.h"
#include "services/tool/run/plan.h"
#include "slam/evaluation/trajectory_error.h"
#include "slam/util/status_macros.h"

namespace corbslam::tests {

using client_agent::ParseSourceSpec;
using client_agent::SourceSpec;
using map_store::AgentTrajectory;
using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;
using map_store::MissionStatistics;
using map_store::StoredPose;
using map_store::TrajectoryFrame;
using services::DefaultVocabularyPath;
using services::GroundTruth;
using services::ReadGroundTruth;
using services::RobotName;

namespace {

LocalMapId MapOf(size_t robot) { return LocalMapId{0xa + robot}; }

MapStoreOptions Deterministic(MapStoreOptions options) {
  options.deterministic = true;
  return options;
}

}  // namespace

absl::StatusOr<RecordedMission> RecordMission(const std::string& source, size_t robots) {
  RecordedMission recorded;
  ASSIGN_OR_RETURN(recorded.vocabulary, Vocabulary::Load(DefaultVocabularyPath()));
  ASSIGN_OR_RETURN(const SourceSpec whole, ParseSourceSpec(source));
  ASSIGN_OR_RETURN(const std::optional<GroundTruth> truth, ReadGroundTruth(whole));
  if (!truth.has_value()) return absl::NotFoundError(absl::StrCat(source, " has no ground truth"));
  recorded.truth = truth->trajectory;
  for (size_t i = 0; i < robots; ++i) {
    const std::string part = absl::StrCat(source, absl::StrContains(source, '?') ? "&" : "?",
                                          "robot=", i + 1, "/", robots);
    ASSIGN_OR_RETURN(RecordedUploads uploads, RecordUploads(part, recorded.vocabulary));
    for (MapUpdateBatch& batch : uploads) batch = AsLocalMap(batch, MapOf(i));
    recorded.robots.push_back(std::move(uploads));
  }
  return recorded;
}

ReplayedMission::ReplayedMission(const RecordedMission& recorded, MapStoreOptions options,
                                 FusionWorker* worker)
    : recorded_(recorded),
      store_(Deterministic(std::move(options)), recorded.vocabulary,
             std::make_unique<InMemoryJournal>(), worker) {}

const std::string& ReplayedMission::name() {
  static const auto* const name = new std::string("replayed");
  return *name;
}

absl::Status ReplayedMission::Stream(absl::FunctionRef<absl::Status(Step)> note) {
  std::vector<uint64_t> sessions;
  size_t most = 0;
  for (size_t i = 0; i < recorded_.robots.size(); ++i) {
    SessionRequest request;
    request.mission = name();
    request.agent = RobotName(i);
    ASSIGN_OR_RETURN(const MapStore::OpenedSession opened, store_.OpenSession(request));
    sessions.push_back(opened.session_id);
    most = std::max(most, recorded_.robots[i].size());
  }
  for (size_t batch = 0; batch < most; ++batch) {
    for (size_t i = 0; i < sessions.size(); ++i) {
      if (batch >= recorded_.robots[i].size()) continue;
      RETURN_IF_ERROR(store_.Apply(sessions[i], recorded_.robots[i][batch]).status());
    }
    RETURN_IF_ERROR(note(Step::kSent));
    RETURN_IF_ERROR(Fuse());
    RETURN_IF_ERROR(note(Step::kFused));
  }
  for (const uint64_t session : sessions) store_.CloseSession(session);
  RETURN_IF_ERROR(Fuse());
  return note(Step::kFused);
}

absl::StatusOr<FusedMapError> ReplayedMission::Error() const {
  FusedMapError error;
  ASSIGN_OR_RETURN(const MissionStatistics statistics, store_.GetStatistics(name()));
  error.islands = statistics.islands;
  ASSIGN_OR_RETURN(const std::vector<AgentTrajectory> agents,
                   store_.GetTrajectory(name(), "", TrajectoryFrame::kGlobal));
  std::vector<PosePair> pairs;
  for (const AgentTrajectory& agent : agents) {
    Trajectory estimate;
    for (const StoredPose& pose : agent.poses) {
      estimate.push_back({pose.timestamp_ns, pose.frame_from_camera});
    }
    const std::vector<PosePair> of_agent = AssociateByTime(estimate, recorded_.truth);
    pairs.insert(pairs.end(), of_agent.begin(), of_agent.end());
  }
  error.frames = pairs.size();
  ASSIGN_OR_RETURN(const AbsoluteError absolute, ComputeAbsoluteError(pairs, Alignment::kSe3));
  error.ate_m = absolute.rmse_m;
  return error;
}

}  // namespace corbslam::tests
