#include "services/convert/work/work.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "services/convert/testing/test_data.h"

namespace corbslam::services {
namespace {

using test_data::kMap;
using test_data::kOtherMap;
using test_data::MakeMap;
using ::testing::HasSubstr;

template <typename Message, typename Work>
std::vector<Message> Write(const Work& work) {
  std::vector<Message> messages;
  WriteWork<Message>(work, std::function<bool(Message)>([&](Message message) {
                       messages.push_back(std::move(message));
                       return true;
                     }));
  return messages;
}

template <typename Reader, typename Chunk, typename Message>
auto Read(const std::vector<Message>& messages) -> decltype(std::declval<Reader>().Finish()) {
  WorkReader<Reader, Chunk> reader;
  for (const Message& message : messages) {
    const absl::Status status = reader.Add(message);
    if (!status.ok()) return status;
  }
  if (!reader.ended()) return absl::DataLossError("no end");
  return reader.Finish();
}

void ExpectSameGraph(const Map& a, const Map& b) {
  ASSERT_EQ(a.keyframes().size(), b.keyframes().size());
  ASSERT_EQ(a.points().size(), b.points().size());
  for (const auto& [id, keyframe] : a.keyframes()) {
    const Keyframe* other = b.FindKeyframe(id);
    ASSERT_NE(other, nullptr);
    EXPECT_EQ(keyframe.camera_from_map.translation, other->camera_from_map.translation);
    EXPECT_EQ(keyframe.parent, other->parent);
    EXPECT_EQ(keyframe.children, other->children);
    EXPECT_EQ(keyframe.loop_edges, other->loop_edges);
    EXPECT_EQ(keyframe.payload->timestamp_ns, other->payload->timestamp_ns);
  }
  for (const auto& [id, point] : a.points()) {
    const MapPoint* other = b.FindPoint(id);
    ASSERT_NE(other, nullptr);
    EXPECT_EQ(point.position_in_map, other->position_in_map);
    EXPECT_EQ(point.reference, other->reference);
    EXPECT_EQ(point.observations.size(), other->observations.size());
  }
}

void ExpectSameCovisibility(const Map& a, const Map& b) {
  for (const auto& [id, keyframe] : a.keyframes()) {
    EXPECT_FALSE(keyframe.covisible.empty());
    EXPECT_EQ(keyframe.covisible, b.FindKeyframe(id)->covisible) << ToString(id);
  }
}

// Compares the keypoints that see a point, whatever their numbers now are, and the points
// themselves.
void ExpectSameSights(const Map& a, const Map& b) {
  for (const auto& [id, point] : a.points()) {
    const MapPoint& other = *b.FindPoint(id);
    EXPECT_EQ(point.descriptor, other.descriptor);
    EXPECT_EQ(point.max_distance, other.max_distance);
    for (const auto& [keyframe, keypoint] : point.observations) {
      const Keyframe& sent = *a.FindKeyframe(keyframe);
      const Keyframe& got = *b.FindKeyframe(keyframe);
      const uint32_t number = other.observations.at(keyframe);
      EXPECT_EQ(got.keypoints()[number], sent.keypoints()[keypoint]);
      EXPECT_EQ(got.descriptors()[number], sent.descriptors()[keypoint]);
    }
  }
}

void ExpectSameDescriptors(const Map& a, const Map& b) {
  for (const auto& [id, keyframe] : a.keyframes()) {
    const Keyframe& other = *b.FindKeyframe(id);
    EXPECT_EQ(keyframe.keypoints(), other.keypoints());
    EXPECT_EQ(keyframe.descriptors(), other.descriptors());
    EXPECT_EQ(keyframe.points, other.points);
    EXPECT_EQ(keyframe.words->direct_index, other.words->direct_index);
  }
  for (const auto& [id, point] : a.points()) {
    const MapPoint& other = *b.FindPoint(id);
    EXPECT_EQ(point.descriptor, other.descriptor);
    EXPECT_EQ(point.normal_in_map, other.normal_in_map);
    EXPECT_EQ(point.max_distance, other.max_distance);
  }
}

TEST(WorkTest, AFusingCarriesItsGraphAndWhatItSees) {
  std::mt19937 random(1);
  FuseMapsRequest request;
  request.base_revision = 9;
  request.target = MakeMap(random, kMap, 6);
  request.source = MakeMap(random, kOtherMap, 4);
  request.overlaps = {test_data::MakeOverlap(random, {kMap, 1}, {kOtherMap, 2}),
                      test_data::MakeOverlap(random, {kOtherMap, 3}, {kMap, 0})};
  request.new_overlaps = {1};
  const auto read = Read<FuseMapsRequestReader, v1::MapChunk>(Write<v1::FuseMapsRequest>(request));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->base_revision, 9u);
  EXPECT_EQ(read->fix_scale, request.fix_scale);
  EXPECT_EQ(read->new_overlaps, request.new_overlaps);
  ExpectSameGraph(request.target, read->target);
  ExpectSameCovisibility(request.target, read->target);
  ExpectSameSights(request.target, read->target);
  ExpectSameGraph(request.source, read->source);
  ExpectSameCovisibility(request.source, read->source);
  EXPECT_LT(read->source.FindKeyframe({kOtherMap, 0})->keypoints().size(), 40u);
  ASSERT_EQ(read->overlaps.size(), 2u);
  EXPECT_EQ(read->overlaps[1].query, request.overlaps[1].query);
  EXPECT_EQ(read->overlaps[1].covariance, request.overlaps[1].covariance);
  EXPECT_EQ(read->overlaps[1].inliers, request.overlaps[1].inliers);
  EXPECT_EQ(read->overlaps[1].evidence.projected_matches, 60);
  EXPECT_EQ(read->overlaps[1].evidence.chance_matches, 9);
  EXPECT_EQ(read->overlaps[1].evidence.visible_points, 300);
  EXPECT_EQ(read->overlaps[1].verdict, OverlapVerdict::kAccepted);
}

TEST(WorkTest, ABundleCarriesOnlyWhatItLooksAt) {
  std::mt19937 random(2);
  AdjustBundleRequest request;
  request.view = MakeMap(random, kMap, 6);
  request.fixed = {{kMap, 0}};
  request.max_iterations = 7;
  const auto read =
      Read<AdjustBundleRequestReader, v1::MapChunk>(Write<v1::AdjustBundleRequest>(request));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->fixed, request.fixed);
  EXPECT_EQ(read->max_iterations, 7);
  ExpectSameGraph(request.view, read->view);
  for (const auto& [id, keyframe] : read->view.keyframes()) {
    EXPECT_TRUE(keyframe.descriptors().empty());
    for (const MapPointId point : keyframe.points) EXPECT_TRUE(point.IsValid());
  }
  for (const auto& [id, point] : request.view.points()) {
    for (const auto& [keyframe, keypoint] : point.observations) {
      const Keyframe& sent = *request.view.FindKeyframe(keyframe);
      const Keyframe& got = *read->view.FindKeyframe(keyframe);
      const uint32_t number = read->view.FindPoint(id)->observations.at(keyframe);
      EXPECT_EQ(got.keypoints()[number], sent.keypoints()[keypoint]);
    }
  }
}

