// What the converter doesn't guess.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <variant>

#include "absl/strings/str_replace.h"
#include "client_agent/source/rig/convert/convert_test_files.h"
#include "client_agent/source/rig/convert/rig_convert.h"

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

TEST(RigConvertRefusalsTest, ABaselineInMillimetresIsRefused) {
  RigFiles files = {
      .paths = {WriteText("intrinsics.yml", kOpenCv),
                WriteText("extrinsics.yml", absl::StrReplaceAll(kOpenCvPair, {{"-0.083", "-83"}}))},
      .format = "",
      .size = PictureSize{640, 480},
      .trust = false};
  EXPECT_THAT(std::string(ConvertRig(files).status().message()), HasSubstr("is it in metres?"));
}

TEST(RigConvertRefusalsTest, OpenCvsFourNumbersNeedTheirLens) {
  const std::string four =
      absl::StrReplaceAll(kOpenCv, {{"0.24, 0., 0., 0.01, 0., 0., 0., 0., 0., 0. ]", "]"},
                                    {"-0.28, 0.08, 0., 0., 0. ]", "-0.28, 0.08, 0.01, 0.002 ]"}});
  RigFiles files = OpenCvFiles(absl::StrReplaceAll(four, {{"0., 0., ]", "0., 0. ]"}}), kOpenCvPair);
  EXPECT_THAT(std::string(ConvertRig(files).status().message()),
              HasSubstr("D1 has 4 numbers: of cv::fisheye"));
  files.lens = "equidistant";
  auto converted = ConvertRig(files);
  ASSERT_TRUE(converted.ok()) << converted.status();
  EXPECT_EQ(std::get<Equidistant>(converted->rig.cameras[1].raw.lens).k4, 0.002);
  files.lens = "radial-tangential";
  converted = ConvertRig(files);
  ASSERT_TRUE(converted.ok()) << converted.status();
  EXPECT_EQ(std::get<RadialTangential>(converted->rig.cameras[1].raw.lens).p2, 0.002);
  files.lens = "wide";
  EXPECT_THAT(std::string(ConvertRig(files).status().message()), HasSubstr("--lens is 'wide'"));
  RigFiles kalibr = One("camchain.yaml", kKalibr);
  kalibr.lens = "equidistant";
  EXPECT_THAT(std::string(ConvertRig(kalibr).status().message()),
              HasSubstr("--lens is of OpenCV's files"));
}

TEST(RigConvertRefusalsTest, OpenCvsFilesMustAgree) {
  const std::string m1 =
      "M1: {rows: 3, cols: 3, dt: d, data: [530, 0, 341, 0, 531, 230, 0, 0, 1]}\n";
  EXPECT_THAT(std::string(ConvertRig(OpenCvFiles(kOpenCv, kOpenCvPair + m1)).status().message()),
              HasSubstr("M1 differs in"));
  const std::string skewed = absl::StrReplaceAll(kOpenCv, {{"530., 0.,", "530., 0.6,"}});
  EXPECT_THAT(std::string(ConvertRig(OpenCvFiles(skewed, kOpenCvPair)).status().message()),
              HasSubstr("M1 has a skew of 0.6 px"));
  const std::string turned = absl::StrReplaceAll(kOpenCvPair, {{"-0.083", "0.083"}});
  EXPECT_THAT(std::string(ConvertRig(OpenCvFiles(kOpenCv, turned)).status().message()),
              HasSubstr("exchanged, or is the motion inverted?"));
}

