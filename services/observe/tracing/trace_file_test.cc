#include "services/observe/tracing/trace_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "services/observe/tracing/testing/read_trace.h"

namespace corbslam::services {
namespace {

using nlohmann::json;

constexpr KeyframeId kKeyframe{{0x00c0ffee00c0ffee}, 12};

KeyframeEvent MakeEvent(absl::string_view name) {
  return {name, kKeyframe, absl::FromUnixMicros(1'700'000'000'123'456), "lab", "alpha"};
}

TEST(TraceIdTest, IsThatOfTheKeyframeAndOfNoOther) {
  EXPECT_EQ(TraceId(kKeyframe), "00c0ffee00c0ffee000000000000000c");
  EXPECT_NE(TraceId(kKeyframe), TraceId({kKeyframe.local_map, 13}));
  EXPECT_NE(TraceId(kKeyframe), TraceId({{1}, 12}));
}

TEST(TraceLineTest, IsAnAsynchronousInstantOfChromesFormat) {
  const json line = json::parse(ToTraceLine(MakeEvent(kDurable), 7));
  EXPECT_EQ(line["ph"], "n");
  EXPECT_EQ(line["name"], "durable");
  EXPECT_EQ(line["cat"], "keyframe");
  EXPECT_EQ(line["pid"], 7);
  EXPECT_EQ(line["ts"], 1'700'000'000'123'456);
  EXPECT_EQ(line["args"], (json{{"trace", TraceId(kKeyframe)},
                                {"keyframe", ToString(kKeyframe)},
                                {"mission", "lab"},
                                {"agent", "alpha"}}));
  const json other = json::parse(ToTraceLine(MakeEvent(kSent), 8));
  EXPECT_EQ(line["id2"], other["id2"]) << "one row in the viewer, whichever process";
}

TEST(ProcessNumberTest, DiffersWhereNamesDoAndIsNoNegativeNumber) {
  EXPECT_NE(ProcessNumber("map_store"), ProcessNumber("client_agent lab/alpha"));
  EXPECT_GE(ProcessNumber("map_store"), 0);
}

TEST(TraceFileTest, WhatWasThereIsKeptBesideIt) {
  const std::string path = ::testing::TempDir() + "/trace_file_before_test.json";
  for (const absl::string_view process : {"first", "second"}) {
    ASSERT_TRUE(TraceFile::Open(path, process).ok());
  }
  EXPECT_EQ((*testing::ReadTrace(path))[0]["args"]["name"], "second");
  EXPECT_EQ((*testing::ReadTrace(path + ".before"))[0]["args"]["name"], "first");
}

TEST(TraceFileTest, ALinkAndADeviceStayWhatTheyAre) {
  const std::string path = ::testing::TempDir() + "/trace_file_linked.json";
  const std::string link = ::testing::TempDir() + "/trace_file_link.json";
  std::filesystem::remove(link);
  std::filesystem::create_symlink(path, link);
  for (const absl::string_view process : {"first", "second"}) {
    ASSERT_TRUE(TraceFile::Open(link, process).ok());
  }
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ((*testing::ReadTrace(path))[0]["args"]["name"], "second");
  EXPECT_EQ((*testing::ReadTrace(path + ".before"))[0]["args"]["name"], "first");
  ASSERT_TRUE(TraceFile::Open("/dev/null", "third").ok());
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST(TraceFileTest, HoldsWhatWasAddedOnceItIsClosed) {
  const std::string path = ::testing::TempDir() + "/trace_file_test.json";
  {
    auto file = TraceFile::Open(path, "map_store");
    ASSERT_TRUE(file.ok()) << file.status();
    for (int i = 0; i < 1000; ++i) (*file)->Add(MakeEvent(kReceived));
  }
  const auto events = testing::ReadTrace(path);
  ASSERT_TRUE(events.ok()) << events.status();
  ASSERT_EQ(events->size(), 1001u);
  EXPECT_EQ(events->front()["args"]["name"], "map_store");
  EXPECT_EQ(events->back()["name"], "received");
}

TEST(TraceFileTest, DropsAndCountsWhatTheDiskIsTooSlowFor) {
  const std::string path = ::testing::TempDir() + "/trace_file_test_dropped.json";
  auto file = TraceFile::Open(path, "map_store", {.max_waiting = 0});
  ASSERT_TRUE(file.ok()) << file.status();
  (*file)->Add(MakeEvent(kReceived));
  EXPECT_EQ((*file)->dropped(), 1u);
}

TEST(TraceFileTest, SaysWhichFileItCanNotWrite) {
  const auto file = TraceFile::Open("/nowhere/at/all.json", "map_store");
  EXPECT_TRUE(absl::IsUnavailable(file.status()));
  EXPECT_THAT(std::string(file.status().message()), ::testing::HasSubstr("/nowhere/at/all.json"));
}

}  // namespace
}  // namespace corbslam::services