TEST(WorkTest, CandidatesCarryOnlyFeaturesWithPoints) {
  std::mt19937 random(3);
  VerifyOverlapRequest request;
  request.query_view = std::make_shared<const Map>(MakeMap(random, kMap, 4));
  request.query = {kMap, 1};
  request.candidate_view = MakeMap(random, kOtherMap, 5);
  request.candidates = {{{kOtherMap, 2}, 31}, {{kOtherMap, 4}, 12}};
  const auto read =
      Read<VerifyOverlapRequestReader, v1::MapChunk>(Write<v1::VerifyOverlapRequest>(request));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->query, request.query);
  ASSERT_EQ(read->candidates.size(), 2u);
  EXPECT_EQ(read->candidates[1].shared_words, 12);
  ExpectSameGraph(*request.query_view, *read->query_view);
  ExpectSameDescriptors(*request.query_view, *read->query_view);
  ExpectSameCovisibility(*request.query_view, *read->query_view);
  ExpectSameGraph(request.candidate_view, read->candidate_view);
  const Keyframe& candidate = *read->candidate_view.FindKeyframe({kOtherMap, 2});
  EXPECT_EQ(candidate.descriptors().size(), candidate.keypoints().size());
  EXPECT_LT(candidate.keypoints().size(), 40u);
}

