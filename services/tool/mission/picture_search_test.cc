#include "services/tool/mission/picture_search.h"

#include <gmock/gmock.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "services/convert/geometry.h"

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(PictureSearchTest, ReadsNumbers) {
  const auto camera = ParseCamera("718.8 718.9, 607.2,185.2");
  ASSERT_TRUE(camera.ok()) << camera.status();
  EXPECT_EQ(camera->fy_px, 718.9);
  EXPECT_EQ(camera->cx_px, 607.2);
  EXPECT_EQ(ParsePlace("1 -2 3.5")->y(), -2);
  EXPECT_THAT(std::string(ParseCamera("1 2 3").status().message()), HasSubstr("must have 4"));
  EXPECT_THAT(std::string(ParsePlace("1 two 3").status().message()), HasSubstr("\"two\""));
  EXPECT_FALSE(ParsePlace("1 2 nan").ok());
}

TEST(PictureSearchTest, SaysWhereAPictureWasTaken) {
  FoundPicture found{.path = "a.png", .seconds = 0.25, .odd_centre = "", .answer = {}};
  found.answer.set_stage(v1::LOCATE_STAGE_LOCATED);
  found.answer.set_inliers(93);
  found.answer.set_in_global_frame(true);
  // A camera at (1, 2, 3) that looks along +x.
  const Eigen::Matrix3d rotation = (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0)
                                       .finished();  // Columns: right, down, ahead.
  ToProto(Rigid3d{Eigen::Quaterniond(rotation), {1, 2, 3}}.Inverse(),
          found.answer.mutable_camera_from_island());
  EXPECT_EQ(DescribeFound(found),
            "a.png: at 1.000 2.000 3.000 m, looks along 1.000 0.000 0.000, 93 points agree, "
            "global frame, 250 ms\n");
  for (int i = 0; i < 36; ++i) found.answer.add_covariance(i % 7 == 0 ? 0.0003 : 0);
  EXPECT_THAT(DescribeFound(found), HasSubstr("at 1.000 2.000 3.000 m (sigma 0.030 m), looks"));
  const nlohmann::json json = ToJson(found);
  EXPECT_TRUE(json["located"]);
  EXPECT_NEAR(json["position_m"][1].get<double>(), 2, 1e-12);
  EXPECT_NEAR(json["forward"][0].get<double>(), 1, 1e-12);
}

TEST(PictureSearchTest, SaysWhyNobodyKnows) {
  FoundPicture found{.path = "a.png", .seconds = 0, .odd_centre = "", .answer = {}};
  for (int stage = v1::LOCATE_STAGE_FEW_FEATURES; stage <= v1::LOCATE_STAGE_CAMERA_IN_DOUBT;
       ++stage) {
    if (stage == v1::LOCATE_STAGE_LOCATED) continue;
    found.answer.set_stage(static_cast<v1::LocateStage>(stage));
    EXPECT_THAT(DescribeFound(found), HasSubstr("a.png: not found: "));
    EXPECT_GT(DescribeFound(found).size(), 30u) << stage;
    EXPECT_FALSE(ToJson(found)["located"]);
    EXPECT_FALSE(ToJson(found).contains("position_m"));
  }
}

// The numbers are those of the rule that refused, and not others.
TEST(PictureSearchTest, SaysWhichRuleRefused) {
  FoundPicture found{.path = "a.png", .seconds = 0, .odd_centre = "", .answer = {}};
  found.answer.set_stage(v1::LOCATE_STAGE_FEW_INLIERS);
  found.answer.set_inliers(104);
  EXPECT_THAT(DescribeFound(found), HasSubstr("only 104 points of the map are where they should"))
      << "an older store says no more";
  found.answer.set_inliers_needed(108);
  found.answer.set_visible_points(500);
  found.answer.set_chance_inliers(27);
  EXPECT_THAT(
      DescribeFound(found),
      HasSubstr("only 104 points of the map are where they should be, of 500 that should be "
                "in the picture; 108 are needed where chance alone finds 27"));
  EXPECT_EQ(ToJson(found)["inliers_needed"], 108);
  EXPECT_EQ(ToJson(found)["visible_points"], 500);
  EXPECT_EQ(ToJson(found)["chance_inliers"], 27);
  found.odd_centre = "the camera's centre, 607.2 185.2, is far from the middle";
  EXPECT_THAT(DescribeFound(found), HasSubstr("finds 27 (the camera's centre, 607.2 185.2"));
}

// The sizes are compared before anybody is asked: there is no store here.
TEST(PictureSearchTest, APictureOfAnotherSizeThanTheRigIsRefused) {
  PictureSearch search;
  search.mission = "m";
  search.pictures = {::testing::TempDir() + "/half.png"};
  search.width_px = 1241;
  search.height_px = 376;
  search.calibration = "rig.yaml";
  std::vector<uint8_t> bytes;
  ASSERT_TRUE(cv::imencode(".png", cv::Mat(188, 620, CV_8UC1, cv::Scalar(90)), bytes));
  std::ofstream(search.pictures[0], std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  const auto channel =
      grpc::CreateChannel("unix:/nowhere/at.all", grpc::InsecureChannelCredentials());
  const absl::Status refused = FindPictures(channel, search).status();
  EXPECT_EQ(refused.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(refused.message()), AllOf(HasSubstr("half.png has 620x188 pixels"),
                                                    HasSubstr("rig.yaml"), HasSubstr("1241x376")));
}

}  // namespace
}  // namespace corbslam::services
