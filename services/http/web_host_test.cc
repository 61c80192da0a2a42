#include "services/http/web_host.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

TEST(WebHostTest, AddressesAndLocalhostAreNobodyElses) {
  for (const char* host :
       {"", "127.0.0.1", "127.0.0.1:8080", "192.168.7.9:8443", "[::1]", "[::1]:8080", "[fe80::1]",
        "localhost", "LocalHost:8080", "localhost.", "lab.localhost:80"}) {
    EXPECT_TRUE(IsOwnHost(host, {})) << host;
  }
}

TEST(WebHostTest, OtherNamesMayLeadHereByRebinding) {
  for (const char* host :
       {"evil.example", "evil.example:8080", "127.0.0.1.evil.example", "localhost.evil.example",
        "notlocalhost", "evillocalhost:80", "127.0.0.1:80@evil.example", "127.0.0.1:x", "[::1",
        "[evil.example]:80", "[::1]evil.example", "[::1]:8080x", "1.2.3", "0x7f000001", ".", " "}) {
    EXPECT_FALSE(IsOwnHost(host, {})) << host;
  }
}

TEST(WebHostTest, TakesTheNamesThatItWasGiven) {
  const std::vector<std::string> names = {"viewer.lan", "robot-pc"};
  for (const char* host :
       {"viewer.lan", "Viewer.LAN:8080", "viewer.lan.", "robot-pc:1", "[::1]:8080"}) {
    EXPECT_TRUE(IsOwnHost(host, names)) << host;
  }
  for (const char* host : {"x.viewer.lan", "viewer.lan.evil.example", "viewer", "evil.example"}) {
    EXPECT_FALSE(IsOwnHost(host, names)) << host;
  }
  EXPECT_TRUE(IsOwnHost("evil.example:80", {kEveryHost}));
}

TEST(WebHostTest, SaysWhatANameMustBe) {
  for (const char* name : {"viewer.lan", "robot_pc", "*"}) {
    EXPECT_TRUE(CheckHostName("--web-host", name).ok()) << name;
  }
  for (const char* name : {"", "viewer.lan:8080", "http://viewer.lan", "a b", "*.lan"}) {
    EXPECT_THAT(CheckHostName("--web-host", name).message(), HasSubstr("--web-host is \"")) << name;
  }
}

}  // namespace
}  // namespace corbslam::services
