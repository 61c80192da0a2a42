#include "client_agent/live/push/push_message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "client_agent/live/push/testing/push_packets.h"
#include "client_agent/source/rig/rig_file.h"

namespace corbslam::client_agent {
namespace {

using push_wire::Frame;
using push_wire::Hello;
using ::testing::HasSubstr;

TEST(PushMessageTest, TakesAHello) {
  const auto hello = ParseHello(HelloPacket(GoodHello(), kSmallRig));
  ASSERT_TRUE(hello.ok()) << hello.status();
  EXPECT_EQ(hello->rig_text, kSmallRig);
  EXPECT_EQ(hello->name, "test");
  EXPECT_EQ(hello->layout.slots, 2u);
  EXPECT_EQ(hello->layout.second.offset_bytes, 4096u);
}

TEST(PushMessageTest, LogsNoControlLettersOfAName) {
  Hello hello = GoodHello();
  std::strcpy(hello.name, "a\nb\x1b");
  EXPECT_EQ(ParseHello(HelloPacket(hello))->name, "a?b?");
}

struct BadHello {
  std::string says;
  std::function<void(Hello&)> spoil;
};

TEST(PushMessageTest, RefusesHellosByTheirField) {
  const std::vector<BadHello> table = {
      {"kind is 2", [](Hello& h) { h.header.kind = 2; }},
      {"magic is 7", [](Hello& h) { h.magic = 7; }},
      {"version is 2, must be 1", [](Hello& h) { h.version = 2; }},
      {"slots is 0", [](Hello& h) { h.slots = 0; }},
      {"slots is 65", [](Hello& h) { h.slots = 65; }},
      {"slot_bytes is 8190", [](Hello& h) { h.slot_bytes = 8190; }},
      {"memory_bytes is 16383", [](Hello& h) { h.memory_bytes = 16383; }},
      {"memory_bytes is 16384, must be at least slots * slot_bytes",
       [](Hello& h) { h.slot_bytes = ~uint64_t{0} - 15; }},
      {"memory_bytes is 18446744073709551615", [](Hello& h) { h.memory_bytes = ~uint64_t{0}; }},
      {"first.format is 0", [](Hello& h) { h.first.format = 0; }},
      {"second.format is 5", [](Hello& h) { h.second.format = 5; }},
      {"first.width_px is 0", [](Hello& h) { h.first.width_px = 0; }},
      {"first.width_px is 16385", [](Hello& h) { h.first.width_px = 16385; }},
      {"second.height_px is 0", [](Hello& h) { h.second.height_px = 0; }},
      {"second.height_px is 4294967295", [](Hello& h) { h.second.height_px = ~0u; }},
      {"first.stride_bytes is 63", [](Hello& h) { h.first.stride_bytes = 63; }},
      {"first.stride_bytes is 4294967295", [](Hello& h) { h.first.stride_bytes = ~0u; }},
      {"first.stride_bytes is 129, must be even",
       [](Hello& h) {
         h.first = {CORBSLAM_PUSH_GREY16, 64, 24, 129, 0};
       }},
      {"second.offset_bytes is 8192", [](Hello& h) { h.second.offset_bytes = 8192; }},
      {"second.offset_bytes is 18446744073709551600",
       [](Hello& h) { h.second.offset_bytes = ~uint64_t{0} - 15; }},
      {"second.offset_bytes is 4097", [](Hello& h) { h.second.offset_bytes = 4097; }},
      {"first.offset_bytes is 0, must be such that its", [](Hello& h) { h.first.height_px = 129; }},
      {"name does not end", [](Hello& h) { std::memset(h.name, 'x', sizeof(h.name)); }}};
  for (const BadHello& bad : table) {
    Hello hello = GoodHello();
    bad.spoil(hello);
    const absl::Status status = ParseHello(HelloPacket(hello)).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << bad.says;
    EXPECT_THAT(std::string(status.message()), HasSubstr(bad.says));
  }
}

TEST(PushMessageTest, RefusesHellosOfAnotherSizeThanTheySay) {
  const std::string good = HelloPacket(GoodHello(), kSmallRig);
  for (size_t bytes = 0; bytes < good.size(); ++bytes) {
    EXPECT_FALSE(ParseHello(good.substr(0, bytes)).ok()) << bytes;
  }
  EXPECT_THAT(std::string(ParseHello(good + "x").status().message()), HasSubstr("header.bytes is"));
  Hello hello = GoodHello();
  hello.rig_bytes = 5;
  EXPECT_THAT(std::string(ParseHello(Bytes(hello)).status().message()),
              HasSubstr("rig_bytes is 5"));
}

TEST(PushMessageTest, RefusesFramesByTheirField) {
  const PushLayout layout = ParseHello(HelloPacket(GoodHello()))->layout;
  EXPECT_EQ(ParseFrame(Bytes(GoodFrame(1, 5)), layout)->timestamp_ns, 5);
  const auto says = [&](const Frame& frame) {
    return std::string(ParseFrame(Bytes(frame), layout).status().message());
  };
  EXPECT_THAT(says(GoodFrame(2, 5)), HasSubstr("slot is 2, must be below 2"));
  EXPECT_THAT(says(GoodFrame(0, -1)), HasSubstr("timestamp_ns is -1"));
  EXPECT_THAT(says(GoodFrame(0, INT64_MAX)), HasSubstr("timestamp_ns is 9223372036854775807"));
  Frame frame = GoodFrame(0, 5);
  frame.reserved = 1;
  EXPECT_THAT(says(frame), HasSubstr("reserved is 1"));
  frame = GoodFrame(0, 5);
  frame.header.kind = push_wire::kHello;
  EXPECT_THAT(says(frame), HasSubstr("kind is 1, must be 2 (frame)"));
  EXPECT_FALSE(ParseFrame(Bytes(GoodFrame(1, 5)) + "x", layout).ok());
  EXPECT_FALSE(ParseFrame("", layout).ok());
}

TEST(PushMessageTest, ReadsAnImusSamplesAndRefusesThemByTheirField) {
  const push_wire::ImuSample first = {5, {0.1, 0.2, 0.3}, {0, 0, 9.8}};
  const push_wire::ImuSample second = {10, {0.4, 0.5, 0.6}, {1, 2, 3}};
  const std::string good = ImuPacket({first, second});
  EXPECT_TRUE(IsImu(good));
  EXPECT_FALSE(IsImu(Bytes(GoodFrame(0, 5))));
  EXPECT_FALSE(IsImu(""));
  const auto samples = ParseImu(good);
  ASSERT_TRUE(samples.ok()) << samples.status();
  ASSERT_EQ(samples->size(), 2u);
  EXPECT_EQ((*samples)[0].timestamp_ns, 5);
  EXPECT_EQ((*samples)[1].angular_velocity_rps, Eigen::Vector3d(0.4, 0.5, 0.6));
  EXPECT_EQ((*samples)[1].specific_force_mps2, Eigen::Vector3d(1, 2, 3));
  for (size_t bytes = 0; bytes < good.size(); ++bytes) {
    EXPECT_FALSE(ParseImu(good.substr(0, bytes)).ok()) << bytes;
  }
  const auto says = [](const std::string& packet) {
    return std::string(ParseImu(packet).status().message());
  };
  EXPECT_THAT(says(ImuPacket({})), HasSubstr("samples is 0, must be 1 to 256"));
  EXPECT_THAT(says(ImuPacket(std::vector<push_wire::ImuSample>(257, first))),
              HasSubstr("samples is 257"));
  EXPECT_THAT(says(ImuPacket({second, first})), HasSubstr("is 5, the one before has 10"));
  EXPECT_THAT(says(ImuPacket({{-1, {}, {}}})), HasSubstr("timestamp_ns is -1, must be 0 to 2^62"));
  push_wire::ImuSample odd = first;
  odd.specific_force_mps2[2] = std::nan("");
  EXPECT_THAT(says(ImuPacket({odd})), HasSubstr("the sample of 5 ns has a value that is not"));
}

TEST(PushMessageTest, PicturesMustBeTheRigs) {
  const auto rig = ReadRigText(kSmallRig, "rig");
  ASSERT_TRUE(rig.ok()) << rig.status();
  const auto says = [&](const std::function<void(Hello&)>& spoil) {
    Hello hello = GoodHello();
    spoil(hello);
    return std::string(CheckPictures(ParseHello(HelloPacket(hello))->layout, *rig).message());
  };
  EXPECT_EQ(says([](Hello&) {}), "");
  EXPECT_THAT(says([](Hello& h) { h.first.width_px = 60; }),
              HasSubstr("first.width_px is 60, must be 64, the rig's"));
  EXPECT_THAT(says([](Hello& h) { h.second.height_px = 40; }),
              HasSubstr("second.height_px is 40, must be 48"));
  EXPECT_THAT(says([](Hello& h) {
                h.second = {CORBSLAM_PUSH_DEPTH16, 32, 48, 64, 4096};
              }),
              HasSubstr("second.format is 4"));
}

TEST(PushMessageTest, ARigOfOneCameraTakesOnePicture) {
  const auto pair = ReadRigText(kSmallRig, "rig");
  const auto one = ReadRigText(kOneCameraRig, "rig");
  ASSERT_TRUE(pair.ok() && one.ok()) << one.status();
  Hello hello = GoodHello();
  hello.second = {};
  const auto alone = ParseHello(HelloPacket(hello));
  ASSERT_TRUE(alone.ok()) << alone.status();
  EXPECT_TRUE(CheckPictures(alone->layout, *one).ok());
  EXPECT_THAT(std::string(CheckPictures(alone->layout, *pair).message()),
              HasSubstr("second.format is 0"));
  const auto both = ParseHello(HelloPacket(GoodHello()));
  EXPECT_THAT(std::string(CheckPictures(both->layout, *one).message()),
              HasSubstr("second.format is 1, must be 0"));
}

// Bytes of a hello or frame changed at random, and any bytes: nothing is taken that lies outside.
TEST(PushMessageTest, TakesNothingImpossibleOfRandomBytes) {
  std::mt19937 random(7);
  int taken = 0;
  for (int i = 0; i < 100000; ++i) {
    std::string packet = HelloPacket(GoodHello());
    for (auto k = random() % 3 + 1; k > 0; --k) {
      packet[random() % packet.size()] = static_cast<char>(random());
    }
    if (i % 10 == 0) {
      for (char& byte : packet) byte = static_cast<char>(random());
    }
    if (i % 7 == 0) packet.resize(random() % packet.size());
    const auto hello = ParseHello(packet);
    ParseFrame(packet, {2}).status().IgnoreError();
    if (!hello.ok()) continue;
    ++taken;
    const PushLayout& layout = hello->layout;
    ASSERT_LE(layout.slots * layout.slot_bytes, layout.memory_bytes);
    for (const push_wire::Picture& picture : {layout.first, layout.second}) {
      ASSERT_LE(picture.offset_bytes + uint64_t{picture.stride_bytes} * (picture.height_px - 1) +
                    picture.width_px,
                layout.slot_bytes);
    }
  }
  EXPECT_GT(taken, 100);
}

TEST(PushMessageTest, RigsOfImpossibleNumbersNameTheField) {
  const auto says = [](const std::string& from, const std::string& to) {
    std::string text = kSmallRig;
    text.replace(text.find(from), from.size(), to);
    return std::string(ReadRigText(text, "the driver's rig").status().message());
  };
  EXPECT_THAT(says("focal_px: [40, 40]", "focal_px: [.nan, 40]"), HasSubstr("focal_px"));
  EXPECT_THAT(says("focal_px: [40, 40]", "focal_px: [nan, 40]"), HasSubstr("focal_px"));
  EXPECT_THAT(says("baseline_m: 0.1", "baseline_m: .inf"), HasSubstr("baseline_m"));
  EXPECT_THAT(says("baseline_m: 0.1", "mask: /etc/passwd"), HasSubstr("mask"));
  EXPECT_THAT(says("rig: 1", "rig: 1\nrig: 1"), HasSubstr("twice"));
  EXPECT_FALSE(ReadRigText(std::string(60000, '['), "rig").ok());
  EXPECT_FALSE(ReadRigText("", "rig").ok());
  EXPECT_FALSE(ReadRigText("\x01\xff", "rig").ok());
}

}  // namespace
}  // namespace corbslam::client_agent
