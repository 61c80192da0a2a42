#include "services/tool/mission/picture_search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/convert/geometry.h"

namespace corbslam::services {
namespace {

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
  FoundPicture found{.path = "a.png", .seconds = 0.25, .answer = {}};
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
  const nlohmann::json json = ToJson(found);
  EXPECT_TRUE(json["located"]);
  EXPECT_NEAR(json["position_m"][1].get<double>(), 2, 1e-12);
  EXPECT_NEAR(json["forward"][0].get<double>(), 1, 1e-12);
}

TEST(PictureSearchTest, SaysWhyNobodyKnows) {
  FoundPicture found{.path = "a.png", .seconds = 0, .answer = {}};
  for (int stage = v1::LOCATE_STAGE_FEW_FEATURES; stage < v1::LOCATE_STAGE_LOCATED; ++stage) {
    found.answer.set_stage(static_cast<v1::LocateStage>(stage));
    EXPECT_THAT(DescribeFound(found), HasSubstr("a.png: not found: "));
    EXPECT_GT(DescribeFound(found).size(), 30u) << stage;
    EXPECT_FALSE(ToJson(found)["located"]);
    EXPECT_FALSE(ToJson(found).contains("position_m"));
  }
}

}  // namespace
}  // namespace corbslam::services
