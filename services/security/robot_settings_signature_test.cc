#include "services/security/robot_settings_signature.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "services/security/testing/token_keys.h"

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

class RobotSettingsSignatureTest : public ::testing::Test {
 protected:
  static v1::RobotSettings Settings() {
    v1::RobotSettings settings;
    settings.set_mission("missions/lab");
    settings.set_agent("alpha");
    settings.set_version(7);
    settings.set_features(1500);
    settings.set_max_frame_rate_hz(10);
    settings.set_share("nearby");
    settings.set_share_radius_m(30);
    return settings;
  }
  std::vector<Ed25519Key> Trusted() const {
    return *ReadEd25519PublicKeys("settings key", keys_.public_pem);
  }

  const test_data::TokenKeys keys_ = test_data::MakeTokenKeys();
};

TEST_F(RobotSettingsSignatureTest, WhatWasSignedComesBack) {
  const auto made = SignRobotSettings(Settings(), keys_.private_pem);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_EQ(made->signature().size(), 64u);
  const auto read = VerifyRobotSettings(*made, Trusted());
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->SerializeAsString(), Settings().SerializeAsString());
  EXPECT_FALSE(read->has_uplink_kbps());
}

TEST_F(RobotSettingsSignatureTest, WhatSomebodyElseSignedOrChangedIsRefused) {
  const auto others = SignRobotSettings(Settings(), test_data::MakeTokenKeys().private_pem);
  EXPECT_TRUE(absl::IsPermissionDenied(VerifyRobotSettings(*others, Trusted()).status()));
  v1::SignedRobotSettings made = *SignRobotSettings(Settings(), keys_.private_pem);
  EXPECT_TRUE(absl::IsPermissionDenied(VerifyRobotSettings(made, {}).status()));
  made.mutable_signature()->back() ^= 1;
  EXPECT_TRUE(absl::IsPermissionDenied(VerifyRobotSettings(made, Trusted()).status()));
  made.mutable_signature()->back() ^= 1;
  v1::RobotSettings changed = Settings();
  changed.set_version(8);
  made.set_settings(changed.SerializeAsString());
  EXPECT_TRUE(absl::IsPermissionDenied(VerifyRobotSettings(made, Trusted()).status()));
}

// A signature of the bytes alone, as of a token, is none of settings.
TEST_F(RobotSettingsSignatureTest, ASignatureForAnotherPurposeIsRefused) {
  v1::SignedRobotSettings made;
  made.set_settings(Settings().SerializeAsString());
  made.set_signature(*SignBytes(made.settings(), *ReadEd25519PrivateKey(keys_.private_pem)));
  EXPECT_TRUE(absl::IsPermissionDenied(VerifyRobotSettings(made, Trusted()).status()));
}

TEST_F(RobotSettingsSignatureTest, WhatIsOutOfBoundsIsNeverSigned) {
  std::vector<std::pair<v1::RobotSettings, std::string>> wrong(7, {Settings(), ""});
  wrong[0].first.set_version(0), wrong[0].second = "version is 0";
  wrong[1].first.set_features(20'001), wrong[1].second = "features is 20001";
  wrong[2].first.set_max_frame_rate_hz(0.01), wrong[2].second = "max_frame_rate_hz is 0.01";
  wrong[3].first.set_share("all"), wrong[3].second = "share is all";
  wrong[4].first.set_share_radius_m(0.5), wrong[4].second = "share_radius_m is 0.5";
  wrong[5].first.set_uplink_kbps(7), wrong[5].second = "uplink_kbps is 7";
  wrong[6].first.set_upload_features("none"), wrong[6].second = "upload_features is none";
  for (const auto& [settings, says] : wrong) {
    const auto made = SignRobotSettings(settings, keys_.private_pem);
    EXPECT_TRUE(absl::IsInvalidArgument(made.status())) << says;
    EXPECT_THAT(std::string(made.status().message()), HasSubstr(says));
  }
  v1::RobotSettings large = Settings();
  large.set_mask_png(std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\2\0\0\0\1\10\0\0\0\0", 29) +
                     std::string(65'536, 'x') +
                     std::string("\0\0\0\0\0\0\0\0IEND\xae\x42\x60\x82", 16));
  EXPECT_THAT(std::string(SignRobotSettings(large, keys_.private_pem).status().message()),
              HasSubstr("at most 65536"));
}

}  // namespace
}  // namespace corbslam::services
