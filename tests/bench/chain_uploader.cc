#include "tests/bench/chain_uploader.h"

#include <random>
#include <utility>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "slam/util/status_macros.h"

namespace corbslam::tests {

using map_store::MapStore;

namespace {

constexpr int kFeatureSets = 8;
constexpr int kAttempts = 600;
constexpr absl::Duration kBetweenAttempts = absl::Milliseconds(100);

Features MakeFeatures(size_t count, std::mt19937& random) {
  Features features;
  features.keypoints.resize(count);
  features.descriptors.resize(count);
  for (Keypoint& keypoint : features.keypoints) {
    keypoint.x_px = static_cast<float>(random() % 640000) / 1000;
    keypoint.y_px = static_cast<float>(random() % 480000) / 1000;
  }
  for (Descriptor& descriptor : features.descriptors) {
    for (uint64_t& word : descriptor.words) word = (uint64_t{random()} << 32) | random();
  }
  return features;
}

}  // namespace

ChainUploader::ChainUploader(MapStore& store, std::string mission, size_t features)
    : store_(store),
      mission_(std::move(mission)),
      camera_(std::make_shared<const Camera>(Camera{.fx_px = 500,
                                                    .fy_px = 500,
                                                    .cx_px = 320,
                                                    .cy_px = 240,
                                                    .width_px = 640,
                                                    .height_px = 480})) {
  std::mt19937 random(1);
  for (int i = 0; i < kFeatureSets; ++i) features_.push_back(MakeFeatures(features, random));
}

absl::Status ChainUploader::Open() {
  SessionRequest request;
  request.mission = mission_;
  request.agent = "robot";
  ASSIGN_OR_RETURN(const MapStore::OpenedSession opened, store_.OpenSession(request));
  session_ = opened.session_id;
  return absl::OkStatus();
}

void ChainUploader::Close() {
  if (session_ != 0) store_.CloseSession(std::exchange(session_, 0));
}

std::shared_ptr<const KeyframePayload> ChainUploader::MakePayload(uint32_t index) {
  return MakeKeyframePayload({kLocalMap, index}, int64_t{index} * 100'000'000, 0, camera_,
                             features_[index % features_.size()]);
}

absl::Status ChainUploader::Upload(uint32_t keyframes) {
  MapUpdateBatch batch;
  batch.local_map = kLocalMap;
  batch.number = ++number_;
  if (next_ == 0) batch.cameras = {camera_};
  for (uint32_t i = 0; i < keyframes; ++i, ++next_) {
    const KeyframeId parent = next_ == 0 ? KeyframeId() : KeyframeId{kLocalMap, next_ - 1};
    batch.full_keyframes.push_back({MakePayload(next_), Rigid3d::Identity(), parent});
  }
  absl::Status applied;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    applied = store_.Apply(session_, batch).status();
    if (!absl::IsResourceExhausted(applied)) break;
    absl::SleepFor(kBetweenAttempts);
  }
  return applied;
}

}  // namespace corbslam::tests
