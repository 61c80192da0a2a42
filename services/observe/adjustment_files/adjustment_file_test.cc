#include "services/observe/adjustment_files/adjustment_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "services/convert/testing/test_data.h"
#include "services/observe/adjustment_files/saving_fusion_worker.h"
#include "services/testing/test_path.h"

namespace corbslam::services {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

AdjustBundleRequest MakeRequest() {
  std::mt19937 random(3);
  AdjustBundleRequest request;
  request.view = test_data::MakeMap(random, test_data::kMap, 5);
  request.base_revision = 17;
  request.fixed = {request.view.keyframes().begin()->first};
  request.max_iterations = 40;
  request.threads = 2;
  return request;
}

void ExpectSame(const AdjustBundleRequest& a, const AdjustBundleRequest& b) {
  EXPECT_EQ(a.base_revision, b.base_revision);
  EXPECT_EQ(a.fixed, b.fixed);
  EXPECT_EQ(a.max_iterations, b.max_iterations);
  EXPECT_EQ(a.threads, b.threads);
  ASSERT_EQ(a.view.keyframes().size(), b.view.keyframes().size());
  for (const auto& [id, keyframe] : a.view.keyframes()) {
    const Keyframe* other = b.view.FindKeyframe(id);
    ASSERT_NE(other, nullptr);
    EXPECT_EQ(keyframe.camera_from_map.translation, other->camera_from_map.translation);
    EXPECT_EQ(keyframe.payload->timestamp_ns, other->payload->timestamp_ns);
  }
  ASSERT_EQ(a.view.points().size(), b.view.points().size());
  for (const auto& [id, point] : a.view.points()) {
    const MapPoint* other = b.view.FindPoint(id);
    ASSERT_NE(other, nullptr);
    EXPECT_EQ(point.position_in_map, other->position_in_map);
    EXPECT_EQ(point.observations.size(), other->observations.size());
  }
}

TEST(AdjustmentFileTest, IsReadAsItWasWritten) {
  const std::string path = TestPath("one");
  const AdjustBundleRequest request = MakeRequest();
  ASSERT_TRUE(WriteAdjustment(request, path).ok());
  const auto read = ReadAdjustment(path);
  ASSERT_TRUE(read.ok()) << read.status();
  ExpectSame(request, *read);
}

TEST(AdjustmentFileTest, WhatIsNoneIsRefusedByName) {
  const std::string path = TestPath("one");
  EXPECT_EQ(ReadAdjustment(path + "_absent").status().code(), absl::StatusCode::kNotFound);
  ASSERT_TRUE(WriteAdjustment(MakeRequest(), path).ok());
  const uintmax_t size = fs::file_size(path);
  for (const uintmax_t left : {uintmax_t{0}, uintmax_t{1}, size / 2, size - 1}) {
    fs::resize_file(path, left);
    const absl::Status status = ReadAdjustment(path).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << left;
    EXPECT_THAT(std::string(status.message()), HasSubstr(path));
  }
}

TEST(AdjustmentFileTest, AFolderThatIsNotThereIsNamed) {
  const std::string path = TestPath("absent") + "/one";
  const absl::Status status = WriteAdjustment(MakeRequest(), path);
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()), HasSubstr(path));
}

// Counts how often it was asked to adjust.
class CountingWorker : public FusionWorker {
 public:
  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest&,
                                                    const ProgressCallback&) override {
    return absl::UnimplementedError("verify");
  }
  absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest&,
                                          const ProgressCallback&) override {
    return absl::UnimplementedError("fuse");
  }
  absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest&,
                                                  const ProgressCallback&) override {
    AdjustBundleResult result;
    result.iterations = ++asked_;
    return result;
  }

 private:
  int asked_ = 0;
};

TEST(SavingFusionWorkerTest, KeepsEachRequestAndAnswersAsTheOther) {
  const fs::path folder = TestPath("folder");
  fs::remove_all(folder);
  fs::create_directories(folder);
  CountingWorker worker;
  const auto keeping = MakeSavingFusionWorker(&worker, folder);
  const AdjustBundleRequest request = MakeRequest();
  for (int i = 1; i <= 2; ++i) EXPECT_EQ(keeping->AdjustBundle(request, nullptr)->iterations, i);
  EXPECT_EQ(keeping->FuseMaps({}, nullptr).status().message(), "fuse");
  EXPECT_EQ(keeping->VerifyOverlap({}, nullptr).status().message(), "verify");
  std::vector<std::string> saved;
  for (const auto& entry : fs::directory_iterator(folder)) saved.push_back(entry.path());
  ASSERT_EQ(saved.size(), 2);
  for (const std::string& path : saved) {
    const auto read = ReadAdjustment(path);
    ASSERT_TRUE(read.ok()) << read.status();
    ExpectSame(request, *read);
  }
}

TEST(SavingFusionWorkerTest, WorksOnWhatItCannotKeep) {
  CountingWorker worker;
  const auto keeping = MakeSavingFusionWorker(&worker, TestPath("absent"));
  EXPECT_EQ(keeping->AdjustBundle(MakeRequest(), nullptr)->iterations, 1);
}

}  // namespace
}  // namespace corbslam::services
