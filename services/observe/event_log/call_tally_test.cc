#include "services/observe/event_log/call_tally.h"

#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

TEST(CallTallyTest, CountsOneServicesCallsAndTellsTheNextOfAll) {
  CallTally next("p.Other", nullptr);
  CallTally tally("p.Worker", &next);
  const auto finish = [&tally](const char* method, grpc::StatusCode code) {
    tally.OnFinished(method, code, absl::Seconds(1));
  };
  finish("p.Worker/Fuse", grpc::StatusCode::OK);
  finish("p.Worker/Fuse", grpc::StatusCode::OK);
  finish("p.Worker/Verify", grpc::StatusCode::CANCELLED);
  finish("p.Worker/Verify", grpc::StatusCode::UNAVAILABLE);
  finish("p.Workers/Fuse", grpc::StatusCode::OK);
  finish("p.Other/Check", grpc::StatusCode::INTERNAL);
  EXPECT_EQ(tally.Take(), (CallCounts{2, 1, 1}));
  EXPECT_EQ(tally.Take(), CallCounts());
  EXPECT_EQ(next.Take(), (CallCounts{0, 1, 0}));
}

}  // namespace
}  // namespace corbslam::services