TEST(WorkTest, ALargeMapGoesInChunksOfAtMostAMegabyte) {
  std::mt19937 random(4);
  FuseMapsRequest request;
  request.target = MakeMap(random, kMap, 1200);
  const auto messages = Write<v1::FuseMapsRequest>(request);
  EXPECT_GT(messages.size(), 5u);
  for (const auto& message : messages) {
    EXPECT_LE(message.chunk().data().size(), kMaxChunkBytes);
  }
  const auto read = Read<FuseMapsRequestReader, v1::MapChunk>(messages);
  ASSERT_TRUE(read.ok()) << read.status();
  ExpectSameGraph(request.target, read->target);
}

TEST(WorkTest, ResultsPassTheWireUnchanged) {
  std::mt19937 random(5);
  FuseMapsResult result;
  result.base_revision = 3;
  result.accepted = true;
  result.worst_edge_chi2 = 1.5;
  result.target_from_source = test_data::MakeSimilarity(random);
  for (uint32_t i = 0; i < 40000; ++i) {
    result.positions.push_back({{kMap, i}, Eigen::Vector3d(i, 0.1 * i, -1.0 / (i + 1))});
  }
  result.poses = {{{kMap, 4}, test_data::MakeSimilarity(random)}};
  result.merges = {{{kMap, 1}, {kOtherMap, 2}}};
  result.rejected = {{{kMap, 3}, {kOtherMap, 4}}};
  const auto messages = Write<v1::FuseMapsResponse>(result);
  EXPECT_GT(messages.size(), 3u);
  const auto read = Read<ResultReader<v1::FuseMapsResponse>, v1::ResultChunk>(messages);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_TRUE(read->accepted);
  EXPECT_EQ(read->target_from_source.scale, result.target_from_source.scale);
  ASSERT_EQ(read->positions.size(), result.positions.size());
  EXPECT_EQ(read->positions[39999].position_in_map, result.positions[39999].position_in_map);
  EXPECT_EQ(read->poses[0].id, result.poses[0].id);
  EXPECT_EQ(read->merges[0].member, result.merges[0].member);
  EXPECT_EQ(read->rejected[0].keyframe, result.rejected[0].keyframe);
}

class BadWorkTest : public ::testing::Test {
 protected:
  BadWorkTest() {
    std::mt19937 random(6);
    AdjustBundleRequest request;
    request.view = MakeMap(random, kMap, 3);
    request.fixed = {{kMap, 0}};
    messages_ = Write<v1::AdjustBundleRequest>(request);
  }
  std::string ReadMessage() {
    const auto read = Read<AdjustBundleRequestReader, v1::MapChunk>(messages_);
    EXPECT_EQ(read.status().code(), absl::StatusCode::kInvalidArgument) << read.status();
    return std::string(read.status().message());
  }
  // Changes the first chunk and makes the checksum right again.
  template <typename Change>
  void ChangeChunk(const Change& change) {
    v1::MapChunk chunk;
    ASSERT_TRUE(chunk.ParseFromString(messages_[1].chunk().data()));
    change(chunk);
    messages_[1].mutable_chunk()->set_data(chunk.SerializeAsString());
    uint32_t crc = 0;
    for (const auto& message : messages_) crc = ExtendCrc32c(crc, message.chunk().data());
    messages_.back().mutable_end()->set_crc32c(crc);
  }

  std::vector<v1::AdjustBundleRequest> messages_;
};

