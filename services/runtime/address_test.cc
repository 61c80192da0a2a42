#include "services/runtime/address.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "slam/util/testing/case_name.h"

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

struct Case {
  const char* address;
  const char* says;
};

class WrongServerAddressTest : public ::testing::TestWithParam<Case> {};

TEST_P(WrongServerAddressTest, IsRefusedWithAWord) {
  const absl::Status status = ParseServerAddress(GetParam().address).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << GetParam().address;
  EXPECT_THAT(std::string(status.message()), HasSubstr(GetParam().says));
  EXPECT_THAT(std::string(status.message()), HasSubstr(GetParam().address));
}

INSTANTIATE_TEST_SUITE_P(
    Addresses, WrongServerAddressTest,
    ::testing::Values(
        Case{"", "is empty"}, Case{"127.0.0.1", "has no port; give HOST:PORT, as 127.0.0.1:50051"},
        Case{"store.lan", "has no port"}, Case{"store.lan:", "has no port behind its colon"},
        Case{"[::1]", "has no port"}, Case{"http://127.0.0.1:56299", "give 127.0.0.1:56299"},
        Case{"https://store.lan:50051/", "give store.lan:50051"},
        Case{"http://store.lan", "give store.lan:PORT"}, Case{"dns:///store.lan", "has no port"},
        Case{"grpc://store.lan:50051", "begins with grpc://"},
        Case{"dns://8.8.8.8/store.lan:50051", "begins with dns://"},
        Case{"unix:/run/store.sock", "Unix socket"},
        Case{"127.0.0.1:99999", "has port \"99999\", must be a number of 1 to 65535"},
        Case{"127.0.0.1:65536", "must be a number of 1 to 65535"},
        Case{"127.0.0.1:99999999999999999999", "must be a number"},
        Case{"127.0.0.1:-1", "has port \"-1\""}, Case{"127.0.0.1:+80", "has port \"+80\""},
        Case{"127.0.0.1:0", "listening on"}, Case{"127.0.0.1:000", "listening on"},
        Case{"store.lan:http", "has port \"http\""},
        Case{"store.lan:50051/v1", "has \"/v1\" behind the port"},
        Case{"::1:56299", "give [::1]:56299"}, Case{"fe80::1", "give [fe80::1]:PORT"},
        Case{"2001:db8::5:50051", "give [2001:db8::5]:50051"},
        Case{"fe80::1%eth0:50051", "without brackets"}, Case{"1:2:3", "more than one colon"},
        Case{"[store.lan]:50051", "between its brackets"}, Case{"[::1:50051", "has a bracket"},
        Case{":50051", "this machine 127.0.0.1:50051"}, Case{" 127.0.0.1:50051", "has a blank"},
        Case{"127.0.0.1:50051\n", "has a blank"}, Case{"127.0.0.1 50051", "has a blank"},
        Case{"a:1,b:2", "has a comma"}),
    testing::NamedBy(&Case::address));

struct GoodCase {
  const char* address;
  const char* host;
  int port;
};

class GoodServerAddressTest : public ::testing::TestWithParam<GoodCase> {};

TEST_P(GoodServerAddressTest, IsTakenApart) {
  const absl::StatusOr<HostPort> parsed = ParseServerAddress(GetParam().address);
  ASSERT_TRUE(parsed.ok()) << parsed.status();
  EXPECT_EQ(parsed->host, GetParam().host);
  EXPECT_EQ(parsed->port, GetParam().port);
}

INSTANTIATE_TEST_SUITE_P(Addresses, GoodServerAddressTest,
                         ::testing::Values(GoodCase{"127.0.0.1:50051", "127.0.0.1", 50051},
                                           GoodCase{"store.lan:1", "store.lan", 1},
                                           GoodCase{"store_1.lan.:65535", "store_1.lan.", 65535},
                                           GoodCase{"[::1]:50051", "::1", 50051},
                                           GoodCase{"[fe80::1%eth0]:50051", "fe80::1%eth0", 50051},
                                           GoodCase{"dns:///store.lan:50051", "store.lan", 50051},
                                           GoodCase{"dns:store.lan:50051", "store.lan", 50051},
                                           GoodCase{"dns:50051", "dns", 50051},
                                           GoodCase{"ipv4:10.0.0.5:50051", "10.0.0.5", 50051},
                                           GoodCase{"ipv6:[::1]:50051", "::1", 50051}),
                         testing::NamedBy(&GoodCase::address));

TEST(AddressTest, ServersMayLeaveOutTheHostAndLetThePortBeChosen) {
  EXPECT_EQ(ParseListenAddress("127.0.0.1:0")->port, 0);
  EXPECT_EQ(ParseListenAddress(":50051")->host, "");
  EXPECT_EQ(ParseListenAddress("[::]:0")->host, "::");
  for (const char* address : {"", "127.0.0.1", "http://0.0.0.0:50051", "0.0.0.0:70000", ":::50051",
                              "::1:50051", "127.0.0.1:x"}) {
    EXPECT_EQ(ParseListenAddress(address).status().code(), absl::StatusCode::kInvalidArgument)
        << address;
  }
}

TEST(AddressTest, IsWrittenAsItIsRead) {
  for (const char* address : {"127.0.0.1:50051", "store.lan:1", "[::1]:50051"}) {
    EXPECT_EQ(ToString(*ParseServerAddress(address)), address);
  }
}

}  // namespace
}  // namespace corbslam::services
