// Feeds what comes down to a robot: SyncResponses, through conversion, into the robot's map.
#include <memory>

#include "client_agent/shared/shared_map.h"
#include "corbslam/v1/map_store_service.pb.h"
#include "services/convert/shared_update.h"
#include "tests/fuzz/messages.h"

namespace corbslam::tests {

using client_agent::ArrivedUpdate;
using client_agent::OwnCorrection;
using client_agent::SharedMap;
using services::CameraBook;
using services::FromProto;
using services::SharedUpdateAssembler;

namespace {

constexpr LocalMapId kOwn{1};

// Makes two keyframes that see two points.
Map MakeOwnMap() {
  Map map;
  const auto camera = std::make_shared<const Camera>(Camera{500, 500, 320, 240, 640, 480, 0.1, 4});
  for (uint32_t k = 0; k < 2; ++k) {
    Features features;
    features.keypoints.resize(4);
    features.descriptors.resize(4);
    Keyframe keyframe;
    keyframe.payload = MakeKeyframePayload({kOwn, k}, k, 0, camera, std::move(features));
    map.AddKeyframe(std::move(keyframe));
  }
  for (uint32_t p = 0; p < 2; ++p) {
    MapPoint point;
    point.id = {kOwn, p};
    point.position_in_map = {0, 0, 5};
    point.reference = {kOwn, 0};
    map.AddPoint(std::move(point));
    for (uint32_t k = 0; k < 2; ++k) map.AddObservation({kOwn, p}, {kOwn, k}, p);
  }
  return map;
}

}  // namespace
}  // namespace corbslam::tests

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace corbslam;         // NOLINT
  using namespace corbslam::tests;  // NOLINT
  absl::string_view input = AsText(data, size);
  Map map = MakeOwnMap();
  SharedMap shared(kOwn);
  CameraBook cameras;
  SharedUpdateAssembler assembler;
  while (!input.empty()) {
    const absl::string_view message = TakeMessage(input);
    v1::SyncResponse response;
    if (!response.ParseFromArray(message.data(), static_cast<int>(message.size()))) continue;
    if (response.has_grant()) (void)FromProto(response.grant());
    if (response.has_acknowledgement()) (void)FromProto(response.acknowledgement());
    if (!response.has_shared()) continue;
    auto update = assembler.Add(response.shared(), cameras);
    // The session ends, and so does what it knew.
    if (!update.ok()) return 0;
    if (!update->has_value()) continue;
    ArrivedUpdate arrived;
    arrived.words.resize((*update)->keyframes.size(), std::make_shared<const Words>());
    arrived.update = *std::move(*update);
    shared.Apply(arrived);
    shared.Place(shared.Plan(map), map);
    (void)shared.GlobalFromLocal();
    OwnCorrection correction;
    const Rigid3d& camera_from_map = map.FindKeyframe({kOwn, 0})->camera_from_map;
    correction.motions[{kOwn, 0}] = {camera_from_map, camera_from_map};
    shared.Correct(correction, map);
  }
  return 0;
}
