#include "services/tool/export/mcap/mcap_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "services/testing/test_path.h"
#include "services/tool/export/mcap/mcap_bytes.h"
#include "services/tool/export/mcap/testing/mcap_reader.h"

namespace corbslam::services {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;
using ::testing::SizeIs;

TEST(McapCrcTest, AgreesWithThePublishedExample) {
  EXPECT_EQ(ExtendMcapCrc(0, "123456789"), 0xcbf43926u);
  EXPECT_EQ(ExtendMcapCrc(ExtendMcapCrc(0, "1234567"), "89"), 0xcbf43926u);
  EXPECT_EQ(ExtendMcapCrc(0, ""), 0u);
}

TEST(McapWriterTest, ByteForByteAsTheSpecificationSays) {
  const std::string path = TestPath("a.mcap");
  auto writer = McapWriter::Create(path, "lib");
  ASSERT_TRUE(writer.ok()) << writer.status();
  ASSERT_TRUE(writer->Finish().ok());
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const std::string header("\x89MCAP0\r\n\x01\x0b\0\0\0\0\0\0\0\0\0\0\0\x03\0\0\0lib", 28);
  EXPECT_EQ(text.substr(0, 28), header);
  // DataEnd: opcode, length, and the checksum of what came before.
  EXPECT_EQ(text.substr(28, 9), std::string("\x0f\x04\0\0\0\0\0\0\0", 9));
  McapBytes crc;
  crc.Add(ExtendMcapCrc(0, header));
  EXPECT_EQ(text.substr(37, 4), crc.view());
  EXPECT_EQ(text.substr(text.size() - 8), "\x89MCAP0\r\n");
  EXPECT_EQ(text[text.size() - 8 - 29], '\x02') << "the footer";
}

TEST(McapWriterTest, IsReadBack) {
  const std::string path = TestPath("a.mcap");
  auto writer = McapWriter::Create(path, "test");
  ASSERT_TRUE(writer.ok()) << writer.status();
  const auto schema = writer->AddSchema({"a.B", "protobuf", std::string("\0\1", 2)});
  ASSERT_TRUE(schema.ok()) << schema.status();
  const auto one = writer->AddChannel(*schema, "/one", "protobuf");
  const auto two = writer->AddChannel(*schema, "/two", "protobuf", {{"k", "v"}});
  ASSERT_TRUE(one.ok() && two.ok());
  ASSERT_TRUE(writer->Write(*two, 30, "late").ok());
  ASSERT_TRUE(writer->Write(*one, 10, "early").ok());
  ASSERT_TRUE(writer->AddMetadata("about", {{"mission", "lab"}, {"empty", ""}}).ok());
  ASSERT_TRUE(writer->Write(*one, 20, "").ok());
  EXPECT_FALSE(std::filesystem::exists(path)) << "it is there once it is whole";
  ASSERT_TRUE(writer->Finish().ok());
  const auto file = testing::ReadMcap(path);
  ASSERT_TRUE(file.ok()) << file.status();
  ASSERT_THAT(file->messages, SizeIs(3));
  EXPECT_EQ(file->messages[0].topic, "/two");
  EXPECT_EQ(file->messages[0].schema, "a.B");
  EXPECT_EQ(file->messages[1].data, "early");
  EXPECT_EQ(file->messages[2].time_ns, 20u);
  EXPECT_EQ(file->first_ns, 10u);
  EXPECT_EQ(file->last_ns, 30u);
  EXPECT_THAT(file->metadata.at("about"), ElementsAre(Pair("empty", ""), Pair("mission", "lab")));
}

TEST(McapWriterTest, AFileWithoutMessagesIsWhole) {
  const std::string path = TestPath("a.mcap");
  auto writer = McapWriter::Create(path, "test");
  ASSERT_TRUE(writer.ok()) << writer.status();
  ASSERT_TRUE(writer->AddSchema({"a.B", "protobuf", ""}).ok());
  ASSERT_TRUE(writer->Finish().ok());
  const auto file = testing::ReadMcap(path);
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_THAT(file->chunk_bytes, SizeIs(0));
  EXPECT_THAT(file->schemas, SizeIs(1));
}

TEST(McapWriterTest, HoldsOneChunk) {
  constexpr size_t kChunk = 4096;
  const std::string path = TestPath("a.mcap");
  auto writer = McapWriter::Create(path, "test", kChunk);
  ASSERT_TRUE(writer.ok()) << writer.status();
  const auto schema = writer->AddSchema({"a.B", "protobuf", ""});
  const auto channel = writer->AddChannel(*schema, "/one", "protobuf");
  for (uint64_t i = 0; i < 1000; ++i) {
    ASSERT_TRUE(writer->Write(*channel, i, std::string(i == 500 ? 10'000 : 100, 'x')).ok());
    ASSERT_LT(writer->bytes_held(), kChunk);
  }
  ASSERT_TRUE(writer->Finish().ok());
  const auto file = testing::ReadMcap(path);
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_THAT(file->messages, SizeIs(1000));
  int long_ones = 0;
  for (const uint64_t bytes : file->chunk_bytes) long_ones += bytes > kChunk + 200 ? 1 : 0;
  EXPECT_EQ(long_ones, 1) << "the long message's own";
  EXPECT_GT(file->chunk_bytes.size(), 25u);
}

TEST(McapWriterTest, SaysWhatItCantWrite) {
  EXPECT_THAT(std::string(McapWriter::Create("/nowhere/a.mcap", "test").status().message()),
              HasSubstr("/nowhere/a.mcap"));
  auto writer = McapWriter::Create(TestPath("a.mcap"), "test");
  ASSERT_TRUE(writer.ok()) << writer.status();
  EXPECT_EQ(writer->Write(1, 0, "").code(), absl::StatusCode::kNotFound);
  for (int i = 1; i < 65536; ++i) ASSERT_TRUE(writer->AddSchema({"a.B", "protobuf", ""}).ok());
  EXPECT_EQ(writer->AddSchema({"a.B", "protobuf", ""}).status().code(),
            absl::StatusCode::kResourceExhausted);
}

TEST(McapWriterTest, AFullDiskIsSaidAndADeviceStaysOne) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full here";
  auto writer = McapWriter::Create("/dev/full", "test");
  const absl::Status status = writer.ok() ? writer->Finish() : writer.status();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("/dev/full"));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

TEST(McapWriterTest, FollowsALinkThatStaysOne) {
  const std::string path = TestPath("a.mcap");
  const std::string link = TestPath("link.mcap");
  std::filesystem::create_symlink(path, link);
  auto writer = McapWriter::Create(link, "test");
  ASSERT_TRUE(writer.ok()) << writer.status();
  ASSERT_TRUE(writer->Finish().ok());
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_TRUE(std::filesystem::is_regular_file(std::filesystem::symlink_status(path)));
}

}  // namespace
}  // namespace corbslam::services
