#include "services/convert/work/locate_frame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "services/convert/testing/test_data.h"
#include "services/convert/work/work.h"

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

// Sends it over the wire and reads it again.
template <typename Message, typename Reader, typename ChunkMessage, typename Work>
auto Travel(const Work& work) {
  WorkReader<Reader, ChunkMessage> reader;
  absl::Status status;
  WriteWork<Message>(work, std::function<bool(Message)>([&](const Message& message) {
                       status = reader.Add(message);
                       return status.ok();
                     }));
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_TRUE(reader.ended());
  return reader.Finish();
}

v1::Camera SomeCamera() {
  v1::Camera camera;
  camera.set_fx_px(300);
  camera.set_fy_px(310);
  camera.set_cx_px(160);
  camera.set_cy_px(120);
  camera.set_width_px(320);
  camera.set_height_px(240);
  return camera;
}

v1::Features SomeFeatures(int keypoints) {
  v1::Features features;
  for (int i = 0; i < keypoints; ++i) {
    features.add_x_px64(64 * i);
    features.add_y_px64(32 * i);
    features.add_angle_turn14(static_cast<uint32_t>(i));
    features.mutable_octaves()->push_back('\1');
    features.mutable_descriptors()->append(32, static_cast<char>(i));
    features.add_nodes_plus_one(static_cast<uint32_t>(i % 3));
  }
  return features;
}

TEST(LocateFrameTest, AResultTravels) {
  LocateFrameResult result;
  result.base_revision = 5;
  result.stage = LocateStage::kLocated;
  result.word_matches = 40;
  result.pose_inliers = 33;
  result.inliers = 90;
  result.inliers_needed = 44;
  result.visible_points = 320;
  result.chance_inliers = 11;
  result.camera_from_map.translation = {1, 2, 3};
  result.covariance = Matrix6d::Identity() * 0.01;
  result.keyframes = {{{0xa}, 3}, {{0xb}, 1}};
  const auto read =
      Travel<v1::LocateFrameResponse, ResultReader<v1::LocateFrameResponse>, v1::ResultChunk>(
          result);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->base_revision, 5u);
  EXPECT_EQ(read->stage, LocateStage::kLocated);
  EXPECT_EQ(read->word_matches, 40);
  EXPECT_EQ(read->pose_inliers, 33);
  EXPECT_EQ(read->inliers, 90);
  EXPECT_EQ(read->inliers_needed, 44);
  EXPECT_EQ(read->visible_points, 320);
  EXPECT_EQ(read->chance_inliers, 11);
  EXPECT_EQ(read->camera_from_map.translation, result.camera_from_map.translation);
  EXPECT_EQ(*read->covariance, *result.covariance);
  EXPECT_EQ(read->keyframes, result.keyframes);
}

TEST(LocateFrameTest, ACameraThatFitsBetterTravels) {
  LocateFrameResult result;
  result.stage = LocateStage::kFewInliers;
  result.fitting_camera = Camera{
      .fx_px = 301, .fy_px = 302, .cx_px = 160, .cy_px = 120, .width_px = 320, .height_px = 240};
  const auto read = MakeResult(HeaderOf(result), ResultItems());
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->fitting_camera, result.fitting_camera);
}

TEST(LocateFrameTest, DisparitiesNeedABaseline) {
  v1::Features features = SomeFeatures(3);
  for (int i = 0; i < 3; ++i) features.add_disparity_px128(128);
  v1::Camera camera = SomeCamera();
  EXPECT_THAT(std::string(FrameFromProto(camera, features).status().message()),
              HasSubstr("camera.baseline_m is 0"));
  camera.set_baseline_m(0.1);
  EXPECT_TRUE(FrameFromProto(camera, features).ok());
}

TEST(LocateFrameTest, EachStageTravels) {
  for (const LocateStage stage :
       {LocateStage::kFewFeatures, LocateStage::kNoCandidates, LocateStage::kFewMatches,
        LocateStage::kNoPose, LocateStage::kFewInliers, LocateStage::kCameraInDoubt,
        LocateStage::kOutsidePrior}) {
    LocateFrameResult result;
    result.stage = stage;
    result.camera_from_map.translation = {1, 2, 3};  // Says nothing, and does not travel.
    const auto read = MakeResult(HeaderOf(result), ResultItems());
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(read->stage, stage);
    EXPECT_TRUE(read->camera_from_map.translation.isZero());
  }
  EXPECT_THAT(std::string(FromProto(v1::LOCATE_STAGE_UNSPECIFIED).status().message()),
              HasSubstr("stage is 0"));
  EXPECT_FALSE(FromProto(static_cast<v1::LocateStage>(9)).ok());
}

