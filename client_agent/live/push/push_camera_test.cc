#include "client_agent/live/push/push_camera.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <filesystem>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client_agent/live/push/testing/push_packets.h"
#include "client_agent/source/rig/rig_file.h"

namespace corbslam::client_agent {
namespace {

using push_wire::Hello;
using ::testing::HasSubstr;

constexpr int kPatience_ms = 20000;

int Memory(size_t bytes, unsigned seals) {
  const int file = memfd_create("test", MFD_ALLOW_SEALING);
  EXPECT_EQ(ftruncate(file, static_cast<off_t>(bytes)), 0);
  if (seals != 0) {
    EXPECT_EQ(fcntl(file, F_ADD_SEALS, seals), 0);
  }
  return file;
}

// A driver that says whatever the test wants.
class RawDriver {
 public:
  explicit RawDriver(const std::string& path)
      : socket_(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0)) {
    sockaddr_un address = {};
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, path.c_str());
    EXPECT_EQ(connect(socket_.get(), reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  }
  void Send(const std::string& bytes, int files = 0, int file = -1) {
    iovec part = {const_cast<char*>(bytes.data()), bytes.size()};
    alignas(cmsghdr) char control[CMSG_SPACE(8 * sizeof(int))] = {};
    msghdr message = {};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    if (files > 0) {
      const size_t bytes_of_files = static_cast<size_t>(files) * sizeof(int);
      message.msg_control = control;
      message.msg_controllen = CMSG_SPACE(bytes_of_files);
      cmsghdr* const rights = CMSG_FIRSTHDR(&message);
      rights->cmsg_level = SOL_SOCKET;
      rights->cmsg_type = SCM_RIGHTS;
      rights->cmsg_len = CMSG_LEN(bytes_of_files);
      for (int i = 0; i < files; ++i) {
        std::memcpy(CMSG_DATA(rights) + static_cast<size_t>(i) * sizeof(int), &file, sizeof(int));
      }
    }
    sendmsg(socket_.get(), &message, MSG_NOSIGNAL);
  }
  void SendHello(const Hello& hello, int file, const std::string& rig = "") {
    Send(HelloPacket(hello, rig), 1, file);
    close(file);
  }
  // Returns the next message; empty once the robot ended the connection, or where none comes.
  std::string Receive() {
    char bytes[4096];
    for (int tries = 0; tries < 2; ++tries) {
      pollfd waiting = {socket_.get(), POLLIN, 0};
      if (poll(&waiting, 1, kPatience_ms) <= 0) return "";
      const ssize_t got = recv(socket_.get(), bytes, sizeof(bytes), 0);
      if (got >= 0) return {bytes, static_cast<size_t>(got)};
    }
    return "";
  }
  // Returns what the robot refused it with.
  std::string Refusal() {
    for (std::string said = Receive(); !said.empty(); said = Receive()) {
      if (KindOf(said) == push_wire::kRefused) return said.substr(sizeof(push_wire::Refused));
    }
    return "not refused";
  }
  bool IsWelcome() { return KindOf(Receive()) == push_wire::kWelcome; }
  uint64_t FreedSlots() {
    const std::string said = Receive();
    if (KindOf(said) != push_wire::kSlotsFree) return 0;
    push_wire::SlotsFree message;
    std::memcpy(&message, said.data(), sizeof(message));
    return message.slots;
  }

 private:
  static uint32_t KindOf(const std::string& message) {
    push_wire::Header header = {};
    if (message.size() >= sizeof(header)) std::memcpy(&header, message.data(), sizeof(header));
    return header.kind;
  }

  UniqueFd socket_;
};

class PushCameraTest : public ::testing::Test {
 protected:
  PushCameraTest() {
    char folder[] = "/tmp/push_test_XXXXXX";
    folder_ = mkdtemp(folder);
    path_ = folder_ + "/camera.sock";
  }
  ~PushCameraTest() override {
    camera_.reset();
    EXPECT_FALSE(std::filesystem::exists(path_));
    std::filesystem::remove_all(folder_);
  }
  void Start(const std::string& rig = kSmallRig) {
    auto opened = PushCamera::Open({.path = path_, .rig = *ReadRigText(rig, "rig")});
    ASSERT_TRUE(opened.ok()) << opened.status();
    camera_ = *std::move(opened);
    ASSERT_TRUE(camera_->Start(pairing_).ok());
  }
  std::string RefusalOf(const Hello& hello, int file) {
    RawDriver driver(path_);
    driver.SendHello(hello, file);
    return driver.Refusal();
  }

