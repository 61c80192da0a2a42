#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client_agent/source/bag/files/bag_file.h"
#include "client_agent/source/bag/files/bag_recording.h"
#include "client_agent/source/bag/files/unpack.h"
#include "client_agent/source/bag/testing/drawn_bags.h"

namespace corbslam::client_agent {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct Scanned {
  std::map<std::string, int> counts;  // Messages by topic.
  std::vector<std::string> notes;
  std::string error;
};

// Reads the bag through, and each of its messages whole.
Scanned ScanBag(const std::string& path) {
  Scanned scanned;
  const auto recording = BagRecording::Open(path);
  if (!recording.ok()) {
    scanned.error = std::string(recording.status().message());
    return scanned;
  }
  std::vector<RecordedPlace> places;
  (*recording)->Scan([&](const ScannedMessage& message, uint32_t file) {
    ++scanned.counts[(*recording)->channels()[message.channel].topic];
    places.push_back({file, message.place});
  });
  for (const RecordedPlace& place : places) (void)(*recording)->Read(place);
  scanned.notes = (*recording)->notes();
  return scanned;
}

int CountOf(const Scanned& scanned) {
  int count = 0;
  for (const auto& [topic, messages] : scanned.counts) count += messages;
  return count;
}

TEST(BagFilesTest, EachFormatAndCompressionHoldsTheSameMessages) {
  for (const char* name : kStereoBags) {
    const Scanned scanned = ScanBag(DrawnBag(name));
    EXPECT_EQ(scanned.error, "") << name;
    EXPECT_THAT(scanned.notes, IsEmpty()) << name;
    EXPECT_EQ(CountOf(scanned), 12) << name;
    EXPECT_EQ(scanned.counts.size(), 4u) << name;
  }
}

TEST(BagFilesTest, MessagesAreTheSameBytesInAllFilesOfRos2) {
  std::vector<std::string> first;
  for (const char* name : {"stereo_none.mcap", "stereo_zstd.mcap", "stereo_lz4.mcap",
                           "stereo_unchunked.mcap", "stereo_split", "stereo_packed"}) {
    const auto recording = BagRecording::Open(DrawnBag(name));
    ASSERT_TRUE(recording.ok()) << recording.status();
    std::vector<RecordedPlace> places;
    (*recording)->Scan([&](const ScannedMessage& message, uint32_t file) {
      places.push_back({file, message.place});
    });
    std::vector<std::string> messages;
    for (const RecordedPlace& place : places) messages.push_back(*(*recording)->Read(place));
    if (first.empty()) first = messages;
    EXPECT_EQ(messages, first) << name;
  }
}

TEST(BagFilesTest, AFileThatWasNotClosedIsReadThrough) {
  const std::string mcap = ReadBytes(DrawnBag("stereo_unchunked.mcap"));
  const Scanned cut = ScanBag(WriteBytes("cut.mcap", mcap.substr(0, mcap.size() / 2)));
  EXPECT_GT(CountOf(cut), 3);
  EXPECT_LT(CountOf(cut), 12);
  EXPECT_THAT(cut.notes, ElementsAre(AllOf(HasSubstr("cut.mcap: at "), HasSubstr("cut short")),
                                     HasSubstr("was not closed")));
  // A recorder of ROS 1 that is killed leaves chunks and no index.
  std::string bag = ReadBytes(DrawnBag("stereo_lz4.bag"));
  const size_t index = bag.find("index_pos=") + 10;
  uint64_t end = 0;
  std::memcpy(&end, bag.data() + index, sizeof(end));
  bag.resize(end);
  bag.replace(index, 8, 8, '\0');
  const Scanned killed = ScanBag(WriteBytes("killed.bag.active", bag));
  EXPECT_EQ(CountOf(killed), 12);
  EXPECT_THAT(killed.notes, ElementsAre(HasSubstr("was not closed")));
}

TEST(BagFilesTest, WhatIsNoBagIsNamed) {
  const auto refusal = [](const std::string& name, const std::string& bytes) {
    return ScanBag(WriteBytes(name, bytes)).error;
  };
  EXPECT_THAT(refusal("empty.bag", ""), HasSubstr("empty.bag: an empty file"));
  EXPECT_THAT(refusal("text.mcap", "hello"), HasSubstr("text.mcap: at 0: begins neither as"));
  EXPECT_THAT(refusal("old.bag", "#ROSBAG V1.2\n"), HasSubstr("'#ROSBAG V1.2'"));
  EXPECT_THAT(refusal("whole.db3", std::string("\x28\xB5\x2F\xFD....")),
              HasSubstr("whole.db3: at 0: "));
  EXPECT_THAT(refusal("none.db3", std::string("SQLite format 3\0....", 20)),
              HasSubstr("none.db3: "));
  EXPECT_THAT(ScanBag("/nowhere.bag").error, HasSubstr("no such bag"));
}

// Packs bytes that hardly repeat as zstd's blocks of plain bytes.
std::string PackedPlainly(const std::string& bytes) {
  // Frame header: no checksum, a window of 1 MiB.
  std::string packed("\x28\xB5\x2F\xFD\x00\x50", 6);
  constexpr size_t kBlock = 60'000;
  for (size_t at = 0; at < bytes.size(); at += kBlock) {
    const std::string block = bytes.substr(at, kBlock);
    const bool is_last = at + kBlock >= bytes.size();
    const uint32_t head = static_cast<uint32_t>(block.size()) << 3 | (is_last ? 1 : 0);
    packed.append(reinterpret_cast<const char*>(&head), 3);
    packed += block;
  }
  return packed;
}

TEST(BagFilesTest, AFilePackedAsAWholeIsUnpacked) {
  for (const char* name :
       {"stereo_zstd.mcap", "stereo_lz4.bag", "stereo_split/stereo_split_0.db3"}) {
    const std::string packed = PackedPlainly(ReadBytes(DrawnBag(name)));
    const Scanned whole = ScanBag(WriteBytes("packed.zstd", packed));
    EXPECT_EQ(whole.error, "") << name;
    EXPECT_GE(CountOf(whole), 6) << name;
    EXPECT_THAT(whole.notes, IsEmpty()) << name;
    EXPECT_THAT(ScanBag(WriteBytes("packed.zstd", packed.substr(0, packed.size() - 9))).error,
                HasSubstr("packed.zstd: at"))
        << name;
  }
  // A block that says it is one byte 100,000 times, a hundred times over.
  std::string bomb("\x28\xB5\x2F\xFD\x00\x50", 6);
  const uint32_t run = 100'000u << 3 | 1 << 1;
  for (int i = 0; i < 100; ++i) bomb.append(reinterpret_cast<const char*>(&run), 3) += 'x';
  EXPECT_THAT(ScanBag(WriteBytes("bomb.zstd", bomb)).error, HasSubstr("more than 200 times"));
}

TEST(BagFilesTest, NamesCanBePrinted) {
  EXPECT_EQ(CleanName("/a\x1b[2J\n\xff"), "/a?[2J??");
  EXPECT_EQ(CleanName(std::string(5000, 'a')).size(), 300u);
}

TEST(BagFilesTest, SizesAreNotTakenByTheirWord) {
  // A message, a chunk and an unpacked size of nearly all that a number can say.
  std::string mcap(ReadBytes(DrawnBag("stereo_zstd.mcap")));
  for (size_t at = 8; at + 8 < mcap.size(); at += 3) {
    std::string hostile = mcap;
    hostile.replace(at, 8, "\xff\xff\xff\xff\xff\xff\xff\x7f");
    (void)ScanBag(WriteBytes("hostile.mcap", hostile));
  }
  EXPECT_THAT(Unpack("zstd", "", uint64_t{1} << 40).status().message(), HasSubstr("at most"));
  EXPECT_THAT(Unpack("gzip", "", 5).status().message(), HasSubstr("known are zstd, lz4, bz2"));
}

TEST(BagFilesTest, NoDamageIsWorseThanANote) {
  for (const char* name : {"stereo_zstd.mcap", "stereo_lz4.mcap", "stereo_bz2.bag",
                           "stereo_lz4.bag", "stereo_packed/stereo_packed_0.db3"}) {
    const std::string whole = ReadBytes(DrawnBag(name));
    const size_t step = std::max<size_t>(1, whole.size() / 150);
    for (size_t at = 0; at < whole.size(); at += step) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
      (void)ScanBag(WriteBytes("damaged", damaged));
      (void)ScanBag(WriteBytes("damaged", whole.substr(0, at)));
    }
  }
}

