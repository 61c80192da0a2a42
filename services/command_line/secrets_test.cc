#include "services/command_line/secrets.h"

#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

TEST(SecretsTest, PasswordsAreHiddenAndTheRestStays) {
  EXPECT_EQ(HideSecrets("gst:rtspsrc location=rtsp://eve:pa55@robot/left ! decodebin"),
            "gst:rtspsrc location=rtsp://eve:***@robot/left ! decodebin");
  EXPECT_EQ(HideSecrets("source=\"rtsp://eve:p@55@robot:554/left\""),
            "source=\"rtsp://eve:***@robot:554/left\"");
  EXPECT_EQ(HideSecrets("gst:rtspsrc user-id=eve user-pw=pa55 ! decodebin"),
            "gst:rtspsrc user-id=eve user-pw=*** ! decodebin");
  EXPECT_EQ(HideSecrets("http://camera/?user=eve&Password=pa55&size=3"),
            "http://camera/?user=eve&Password=***&size=3");
}

TEST(SecretsTest, AVeryLongTextIsNotSearched) {
  EXPECT_EQ(HideSecrets(std::string(5000, 'x')), "*** (5000 characters)");
}

TEST(SecretsTest, WhatIsNoSecretStays) {
  for (const char* text :
       {"rtsp://robot:554/left", "token-key=\"/etc/corbslam/token.pub\"", "listen=\"[::1]:50051\"",
        "euroc:/data/a:b@c", "http://host:80/a@b", ""}) {
    EXPECT_EQ(HideSecrets(text), text);
  }
}

}  // namespace
}  // namespace corbslam::services
