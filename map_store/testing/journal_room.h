// A folder with a store on a journal, for tests of what happens to its files.
#ifndef CORBSLAM_MAP_STORE_TESTING_JOURNAL_ROOM_H_
#define CORBSLAM_MAP_STORE_TESTING_JOURNAL_ROOM_H_

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"

namespace corbslam::testing {

// Each test has a folder of its own, which goes with it.
class JournalRoom : public ::testing::Test {
 protected:
  JournalRoom() {
    std::filesystem::remove_all(root_);
    std::filesystem::create_directories(root_);
  }
  ~JournalRoom() override {
    store_.reset();
    std::filesystem::remove_all(root_);
  }

  std::string Folder(const std::string& name) const { return (root_ / name).string(); }
  std::string Data() const { return Folder("data"); }
  std::filesystem::path MissionFolder(const std::string& mission) const {
    return map_store::JournalFolder(Data()).PathOf(mission);
  }

  // Opens a store on the folder of data; one that was open is closed first.
  void Open(uint64_t between_snapshots = uint64_t{32} << 20) {
    store_.reset();
    auto journal = map_store::RocksJournal::Open(
        {.directory = Data(), .min_bytes_between_snapshots = between_snapshots});
    ASSERT_TRUE(journal.ok()) << journal.status();
    journal_ = journal->get();
    store_ = std::make_unique<map_store::MapStore>(DeterministicOptions(), TheWorld().vocabulary,
                                                   *std::move(journal), nullptr);
    ASSERT_TRUE(store_->Recover().ok());
  }
  void Close() { store_.reset(); }

  // Has a new robot stream so many keyframes into the mission, and leave.
  void Stream(const std::string& mission, int keyframes) {
    const std::string agent = absl::StrCat("robot", made_);
    maps_.push_back(std::make_unique<SyntheticMap>(
        MakeRingMap(0xa00u + static_cast<uint32_t>(made_++), 0, keyframes)));
    TestAgent robot(*store_, mission, agent, *maps_.back());
    EXPECT_TRUE(robot.Stream().ok());
    EXPECT_TRUE(robot.Close().ok());
    store_->CloseSession(robot.session());
  }

  // Returns the mission's files with this ending, by name.
  std::vector<std::filesystem::path> Files(const std::string& mission,
                                           const std::string& ending) const {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(MissionFolder(mission))) {
      if (entry.path().extension() == ending) files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    return files;
  }
  // Turns all bits of so many bytes that far into the file.
  static void Spoil(const std::filesystem::path& file, uint64_t count = 64, double share = 0.5) {
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    const auto place =
        static_cast<std::streamoff>(share * static_cast<double>(std::filesystem::file_size(file)));
    std::string bytes(count, '\0');
    stream.seekg(place);
    stream.read(bytes.data(), static_cast<std::streamsize>(count));
    const std::streamsize read = stream.gcount();
    for (char& byte : bytes) byte = static_cast<char>(~byte);
    stream.clear();
    stream.seekp(place);
    stream.write(bytes.data(), read);
  }

  const std::filesystem::path root_ =
      std::filesystem::path(::testing::TempDir()) /
      ::testing::UnitTest::GetInstance()->current_test_info()->test_suite_name() /
      ::testing::UnitTest::GetInstance()->current_test_info()->name();
  std::unique_ptr<map_store::MapStore> store_;
  map_store::RocksJournal* journal_ = nullptr;  // The store's.

 private:
  std::vector<std::unique_ptr<SyntheticMap>> maps_;
  int made_ = 0;
};

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_JOURNAL_ROOM_H_
