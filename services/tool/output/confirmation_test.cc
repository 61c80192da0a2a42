#include "services/tool/output/confirmation.h"

#include <gtest/gtest.h>

#include <string>

namespace corbslam::services {
namespace {

absl::Status Answered(std::string answer) {
  std::FILE* in = fmemopen(answer.data(), answer.size(), "r");
  std::string asked(200, '\0');
  std::FILE* out = fmemopen(asked.data(), asked.size(), "w");
  const absl::Status status = Confirm("Mission lab goes for good.", in, out);
  std::fclose(in);
  std::fclose(out);
  EXPECT_EQ(asked.find("Mission lab goes for good. Type yes to go on: "), 0u) << asked;
  return status;
}

TEST(ConfirmationTest, OnlyYesIsYes) {
  EXPECT_TRUE(Answered("yes\n").ok());
  EXPECT_TRUE(Answered(" YES \n").ok());
  for (const char* other : {"\n", "y\n", "no\n", "yes please\n"}) {
    EXPECT_EQ(Answered(other).code(), absl::StatusCode::kCancelled) << other;
  }
}

TEST(ConfirmationTest, WhoIsSureIsNotAsked) { EXPECT_TRUE(ConfirmLoss("", true).ok()); }

}  // namespace
}  // namespace corbslam::services
