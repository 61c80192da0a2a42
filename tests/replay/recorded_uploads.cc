#include "tests/replay/recorded_uploads.h"

#include <optional>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "client_agent/agent/agent.h"
#include "client_agent/source/recorded_sequence.h"
#include "client_agent/source/source_spec.h"
#include "slam/util/status_macros.h"

namespace corbslam::tests {

using client_agent::Agent;
using client_agent::AgentOptions;
using client_agent::FeatureSelection;
using client_agent::OpenSource;
using client_agent::ParseSourceSpec;
using client_agent::RecordedSequence;
using client_agent::SourceSpec;

namespace {

constexpr int kStereoFeatures = 2000;
constexpr int kRgbdFeatures = 1000;

// A store that keeps every batch and says so at once.
class RecordingUplink : public Uplink {
 public:
  void Open(const SessionRequest& request, UplinkListener* listener) override {
    listener_ = listener;
    SessionGrant grant;
    grant.capabilities.points_follow = true;
    for (const LocalMapId& id : request.local_maps) grant.acknowledged.push_back({id, LastOf(id)});
    listener_->OnSessionOpened(grant);
  }
  bool Send(const MapUpdateBatch& batch) override {
    uploads_.push_back(batch);
    listener_->OnAcknowledged({batch.local_map, batch.number});
    return true;
  }
  bool SendLocalised(const LocalisedFrames& /*localised*/) override { return false; }
  bool SendPicture(const KeyframePicture& /*picture*/) override { return false; }
  bool SendReport(const AgentReport& /*report*/) override { return false; }
  void Close() override { listener_ = nullptr; }
  uint64_t bytes_up() const override { return 0; }
  uint64_t bytes_down() const override { return 0; }

  RecordedUploads Take() { return std::move(uploads_); }

 private:
  uint64_t LastOf(LocalMapId id) const {
    uint64_t last = 0;
    for (const MapUpdateBatch& batch : uploads_) {
      if (batch.local_map == id) last = batch.number;
    }
    return last;
  }

  UplinkListener* listener_ = nullptr;
  RecordedUploads uploads_;
};

class Renamer {
 public:
  Renamer(LocalMapId from, LocalMapId to) : from_(from), to_(to) {}

  template <typename Id>
  void operator()(Id& id) const {
    if (id.local_map == from_) id.local_map = to_;
  }
  void operator()(FullKeyframe& keyframe) const {
    auto payload = std::make_shared<KeyframePayload>(*keyframe.payload);
    (*this)(payload->id);
    keyframe.payload = std::move(payload);
    (*this)(keyframe.parent);
  }
  void operator()(LightKeyframe& keyframe) const {
    (*this)(keyframe.id);
    (*this)(keyframe.parent);
  }
  void operator()(FullMapPoint& point) const {
    (*this)(point.id);
    (*this)(point.reference);
  }
  void operator()(LightMapPoint& point) const { (*this)(point.id); }
  void operator()(PointReplacement& replacement) const {
    (*this)(replacement.replaced);
    (*this)(replacement.survivor);
  }
  void operator()(ObservationChange& change) const {
    (*this)(change.point);
    (*this)(change.keyframe);
  }
  void operator()(KeyframeRemoval& removal) const {
    (*this)(removal.id);
    (*this)(removal.parent);
  }
  void operator()(LoopEdge& edge) const {
    (*this)(edge.a);
    (*this)(edge.b);
  }
  void operator()(TrackedFrame& frame) const { (*this)(frame.reference); }
  template <typename Item>
  void operator()(std::vector<Item>& items) const {
    for (Item& item : items) (*this)(item);
  }

 private:
  const LocalMapId from_;
  const LocalMapId to_;
};

}  // namespace

absl::StatusOr<RecordedUploads> RecordUploads(const std::string& source,
                                              std::shared_ptr<const Vocabulary> vocabulary,
                                              const FeatureSelection& features) {
  ASSIGN_OR_RETURN(const SourceSpec spec, ParseSourceSpec(source));
  ASSIGN_OR_RETURN(const std::unique_ptr<RecordedSequence> images, OpenSource(spec));
  AgentOptions options;
  options.deterministic = true;
  options.upload_features = features;
  const bool is_stereo = KindOf(images->calibration()) == SensorKind::kStereo;
  options.sensor.orb.features = is_stereo ? kStereoFeatures : kRgbdFeatures;
  RecordingUplink uplink;
  ASSIGN_OR_RETURN(const std::unique_ptr<Agent> agent,
                   Agent::Create(options, images->calibration(), std::move(vocabulary), &uplink));
  while (true) {
    ASSIGN_OR_RETURN(const std::optional<SensorImages> next, images->NextImages());
    if (!next.has_value()) break;
    RETURN_IF_ERROR(agent->Track(*next).status());
  }
  RETURN_IF_ERROR(agent->Finish(absl::Minutes(5)));
  if (agent->GetStatus().local_maps != 1) {
    return absl::FailedPreconditionError(
        absl::StrCat(source, " makes ", agent->GetStatus().local_maps, " local maps, not one"));
  }
  return uplink.Take();
}

MapUpdateBatch AsLocalMap(const MapUpdateBatch& batch, LocalMapId local_map) {
  MapUpdateBatch renamed = batch;
  const Renamer rename(batch.local_map, local_map);
  renamed.local_map = local_map;
  rename(renamed.full_keyframes);
  rename(renamed.full_points);
  rename(renamed.light_keyframes);
  rename(renamed.light_points);
  rename(renamed.replacements);
  rename(renamed.observations);
  rename(renamed.removed_points);
  rename(renamed.removed_keyframes);
  rename(renamed.loop_edges);
  rename(renamed.tracked_frames);
  return renamed;
}

}  // namespace corbslam::tests
