#include "services/viewer/answer_memory.h"

#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

TEST(AnswerMemoryTest, AnswersCountUntilTheyAreSent) {
  AnswerMemory memory(100'000);
  AnswerMemory::Body first = memory.Begin();
  EXPECT_EQ(first.AddMessage(std::string(40'000, 'x')), absl::OkStatus());
  AnswerMemory::Body second = memory.Begin();
  EXPECT_EQ(second.AddMessage(std::string(40'000, 'x')).code(),
            absl::StatusCode::kResourceExhausted);
  auto sent = std::move(first).Take();
  EXPECT_EQ(sent->size(), 40'004u);
  EXPECT_EQ(sent->substr(0, 5), std::string("\x40\x9c\0\0x", 5));
  EXPECT_FALSE(second.AddMessage(std::string(40'000, 'x')).ok());
  sent = nullptr;
  EXPECT_EQ(memory.bytes(), 0u);
  EXPECT_TRUE(second.AddMessage(std::string(40'000, 'x')).ok());
}

TEST(AnswerMemoryTest, AnAnswerThatIsGivenUpCountsNoMore) {
  AnswerMemory memory(100'000);
  {
    AnswerMemory::Body body = memory.Begin();
    for (int i = 0; i < 10; ++i) EXPECT_TRUE(body.AddMessage(std::string(1000, 'x')).ok());
    EXPECT_GE(memory.bytes(), body.size());
  }
  EXPECT_EQ(memory.bytes(), 0u);
}

}  // namespace
}  // namespace corbslam::services
