#include "map_store/records/picture_book.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "map_store/records/picture_cache.h"

namespace corbslam::map_store {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

KeyframeId Id(uint32_t index) { return {{7}, index}; }

std::vector<uint32_t> Indices(const std::vector<BookedPicture>& pictures) {
  std::vector<uint32_t> indices;
  for (const BookedPicture& picture : pictures) indices.push_back(picture.keyframe.index);
  return indices;
}

TEST(PictureBookTest, TheOldestGoFirst) {
  PictureBook book;
  for (const uint32_t index : {5, 1, 9}) book.Add(Id(index), 100, 0);
  EXPECT_EQ(book.bytes(), 300u);
  EXPECT_THAT(Indices(book.TakeBeyond(150)), ElementsAre(5, 1));
  EXPECT_EQ(book.bytes(), 100u);
  EXPECT_FALSE(book.Has(Id(5)));
  EXPECT_TRUE(book.Has(Id(9)));
  EXPECT_THAT(Indices(book.TakeBeyond(0)), ElementsAre(9));
  EXPECT_THAT(book.TakeBeyond(0), IsEmpty());
}

TEST(PictureBookTest, GoesOnBehindWhatWasReadBack) {
  PictureBook book;
  book.Put({.order = 8, .keyframe = Id(1), .bytes = 10, .position = 3});
  book.Put({.order = 4, .keyframe = Id(2), .bytes = 20, .position = 3});
  EXPECT_EQ(book.Add(Id(3), 5, 4).order, 9u);
  EXPECT_THAT(Indices(book.TakeBeyond(15)), ElementsAre(2));
  // A damaged index may name one keyframe, or one place in the order, twice.
  book.Put({.order = 20, .keyframe = Id(1), .bytes = 7, .position = 3});
  book.Put({.order = 9, .keyframe = Id(4), .bytes = 1, .position = 3});
  EXPECT_EQ(book.bytes(), 8u);
}

TEST(PictureBookTest, ASnapshotDropsWhatCameBeforeItAlone) {
  PictureBook book;
  book.Add(Id(1), 1, 10);
  book.Add(Id(2), 1, 10);
  book.Add(Id(3), 1, 12);
  EXPECT_THAT(Indices(book.FindUnneeded(11, {Id(2)})), ElementsAre(1));
  EXPECT_THAT(Indices(book.FindUnneeded(12, {Id(2)})), ElementsAre(1, 3));
}

TEST(PictureCacheTest, KeepsTheNewestOfAMission) {
  PictureCache cache;
  for (const uint32_t index : {1, 2, 3}) cache.Put("m", {Id(index), std::string(100, 'x'), 2}, 250);
  EXPECT_FALSE(cache.Read("m", Id(1)).ok());
  EXPECT_EQ(cache.Read("m", Id(3))->jpeg.size(), 100u);
  cache.Put("m", {Id(3), "another", 1}, 250);
  EXPECT_EQ(cache.Read("m", Id(3))->scale, 2) << "a keyframe has one picture";
  EXPECT_TRUE(absl::IsNotFound(cache.Read("other", Id(3)).status()));
  cache.Put("m", {Id(4), std::string(300, 'x'), 2}, 250);
  EXPECT_FALSE(cache.Read("m", Id(4)).ok()) << "it is larger than all may be";
  cache.Remove("m", {Id(2)});
  EXPECT_FALSE(cache.Read("m", Id(2)).ok());
  cache.RemoveMission("m");
  EXPECT_FALSE(cache.Read("m", Id(3)).ok());
}

TEST(PictureCacheTest, AllMissionsTogetherHaveABound) {
  PictureCache cache;
  const std::string large(16 << 20, 'x');
  for (const char* mission : {"a", "b", "c", "d", "e"}) {
    cache.Put(mission, {Id(1), large, 1}, uint64_t{1} << 40);
  }
  EXPECT_TRUE(cache.Read("d", Id(1)).ok());
  EXPECT_FALSE(cache.Read("e", Id(1)).ok());
  cache.RemoveMission("a");
  cache.Put("e", {Id(1), large, 1}, uint64_t{1} << 40);
  EXPECT_TRUE(cache.Read("e", Id(1)).ok());
}

}  // namespace
}  // namespace corbslam::map_store
