#include "client_agent/source/read_ahead.h"

#include <gtest/gtest.h>

#include <utility>

#include "absl/status/status.h"

namespace corbslam::client_agent {
namespace {

StreamFrame Numbered(size_t number) {
  StreamFrame frame;
  frame.frame.number = number;
  return frame;
}

TEST(ReadAheadTest, EndsWhereItsReaderDoesAndGoesOnAfterABadFrame) {
  ReadAhead ahead(2, [](size_t i) -> absl::StatusOr<std::optional<StreamFrame>> {
    if (i == 1) return absl::NotFoundError("frame 1");
    if (i == 3) return std::nullopt;
    return Numbered(i);
  });
  EXPECT_EQ((*ahead.Next())->frame.number, 0u);
  EXPECT_EQ(ahead.Next().status(), absl::NotFoundError("frame 1"));
  EXPECT_EQ((*ahead.Next())->frame.number, 2u);
  for (int i = 0; i < 2; ++i) {
    const auto after = ahead.Next();
    EXPECT_TRUE(after.ok() && !after->has_value());
  }
}

TEST(ReadAheadTest, CanBeLeftWhileItsReaderHasMore) {
  ReadAhead ahead(
      1, [](size_t i) -> absl::StatusOr<std::optional<StreamFrame>> { return Numbered(i); });
  EXPECT_EQ((*ahead.Next())->frame.number, 0u);
}

}  // namespace
}  // namespace corbslam::client_agent
