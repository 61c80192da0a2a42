#include "services/convert/lens.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "services/convert/geometry.h"

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

TEST(LensTest, EachPassesTheWireUnchanged) {
  const LensModel lenses[] = {RadialTangential{},
                              RadialTangential{-0.3, 0.1, 0.001, -0.002, 0},
                              RadialTangential{-0.3, 0.1, 0.001, -0.002, 0.01, 0.4, 0.5, 0.6},
                              Equidistant{},
                              Equidistant{0.01, -0.02, 0.03, -0.04},
                              DoubleSphere{-0.2, 0.59},
                              UnifiedSphere{},
                              UnifiedSphere{1.4, {-0.1, 0.2, 0.001, 0.002, 0}},
                              UnifiedSphere{1.4, {-0.1, 0.2, 0.001, 0.002, 0.3, 0.4, 0.5, 0.6}}};
  for (const LensModel& lens : lenses) {
    RecordedCamera recorded;
    recorded.lens = {400, 401, 320, 240, lens};
    v1::RecordedCamera proto;
    ToProto(recorded, &proto);
    v1::RecordedCamera received;
    ASSERT_TRUE(received.ParseFromString(proto.SerializeAsString()));
    const auto read = FromProto(received);
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(*read, recorded) << DescribeLens(lens);
  }
}

// Programs from before there were others read it.
TEST(LensTest, ARadialTangentialOneIsFiveNumbersAlone) {
  v1::RecordedCamera proto;
  LensToProto(RadialTangential{-0.3, 0.1, 0.001, -0.002, 0.01}, &proto);
  EXPECT_EQ(proto.distortion_size(), 5);
  EXPECT_EQ(proto.lens_model(), v1::LENS_MODEL_UNSPECIFIED);
}

TEST(LensTest, RefusesACountThatIsNoLens) {
  const struct {
    v1::LensModel model;
    int count;
  } cases[] = {{v1::LENS_MODEL_UNSPECIFIED, 4},     {v1::LENS_MODEL_UNSPECIFIED, 7},
               {v1::LENS_MODEL_EQUIDISTANT, 5},     {v1::LENS_MODEL_EQUIDISTANT, 0},
               {v1::LENS_MODEL_DOUBLE_SPHERE, 1},   {v1::LENS_MODEL_UNIFIED_SPHERE, 0},
               {v1::LENS_MODEL_UNIFIED_SPHERE, 1},  {v1::LENS_MODEL_UNIFIED_SPHERE, 5},
               {static_cast<v1::LensModel>(17), 5}, {v1::LENS_MODEL_UNIFIED_SPHERE, 10}};
  for (const auto& [model, count] : cases) {
    v1::RecordedCamera proto;
    proto.set_lens_model(model);
    for (int i = 0; i < count; ++i) proto.add_distortion(0.001);
    const absl::Status status = LensFromProto(proto).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << model << " with " << count << ": " << status;
  }
}

}  // namespace
}  // namespace corbslam::services
