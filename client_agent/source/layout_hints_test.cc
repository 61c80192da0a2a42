#include "client_agent/source/layout_hints.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace corbslam::client_agent {
namespace {

namespace fs = std::filesystem;
using ::testing::EndsWith;

class LayoutHintsTest : public ::testing::Test {
 protected:
  LayoutHintsTest() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }

  void MakeFolder(const std::string& path) const { fs::create_directories(folder_ / path); }
  void MakeFile(const std::string& path) const {
    fs::create_directories((folder_ / path).parent_path());
    std::ofstream(folder_ / path) << "x\n";
  }
  // Returns what is said of an error "broken" of the folder `path`, seen as `layout`.
  std::string Say(SourceLayout layout, const std::string& path = "") const {
    SourceSpec spec;
    spec.layout = layout;
    spec.directory = Path(path);
    return std::string(WithLayoutHint(absl::NotFoundError("broken"), spec).message());
  }
  std::string Path(const std::string& path) const {
    return (path.empty() ? folder_ : folder_ / path).string();
  }

  const fs::path folder_ = fs::path(::testing::TempDir()) / "layout_hints_test";
};

TEST_F(LayoutHintsTest, NothingMoreIsSaidOfAFolderThatLooksAsItShould) {
  MakeFolder("image_2");
  EXPECT_EQ(Say(SourceLayout::kKitti), "broken");
}

TEST_F(LayoutHintsTest, NorOfOneThatLooksLikeNothing) {
  MakeFolder("holidays");
  EXPECT_EQ(Say(SourceLayout::kKitti), "broken");
}

TEST_F(LayoutHintsTest, OthersLayoutsAreRecognised) {
  MakeFile("kitti/image_00/data/0000000000.png");
  MakeFile("euroc/cam0/data.csv");
  MakeFile("tum/associations.txt");
  MakeFile("scenes/frame-000000.color.png");
  const auto looks_like = [&](const std::string& scheme, const std::string& name) {
    return "broken. It looks like a folder for " + scheme + ":" + Path(name);
  };
  EXPECT_EQ(Say(SourceLayout::kEuroc, "kitti"), looks_like("kitti", "kitti"));
  EXPECT_EQ(Say(SourceLayout::kTum, "euroc"), looks_like("euroc", "euroc"));
  EXPECT_EQ(Say(SourceLayout::kSevenScenes, "tum"), looks_like("tum", "tum"));
  EXPECT_EQ(Say(SourceLayout::kTum, "scenes"), looks_like("7scenes", "scenes"));
}

TEST_F(LayoutHintsTest, TheFirstFolderWithinIsProposed) {
  MakeFolder("b/image_0");
  MakeFolder("a/image_0");
  MakeFile("0/associated.txt");
  EXPECT_EQ(Say(SourceLayout::kKitti), "broken. Is kitti:" + Path("a") + " meant?");
  EXPECT_EQ(Say(SourceLayout::kTum), "broken. Is tum:" + Path("0") + " meant?");
  EXPECT_EQ(Say(SourceLayout::kEuroc), "broken");
}

TEST_F(LayoutHintsTest, WhatIsNoFolderIsNamed) {
  MakeFile("calib.txt");
  EXPECT_THAT(Say(SourceLayout::kKitti, "nowhere"), EndsWith("nowhere: there is no such folder"));
  EXPECT_THAT(Say(SourceLayout::kKitti, "calib.txt"),
              EndsWith("calib.txt: a file; wanted is the folder of the sequence"));
  fs::create_symlink(Path("gone"), folder_ / "link");
  EXPECT_THAT(Say(SourceLayout::kKitti, "link"), EndsWith("link: there is no such folder"));
}

}  // namespace
}  // namespace corbslam::client_agent