TEST_F(BadWorkTest, AWrongChecksum) {
  messages_.back().mutable_end()->set_crc32c(12345);
  EXPECT_THAT(ReadMessage(), HasSubstr("with checksum 12345"));
}
TEST_F(BadWorkTest, AMissingChunk) {
  messages_.erase(messages_.begin() + 1);
  EXPECT_FALSE((Read<AdjustBundleRequestReader, v1::MapChunk>(messages_).ok()));
}
TEST_F(BadWorkTest, NoHeader) {
  messages_.erase(messages_.begin());
  EXPECT_THAT(ReadMessage(), HasSubstr("the header must be first"));
}
TEST_F(BadWorkTest, ASecondHeader) {
  messages_.insert(messages_.begin(), messages_.front());
  EXPECT_THAT(ReadMessage(), HasSubstr("a second header"));
}
TEST_F(BadWorkTest, SomethingAfterTheEnd) {
  messages_.push_back(messages_.back());
  EXPECT_THAT(ReadMessage(), HasSubstr("after the end"));
}
TEST_F(BadWorkTest, NoPart) {
  messages_.insert(messages_.begin() + 1, v1::AdjustBundleRequest());
  EXPECT_THAT(ReadMessage(), HasSubstr("no part"));
}
TEST_F(BadWorkTest, AnEmptyChunk) {
  messages_[1].mutable_chunk()->clear_data();
  EXPECT_THAT(ReadMessage(), HasSubstr("size of a chunk in bytes is 0"));
}
TEST_F(BadWorkTest, ALongChunk) {
  messages_[1].mutable_chunk()->set_data(std::string(kMaxChunkBytes + 1, 'x'));
  EXPECT_THAT(ReadMessage(), HasSubstr("must be in [1, 1048576]"));
}
TEST_F(BadWorkTest, Rubbish) {
  messages_[1].mutable_chunk()->set_data("\xff\xff\xff rubbish");
  EXPECT_THAT(ReadMessage(), HasSubstr("can't be parsed"));
}
TEST_F(BadWorkTest, AKeyframeTwice) {
  ChangeChunk([](v1::MapChunk& chunk) { *chunk.add_keyframes() = chunk.keyframes(0); });
  EXPECT_THAT(ReadMessage(), HasSubstr("keyframe c0ffee00c0ffee01:0: came twice"));
}
TEST_F(BadWorkTest, AnUnknownView) {
  ChangeChunk([](v1::MapChunk& chunk) { chunk.set_view(v1::MAP_VIEW_UNSPECIFIED); });
  EXPECT_THAT(ReadMessage(), HasSubstr("view is 0"));
}
TEST_F(BadWorkTest, ACycleOfParents) {
  messages_.insert(messages_.end() - 1, messages_[1]);
  v1::MapChunk chunk;
  chunk.set_view(v1::MAP_VIEW_FIRST);
  chunk.add_local_maps(kMap.value);
  auto* edge = chunk.add_edges();
  edge->mutable_a()->set_slot(1);
  edge->mutable_b()->set_slot(1);
  edge->mutable_b()->set_index(2);
  (messages_.end() - 2)->mutable_chunk()->set_data(chunk.SerializeAsString());
  EXPECT_THAT(ReadMessage(), HasSubstr("makes a cycle"));
}
TEST_F(BadWorkTest, CovisibilityWithItself) {
  ChangeChunk([](v1::MapChunk& chunk) {
    auto* pairs = chunk.mutable_covisibility();
    for (auto* column : {pairs->mutable_a(), pairs->mutable_b()}) {
      column->add_slots(1);
      column->add_index_deltas(0);
    }
    pairs->add_weights(3);
  });
  EXPECT_THAT(ReadMessage(), HasSubstr("one is unknown, they are the same"));
}
TEST_F(BadWorkTest, CovisibilityWithoutWeights) {
  ChangeChunk([](v1::MapChunk& chunk) {
    auto* pairs = chunk.mutable_covisibility();
    for (auto* column : {pairs->mutable_a(), pairs->mutable_b()}) {
      column->add_slots(1);
      column->add_index_deltas(0);
    }
  });
  EXPECT_THAT(ReadMessage(), HasSubstr("covisibility.weights has 0 entries, must have 1"));
}
TEST_F(BadWorkTest, AFixedKeyframeThatIsNotThere) {
  auto* fixed = messages_.front().mutable_header()->mutable_fixed();
  fixed->set_index_deltas(0, 77);
  EXPECT_THAT(ReadMessage(), HasSubstr("fixed names c0ffee00c0ffee01:77"));
}
TEST_F(BadWorkTest, TooManyIterations) {
  messages_.front().mutable_header()->set_max_iterations(1001);
  EXPECT_THAT(ReadMessage(), HasSubstr("max_iterations is 1001, must be in [1, 1000]"));
}

}  // namespace
}  // namespace corbslam::services
