#include "services/convert/batch_bytes.h"

#include <gtest/gtest.h>

#include <random>

#include "services/convert/limits.h"
#include "services/convert/testing/test_data.h"

namespace corbslam::services {
namespace {

TEST(BatchBytesTest, StandForThemselves) {
  std::mt19937 random(1);
  MapUpdateBatch batch = test_data::MakeBatch(random, test_data::kMap, 7);
  // The batch's cameras went up with an earlier batch.
  batch.cameras.clear();
  const auto read = DecodeBatch(EncodeBatch(batch));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->local_map, batch.local_map);
  EXPECT_EQ(read->number, 7u);
  ASSERT_EQ(read->full_keyframes.size(), batch.full_keyframes.size());
  const KeyframePayload& payload = *read->full_keyframes[0].payload;
  EXPECT_EQ(*payload.camera, *batch.full_keyframes[0].payload->camera);
  EXPECT_EQ(payload.features.descriptors, batch.full_keyframes[0].payload->features.descriptors);
}

TEST(BatchBytesTest, FeaturesPassUnchanged) {
  std::mt19937 random(2);
  const MapUpdateBatch batch = test_data::MakeBatch(random, test_data::kMap, 1);
  const auto once = DecodeBatch(EncodeBatch(batch));
  const auto twice = DecodeBatch(EncodeBatch(*once));
  ASSERT_TRUE(twice.ok()) << twice.status();
  for (size_t i = 0; i < batch.full_keyframes.size(); ++i) {
    const Features& features = twice->full_keyframes[i].payload->features;
    EXPECT_EQ(features.keypoints, batch.full_keyframes[i].payload->features.keypoints);
    EXPECT_EQ(features.descriptors, batch.full_keyframes[i].payload->features.descriptors);
  }
}

TEST(BatchBytesTest, NonsenseIsRefused) {
  EXPECT_TRUE(absl::IsInvalidArgument(DecodeBatch("no batch at all").status()));
  EXPECT_TRUE(absl::IsInvalidArgument(DecodeBatch("").status()));
  EXPECT_TRUE(
      absl::IsInvalidArgument(DecodeBatch(std::string(kMaxUpdateBytes + 1, '\0')).status()));
}

}  // namespace
}  // namespace corbslam::services