TEST(RigConvertRefusalsTest, SaysWhatItCannotKnowOfOrbSlam) {
  const std::string old = absl::StrReplaceAll(
      kOrb2Rgbd, {{"DepthMapFactor: 5000.0", "Camera.type: KannalaBrandt8\nTlr: [1, 0]"}});
  EXPECT_THAT(std::string(ConvertRig(One("old.yaml", old)).status().message()),
              HasSubstr("Tlr is of ORB-SLAM3's older settings, whose format is not known"));
  const auto smaller = ConvertRig(One("new.yaml", std::string(kOrb3) + "Camera.newWidth: 256\n"));
  ASSERT_TRUE(smaller.ok()) << smaller.status();
  EXPECT_THAT(smaller->notes[0], HasSubstr("Camera.newWidth is left out"));
  const std::string cut = absl::StrReplaceAll(kOrb3, {{"Camera.width: 512", "Camera.width: 1e12"}});
  EXPECT_THAT(std::string(ConvertRig(One("cut.yaml", cut)).status().message()),
              HasSubstr("must be a whole number"));
}

TEST(RigConvertRefusalsTest, OffersTrustAsTheConvertersFlag) {
  const auto says = [](const char* to) {
    const std::string text = absl::StrReplaceAll(kKalibr, {{"254.9", to}});
    return std::string(ConvertRig(One("camchain.yaml", text)).status().message());
  };
  EXPECT_THAT(says("25.4"), HasSubstr("If it is right, say --trust-calibration"));
  const std::string negative = absl::StrReplaceAll(kKalibr, {{"[190.9,", "[-190.9,"}});
  EXPECT_THAT(std::string(ConvertRig(One("camchain.yaml", negative)).status().message()),
              ::testing::Not(HasSubstr("trust")));
}

TEST(RigConvertRefusalsTest, SaysWhatIsWrong) {
  const struct {
    std::string from, to, says;
  } cases[] = {{"camera_model: ds", "camera_model: eucm", "cam1.camera_model is 'eucm'"},
               {"cam0:", "other:", "holds no calibration of a known format"},
               {"T_cn_cnm1", "T_other", "cam1.T_cn_cnm1 is no list of 16"},
               {"equidistant", "fov", "cam0.distortion_model: a lens that is 'fov'"},
               {"[512, 512]", "[512]", "cam0.resolution is no list of 2"},
               {"254.9", "25.4", "can't be"},
               {"-0.101", "0.101", "left and right exchanged, or is the motion inverted?"},
               {"-0.101", "-101", "the cameras are 101 m apart"},
               {"  distortion_model: equidistant\n", "", "cam0.distortion_model is missing, and"},
               {"distortion_model: equidistant", "distortion_model: none", "is none, and"},
               {"  timeshift_cam_imu: 0.0\n", "", "is of one of cam0 and cam1 alone"},
               {"shift_cam_imu: 0.004", "shift_cam_imu: .nan", "cam0.timeshift_cam_imu is no"},
               {"[512, 512]", "[512.9, 512]", "is 512.9, must be a whole number"},
               {"[512, 512]", "[1e12, 512]", "is 1e+12, must be a whole number"},
               {"  camera_model: ds", "  resolution: [1, 1]\n  camera_model: ds",
                "resolution is there twice"},
               {"[190.9,", "[-190.9,", "can't be: must be finite and above 0"}};
  for (const auto& [from, to, says] : cases) {
    const std::string text = absl::StrReplaceAll(kKalibr, {{from, to}});
    const absl::Status status = ConvertRig(One("camchain.yaml", text)).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << to << ": " << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(says));
    EXPECT_THAT(std::string(status.message()), HasSubstr("camchain.yaml"));
  }
  EXPECT_THAT(std::string(ConvertRig(One("other.yaml", "a: 1\n")).status().message()),
              HasSubstr("no calibration of a known format (kalibr, ros"));
  RigFiles unknown = One("other.yaml", "a: 1\n");
  unknown.format = "matlab";
  EXPECT_THAT(std::string(ConvertRig(unknown).status().message()),
              HasSubstr("format 'matlab', known are kalibr"));
  EXPECT_THAT(std::string(ConvertRig(One("rig.yaml", "rig: 1\n")).status().message()),
              HasSubstr("is a rig file already"));
  EXPECT_TRUE(absl::IsNotFound(
      ConvertRig({.paths = {"/nowhere.yaml"}, .format = "", .size = {}, .trust = false}).status()));
}

}  // namespace
}  // namespace corbslam::client_agent
