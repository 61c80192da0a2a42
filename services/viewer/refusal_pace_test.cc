#include "services/viewer/refusal_pace.h"

#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"

namespace corbslam::services {
namespace {

TEST(RefusalPaceTest, WhoIsRefusedOftenWaits) {
  RefusalPace pace;
  const absl::Time now = absl::Now();
  for (int i = 0; i < 10; ++i) EXPECT_EQ(pace.Note("a", now), absl::ZeroDuration()) << i;
  EXPECT_GT(pace.Note("a", now), absl::ZeroDuration());
  EXPECT_EQ(pace.Note("b", now), absl::ZeroDuration()) << "another host";
  EXPECT_EQ(pace.Note("a", now + absl::Seconds(5)), absl::ZeroDuration());
  for (int i = 0; i < 1000; ++i) pace.Note("a", now);
  EXPECT_EQ(pace.Note("a", now + absl::Seconds(80)), absl::ZeroDuration())
      << "what is long ago is forgotten";
}

TEST(RefusalPaceTest, ManyHostsTakeNoMemory) {
  RefusalPace pace;
  const absl::Time now = absl::Now();
  for (int i = 0; i < 1000; ++i) pace.Note(absl::StrCat(i), now);
  for (int i = 0; i < 10; ++i) pace.Note(absl::StrCat("more ", i), now);
  EXPECT_GT(pace.Note("yet another", now), absl::ZeroDuration()) << "they count as one";
}

}  // namespace
}  // namespace corbslam::services
