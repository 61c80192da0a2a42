// A map whose changes an UpdateRecorder records, for its tests.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_TESTING_RECORDED_MAP_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_TESTING_RECORDED_MAP_H_

#include <memory>

#include "client_agent/upload/update_recorder.h"
#include "gtest/gtest.h"

namespace corbslam::client_agent {

inline constexpr LocalMapId kOwn{1};
inline constexpr LocalMapId kForeign{2};
inline constexpr uint32_t kKeypoints = 30;

inline Keyframe MakeKeyframe(KeyframeId id, KeyframeId parent) {
  static const auto camera = std::make_shared<const Camera>(Camera{
      .fx_px = 500, .fy_px = 500, .cx_px = 320, .cy_px = 240, .width_px = 640, .height_px = 480});
  Features features;
  features.keypoints.resize(kKeypoints);
  features.descriptors.resize(kKeypoints);
  // By which they are known where some are left out.
  for (uint32_t i = 0; i < kKeypoints; ++i) features.keypoints[i].x_px = static_cast<float>(i);
  Keyframe keyframe;
  keyframe.payload = MakeKeyframePayload(id, id.index, 0, camera, features);
  keyframe.parent = parent;
  return keyframe;
}

class RecordedMapTest : public ::testing::Test {
 protected:
  RecordedMapTest() { map_.SetObserver(&recorder_); }

  static MapPoint Point(MapPointId id) {
    MapPoint point;
    point.id = id;
    return point;
  }

  UpdateRecorder recorder_{kOwn, RecorderOptions{.hold_newest = 0}};
  Map map_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_TESTING_RECORDED_MAP_H_
