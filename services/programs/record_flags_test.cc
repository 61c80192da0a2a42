#include "services/programs/record_flags.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

TEST(RecordFlagsTest, AFieldThatNobodyKnowsIsRefused) {
  RecordFlags flags;
  flags.folder = ::testing::TempDir() + "/{time}";
  EXPECT_TRUE(CheckRecording(flags).ok()) << CheckRecording(flags);
  for (const std::string name : {"{tme}", "{time}_{tme}"}) {
    flags.folder = ::testing::TempDir() + "/" + name;
    EXPECT_THAT(std::string(CheckRecording(flags).message()),
                HasSubstr("{tme} is no field that is known: {time} is"));
  }
}

}  // namespace
}  // namespace corbslam::services