  std::string folder_;
  std::string path_;
  PicturePairing pairing_{true, 0};
  std::unique_ptr<PushCamera> camera_;
};

TEST_F(PushCameraTest, CopiesPicturesOutAndGivesSlotsBack) {
  Start();
  const int file = Memory(16384, F_SEAL_SHRINK);
  auto* const memory =
      static_cast<uint8_t*>(mmap(nullptr, 16384, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0));
  RawDriver driver(path_);
  driver.SendHello(GoodHello(), file);
  ASSERT_TRUE(driver.IsWelcome());
  for (int i = 1; i <= 9; ++i) {
    const uint32_t slot = static_cast<uint32_t>(i) % 2;
    std::memset(memory + slot * 8192, i, 64 * 48);
    std::memset(memory + slot * 8192 + 4096, 100 + i, 64 * 48);
    driver.Send(Bytes(GoodFrame(slot, i)));
    ASSERT_EQ(driver.FreedSlots(), 1u << slot);
    std::memset(memory, 0, 16384);
    const auto pair = pairing_.Take(absl::InfiniteFuture());
    ASSERT_TRUE(pair.ok() && pair->has_value());
    EXPECT_EQ((*pair)->first.timestamp_ns, i);
    EXPECT_EQ((*pair)->first.image.type(), CV_8UC1);
    EXPECT_EQ((*pair)->first.image.at<uint8_t>(47, 63), i);
    EXPECT_EQ((*pair)->second.image.at<uint8_t>(0, 0), 100 + i);
  }
  munmap(memory, 16384);
}

TEST_F(PushCameraTest, TakesNoMemoryThatCouldEndIt) {
  Start();
  EXPECT_THAT(RefusalOf(GoodHello(), Memory(16384, 0)), HasSubstr("F_SEAL_SHRINK"));
  EXPECT_THAT(RefusalOf(GoodHello(), Memory(16384, F_SEAL_GROW)), HasSubstr("F_SEAL_SHRINK"));
  EXPECT_THAT(RefusalOf(GoodHello(), Memory(12288, F_SEAL_SHRINK)),
              HasSubstr("memory has 12288 bytes, memory_bytes says 16384"));
  const std::string file = folder_ + "/file";
  EXPECT_THAT(RefusalOf(GoodHello(), open(file.c_str(), O_CREAT | O_RDWR, 0600)),
              HasSubstr("memory"));
  RawDriver none(path_);
  none.Send(HelloPacket(GoodHello()));
  EXPECT_THAT(none.Refusal(), HasSubstr("the hello carries 0 files"));
  const int memory = Memory(16384, F_SEAL_SHRINK);
  RawDriver many(path_);
  many.Send(HelloPacket(GoodHello()), 8, memory);
  // A kernel says that it cut the list off; an emulator may only do so.
  EXPECT_THAT(many.Refusal(),
              ::testing::AnyOf(HasSubstr("carries one file"), HasSubstr("must be the one")));
  close(memory);
}

TEST_F(PushCameraTest, RefusesAHelloByItsFieldAndWaitsForTheNext) {
  Start();
  Hello hello = GoodHello();
  hello.version = 9;
  EXPECT_THAT(RefusalOf(hello, Memory(16384, F_SEAL_SHRINK)), HasSubstr("version is 9"));
  hello = GoodHello();
  hello.first.width_px = 32;
  EXPECT_THAT(RefusalOf(hello, Memory(16384, F_SEAL_SHRINK)),
              HasSubstr("first.width_px is 32, must be 64"));
  RawDriver silent(path_);
  EXPECT_THAT(silent.Refusal(), HasSubstr("no hello came within 2s"));
  RawDriver good(path_);
  good.SendHello(GoodHello(), Memory(16384, F_SEAL_SHRINK));
  EXPECT_TRUE(good.IsWelcome());
}

TEST_F(PushCameraTest, RefusesFramesByTheirField) {
  Start();
  // Of each driver the first frame is taken.
  const std::vector<std::pair<push_wire::Frame, std::string>> table = {
      {GoodFrame(2, 20), "slot is 2, must be below 2"},
      {GoodFrame(0, 2), "timestamp_ns is 2, the frame before has 2"},
      {GoodFrame(0, 1), "timestamp_ns is 1, the frame before has 3"},
      {GoodFrame(0, int64_t{1} << 61), "is more than a minute ahead of CLOCK_MONOTONIC"}};
  int64_t time_ns = 0;
  for (const auto& [frame, says] : table) {
    RawDriver driver(path_);
    driver.SendHello(GoodHello(), Memory(16384, F_SEAL_SHRINK));
    ASSERT_TRUE(driver.IsWelcome());
    driver.Send(Bytes(GoodFrame(0, ++time_ns)));
    ASSERT_EQ(driver.FreedSlots(), 1u);
    driver.Send(Bytes(frame));
    EXPECT_THAT(driver.Refusal(), HasSubstr(says));
  }
  EXPECT_EQ(pairing_.counts().frames, 4u);
}

TEST_F(PushCameraTest, TakesWhatAnImuMeasuredAndRefusesItByItsField) {
  Start(SmallRigWithImu());
  const std::vector<std::pair<std::string, std::string>> table = {
      {ImuPacket({{10, {}, {}}}), "a sample's timestamp_ns is 10, the one before has 10"},
      {ImuPacket({{int64_t{1} << 61, {}, {}}}), "more than a minute ahead of CLOCK_MONOTONIC"},
      {ImuPacket({{20, {}, {}}, {15, {}, {}}}), "is 15, the one before has 20"},
      {ImuPacket({}), "samples is 0"}};
  for (const auto& [packet, says] : table) {
    RawDriver driver(path_);
    driver.SendHello(GoodHello(), Memory(16384, F_SEAL_SHRINK));
    ASSERT_TRUE(driver.IsWelcome());
    driver.Send(ImuPacket({{5, {0.1, 0, 0}, {}}, {10, {0.2, 0, 0}, {}}}));
    // It is read before what follows.
    driver.Send(Bytes(GoodFrame(0, 7)));
    ASSERT_EQ(driver.FreedSlots(), 1u);
    const ImuSamples samples = camera_->imu()->Take(7);
    ASSERT_EQ(samples.size(), 2u);
    EXPECT_EQ(samples[1].angular_velocity_rps.x(), 0.2);
    driver.Send(packet);
    EXPECT_THAT(driver.Refusal(), HasSubstr(says));
  }
}

TEST_F(PushCameraTest, ARigWithoutAnImuTakesNoSamples) {
  Start();
  RawDriver driver(path_);
  driver.SendHello(GoodHello(), Memory(16384, F_SEAL_SHRINK));
  ASSERT_TRUE(driver.IsWelcome());
  driver.Send(ImuPacket({{5, {}, {}}}));
  EXPECT_THAT(driver.Refusal(), HasSubstr("the rig has no block imu:"));
}

// Its times are of a clock that begins anew, as a camera's own may.
TEST_F(PushCameraTest, TheNextDriversTimesMayBeginAnew) {
  Start();
  const auto drive = [this](int64_t begin_ns) {
    RawDriver driver(path_);
    driver.SendHello(GoodHello(), Memory(16384, F_SEAL_SHRINK));
    ASSERT_TRUE(driver.IsWelcome());
    for (int64_t i = 0; i < 8; ++i) {
      driver.Send(Bytes(GoodFrame(0, begin_ns + i)));
      ASSERT_EQ(driver.FreedSlots(), 1u);
    }
  };
  drive(5'000'000);
  drive(1);
  const CameraCounts counts = pairing_.counts();
  EXPECT_GE(counts.frames, 8u + 4u);
  EXPECT_GT(counts.late, 0u) << "they are told";
  const auto newest = pairing_.Take(absl::Now());
  ASSERT_TRUE(newest.ok() && newest->has_value());
  EXPECT_EQ((*newest)->first.timestamp_ns, 8);
  EXPECT_EQ((*newest)->drive, 1);
}

TEST_F(PushCameraTest, TellsASecondDriverOfTheFirst) {
  Start();
  {
    RawDriver first(path_);
    first.SendHello(GoodHello(), Memory(16384, F_SEAL_SHRINK));
    ASSERT_TRUE(first.IsWelcome());
    EXPECT_THAT(RefusalOf(GoodHello(), Memory(16384, F_SEAL_SHRINK)),
                HasSubstr("another driver is connected, 'test' (process"));
    first.Send(Bytes(GoodFrame(1, 1)));
    EXPECT_EQ(first.FreedSlots(), 2u);
  }
  RawDriver next(path_);
  next.SendHello(GoodHello(), Memory(16384, F_SEAL_SHRINK));
  EXPECT_TRUE(next.IsWelcome());
}

TEST_F(PushCameraTest, OutlivesRandomBytes) {
  Start();
  std::mt19937 random(3);
  for (int i = 0; i < 300; ++i) {
    RawDriver driver(path_);
    if (i % 3 != 0) {
      driver.SendHello(GoodHello(), Memory(16384, F_SEAL_SHRINK));
      ASSERT_TRUE(driver.IsWelcome()) << i;
    }
    std::string bytes(random() % 200, 0);
    for (char& byte : bytes) byte = static_cast<char>(random());
    if (i % 2 == 0 && bytes.size() > 8) {
      const push_wire::Header header = {push_wire::kFrame, static_cast<uint32_t>(bytes.size())};
      std::memcpy(bytes.data(), &header, sizeof(header));
    }
    const int file = Memory(16, 0);
    driver.Send(bytes, static_cast<int>(random() % 3), file);
    close(file);
    if (!bytes.empty()) {
      EXPECT_NE(driver.Refusal(), "not refused");
    }
  }
  RawDriver good(path_);
  good.SendHello(GoodHello(), Memory(16384, F_SEAL_SHRINK));
  EXPECT_TRUE(good.IsWelcome());
}

TEST_F(PushCameraTest, ListensNowhereThatIsTaken) {
  Start();
  EXPECT_TRUE(absl::IsAlreadyExists(UnixListener::Listen(path_).status()));
  const std::string file = folder_ + "/file";
  close(open(file.c_str(), O_CREAT | O_RDWR, 0600));
  EXPECT_THAT(std::string(UnixListener::Listen(file).status().message()),
              HasSubstr("is no socket"));
  EXPECT_THAT(std::string(UnixListener::Listen(std::string(200, 'x')).status().message()),
              HasSubstr("1 to 107 bytes"));
  EXPECT_THAT(std::string(UnixListener::Check(folder_ + "/none/x").message()),
              HasSubstr("its folder can't be used"));
}

TEST_F(PushCameraTest, TakesThePlaceOfASocketThatWasLeftBehind) {
  {
    const UniqueFd left(socket(AF_UNIX, SOCK_SEQPACKET, 0));
    sockaddr_un address = {};
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, path_.c_str());
    ASSERT_EQ(bind(left.get(), reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  }
  Start();
  RawDriver driver(path_);
  driver.SendHello(GoodHello(), Memory(16384, F_SEAL_SHRINK));
  EXPECT_TRUE(driver.IsWelcome());
}

}  // namespace
}  // namespace corbslam::client_agent