// Returns a copy of the split bag that a test may change.
std::string CopySplitBag() {
  const fs::path folder = fs::path(::testing::TempDir()) / absl::StrCat("split_", getpid());
  fs::remove_all(folder);
  fs::copy(DrawnBag("stereo_split"), folder);
  return folder.string();
}

TEST(BagFilesTest, AFolderIsReadAsItsMetadataSay) {
  const std::string folder = CopySplitBag();
  fs::remove(folder + "/stereo_split_1.db3");
  Scanned scanned = ScanBag(folder);
  EXPECT_EQ(CountOf(scanned), 6);
  EXPECT_THAT(scanned.notes,
              ElementsAre(AllOf(HasSubstr("stereo_split_1.db3"), HasSubstr("not there"))));
  fs::remove(folder + "/metadata.yaml");
  scanned = ScanBag(folder);
  EXPECT_EQ(CountOf(scanned), 6);
  EXPECT_THAT(scanned.notes, ElementsAre(HasSubstr("has no metadata.yaml")));
  std::ofstream(folder + "/metadata.yaml") << "rosbag2_bagfile_information:\n  version: 1\n"
                                           << "  relative_file_paths: [old/stereo_split_0.db3]\n";
  EXPECT_EQ(CountOf(ScanBag(folder)), 6) << "early versions name the folder too";
  std::ofstream(folder + "/metadata.yaml") << "version: 1\n";
  EXPECT_THAT(ScanBag(folder).error, HasSubstr("rosbag2_bagfile_information is missing"));
  fs::remove_all(folder);
  fs::create_directories(folder);
  EXPECT_THAT(ScanBag(folder).error, HasSubstr("neither metadata.yaml nor"));
}

TEST(BagFilesTest, WithoutMetadataFilesAreReadAsPeopleCount) {
  const std::string folder = CopySplitBag();
  fs::remove(folder + "/metadata.yaml");
  fs::rename(folder + "/stereo_split_1.db3", folder + "/part_10.db3");
  fs::rename(folder + "/stereo_split_0.db3", folder + "/part_9.db3");
  const auto recording = BagRecording::Open(folder);
  ASSERT_TRUE(recording.ok()) << recording.status();
  int64_t last_ns = 0;
  (*recording)->Scan([&](const ScannedMessage& message, uint32_t) {
    EXPECT_GE(message.recorded_ns, last_ns);
    last_ns = message.recorded_ns;
  });
  EXPECT_GT(last_ns, 0);
}

}  // namespace
}  // namespace corbslam::client_agent