TEST(LocateFrameTest, APicturesFeaturesTravelWithTheirNodes) {
  const auto frame = FrameFromProto(SomeCamera(), SomeFeatures(7));
  ASSERT_TRUE(frame.ok()) << frame.status();
  LocateFrameRequest request;
  request.frame = *frame;
  request.candidates = {{{{0xa}, 3}, 17}};
  const v1::LocateFrameRequest::Header header = HeaderOf(request);
  EXPECT_EQ(header.features().x_px64_size(), 7);
  EXPECT_EQ(header.features().descriptors(), SomeFeatures(7).descriptors());
  LocateFrameRequestReader reader;
  ASSERT_TRUE(reader.AddHeader(header).ok());
  // The candidate's keyframe did not come.
  EXPECT_THAT(std::string(reader.Finish().status().message()), HasSubstr("not in the view"));
  const auto again = FrameFromProto(header.camera(), header.features());
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again->words->direct_index, frame->words->direct_index);
  EXPECT_EQ(again->camera(), frame->camera());
}

TEST(LocateFrameTest, NamesWhatIsWrongWithARequest) {
  LocateFrameRequestReader reader;
  v1::LocateFrameRequest::Header header;
  EXPECT_THAT(std::string(reader.AddHeader(header).message()), HasSubstr("camera: "));
  *header.mutable_camera() = SomeCamera();
  *header.mutable_features() = SomeFeatures(3);
  EXPECT_THAT(std::string(reader.AddHeader(header).message()),
              HasSubstr("number of candidates is 0"));
  header.mutable_features()->mutable_descriptors()->pop_back();
  EXPECT_THAT(std::string(reader.AddHeader(header).message()), HasSubstr("features: "));
  v1::MapChunk chunk;
  chunk.set_view(v1::MAP_VIEW_SECOND);
  EXPECT_THAT(std::string(reader.AddChunk(chunk).message()), HasSubstr("view is 2"));
}

TEST(LocateFrameTest, ReadsPictures) {
  v1::Picture picture;
  EXPECT_THAT(std::string(FromProto(picture).status().message()), HasSubstr("in bytes is 0"));
  picture.set_encoded("bytes");
  EXPECT_THAT(std::string(FromProto(picture).status().message()), HasSubstr("picture.camera: "));
  v1::RecordedCamera& camera = *picture.mutable_camera();
  camera.set_fx_px(300);
  camera.set_fy_px(310);
  camera.set_cx_px(160);
  camera.set_cy_px(120);
  for (const double k : {0.1, 0.2, 0.3, 0.4}) camera.add_distortion(k);
  camera.set_lens_model(v1::LENS_MODEL_EQUIDISTANT);
  const auto request = FromProto(picture);
  ASSERT_TRUE(request.ok()) << request.status();
  EXPECT_EQ(request->camera.fy_px, 310);
  EXPECT_EQ(std::get<Equidistant>(request->camera.lens).k2, 0.2);
  v1::Picture again;
  ToProto(*request, &again);
  EXPECT_EQ(again.SerializeAsString(), picture.SerializeAsString());
  camera.mutable_camera_from_recorded()->add_rotation_wxyz(1);
  EXPECT_THAT(std::string(FromProto(picture).status().message()),
              HasSubstr("camera_from_recorded is set"));
}

TEST(LocateFrameTest, RefusesACovarianceThatIsNone) {
  google::protobuf::RepeatedField<double> numbers;
  EXPECT_FALSE(PoseCovarianceFromProto(numbers)->has_value());
  numbers.Resize(35, 1);
  EXPECT_THAT(std::string(PoseCovarianceFromProto(numbers).status().message()),
              HasSubstr("covariance has 35 entries, must have 36"));
  numbers.Resize(36, std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(PoseCovarianceFromProto(numbers).ok());
}

}  // namespace
}  // namespace corbslam::services
