#include "services/convert/status.h"

#include <gtest/gtest.h>

#include "corbslam/v1/fleet.pb.h"
#include "slam/exchange/mission_elsewhere.h"

namespace corbslam::services {
namespace {

TEST(StatusTest, WhereAMissionIsCrossesTheWire) {
  const absl::Status said = WithElsewhere(absl::UnavailableError("m is at b"), "b:2");
  const grpc::Status sent = ToGrpcStatus(said);
  EXPECT_EQ(sent.error_code(), grpc::StatusCode::UNAVAILABLE);
  const absl::Status heard = FromGrpcStatus(sent);
  EXPECT_EQ(heard, said);
  EXPECT_EQ(FindElsewhere(heard)->address, "b:2");
  // Others read the same bytes as google.rpc.Status.
  v1::StatusDetails details;
  ASSERT_TRUE(details.ParseFromString(sent.error_details()));
  EXPECT_EQ(details.code(), 14);
  EXPECT_EQ(details.message(), "m is at b");
  EXPECT_EQ(details.details(0).type_url(), "type.googleapis.com/corbslam.v1.MissionElsewhere");
}

TEST(StatusTest, OtherErrorsSayNothingOfIt) {
  const absl::Status plain = absl::NotFoundError("there is no mission m");
  EXPECT_EQ(ToGrpcStatus(plain).error_details(), "");
  EXPECT_FALSE(FindElsewhere(FromGrpcStatus(ToGrpcStatus(plain))).has_value());
  const grpc::Status strange(grpc::StatusCode::UNAVAILABLE, "text", "no message at all");
  EXPECT_FALSE(FindElsewhere(FromGrpcStatus(strange)).has_value());
  EXPECT_TRUE(ToGrpcStatus(absl::OkStatus()).ok());
}

}  // namespace
}  // namespace corbslam::services
