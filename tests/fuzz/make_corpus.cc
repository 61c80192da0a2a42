// make_corpus FOLDER: writes good inputs of every fuzzer into FOLDER/FUZZER/, for the fuzzers to
// start from. What is there under other names stays.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <map>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client_agent/spool/spool_segment.h"
#include "corbslam/v1/map_store_service.pb.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/byte_journal.h"
#include "map_store/testing/grey_jpeg.h"
#include "map_store/testing/small_mission.h"
#include "services/convert/batch_bytes.h"
#include "services/convert/keyframe_picture.h"
#include "services/convert/map_update.h"
#include "services/convert/shared_update.h"
#include "services/convert/testing/test_data.h"
#include "services/convert/work/work.h"
#include "slam/coding/feature_coding.h"
#include "slam/coding/sourced_descriptors.h"
#include "slam/coding/testing/plausible_features.h"
#include "slam/vocabulary/vocabulary_file.h"
#include "tests/fuzz/messages.h"
#include "tests/fuzz/signing_key.h"

namespace corbslam::tests {

using client_agent::EncodeSegmentHeader;
using client_agent::EncodeSpoolRecord;
using client_agent::SpoolRecord;
using map_store::MapStore;
using services::CameraBook;
using services::EncodeBatch;
using services::FeatureForm;
using services::ToProto;
using services::WriteWork;

namespace {

using test_data::kMap;
using test_data::kOtherMap;

std::string root;

void Write(const std::string& fuzzer, const std::string& name, const std::string& content) {
  const std::string folder = root + "/" + fuzzer;
  std::filesystem::create_directories(folder);
  std::ofstream(folder + "/" + name, std::ios::binary | std::ios::trunc) << content;
}

std::string ReadBack(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string Messages(std::initializer_list<std::string> messages) {
  std::string input;
  for (const std::string& message : messages) AppendMessage(message, &input);
  return input;
}

v1::SyncRequest OpenRequest(const std::string& agent, std::vector<LocalMapId> local_maps) {
  v1::SyncRequest request;
  SessionRequest session;
  session.mission = "m";
  session.agent = agent;
  session.local_maps = std::move(local_maps);
  ToProto(session, request.mutable_open());
  return request;
}

// Makes a payload whose features are coded.
std::shared_ptr<const KeyframePayload> MakeCodablePayload(KeyframeId id) {
  return MakeKeyframePayload(id, 1'000'000'000'000 + id.index, 0, test_data::MakeCamera(),
                             testing::MakePlausibleFeatures(id.index, 40, {1241, 376}));
}

// The first keyframe's features and points' descriptors are coded.
MapUpdateBatch MakeCodableBatch(std::mt19937& random, LocalMapId local_map) {
  MapUpdateBatch batch = test_data::MakeBatch(random, local_map, 1, 2, 6);
  auto& payload = batch.full_keyframes[0].payload;
  payload = MakeCodablePayload(payload->id);
  for (size_t i = 0; i < batch.full_points.size(); ++i) {
    batch.full_points[i].descriptor = payload->features.descriptors[i];
  }
  return batch;
}

void WriteCodedSync() {
  std::mt19937 random(6);
  CameraBook sent;
  std::string input;
  AppendMessage(OpenRequest("alpha", {kMap}).SerializeAsString(), &input);
  for (auto& part : ToProto(MakeCodableBatch(random, kMap), sent, 60000, FeatureForm::kCoded)) {
    v1::SyncRequest request;
    *request.mutable_batch() = std::move(part);
    AppendMessage(request.SerializeAsString(), &input);
  }
  Write("sync_fuzzer", "coded", input);
}

void WriteCodedShared() {
  std::mt19937 random(7);
  SharedUpdate update = test_data::MakeSharedUpdate(random);
  SharedKeyframe& keyframe = update.keyframes[0];
  keyframe.payload = MakeCodablePayload(keyframe.payload->id);
  keyframe.points.resize(keyframe.payload->features.keypoints.size());
  for (size_t i = 0; i < update.points.size(); ++i) {
    update.points[i].reference = keyframe.payload->id;
    update.points[i].descriptor = keyframe.payload->features.descriptors[i];
  }
  CameraBook sent;
  std::string input;
  for (auto& part : ToProto(update, sent, 100000, FeatureForm::kCoded)) {
    v1::SyncResponse response;
    *response.mutable_shared() = std::move(part);
    AppendMessage(response.SerializeAsString(), &input);
  }
  Write("shared_update_fuzzer", "coded", input);
}

void WriteFeatureCoding() {
  const Features features = testing::MakePlausibleFeatures(1, 50, {640, 480});
  const FeatureColumns columns = ToColumns(features);
  if (const auto coded = EncodeFeatures(columns, {640, 480})) {
    Write("feature_coding_fuzzer", "features", std::string("\0", 1) + *coded);
  }
  std::vector<Descriptor> descriptors = features.descriptors;
  std::ranges::copy(testing::MakePlausibleFeatures(2, 10, {640, 480}).descriptors,
                    descriptors.begin());
  std::vector<std::span<const Descriptor>> sources(descriptors.size(), features.descriptors);
  for (size_t i = 0; i < sources.size(); i += 3) sources[i] = {};
  Write(
      "feature_coding_fuzzer", "descriptors",
      std::string("\1") + static_cast<char>(sources.size()) + EncodeSourced(descriptors, sources));
}

void WriteSync() {
  std::mt19937 random(1);
  for (const size_t part_bytes : {size_t{60000}, size_t{400}}) {
    CameraBook sent;
    std::string input;
    AppendMessage(OpenRequest("alpha", {kMap}).SerializeAsString(), &input);
    for (uint64_t number = 1; number <= 3; ++number) {
      for (auto& part :
           ToProto(test_data::MakeBatch(random, kMap, number, 2, 6), sent, part_bytes)) {
        v1::SyncRequest request;
        *request.mutable_batch() = std::move(part);
        AppendMessage(request.SerializeAsString(), &input);
      }
    }
    Write("sync_fuzzer", part_bytes > 1000 ? "three_batches" : "in_parts", input);
  }
}

// A batch, then pictures of two of its keyframes: a good one, and one that is cut short.
void WritePictures() {
  std::mt19937 random(8);
  CameraBook sent;
  std::string input;
  AppendMessage(OpenRequest("alpha", {kMap}).SerializeAsString(), &input);
  const MapUpdateBatch batch = test_data::MakeBatch(random, kMap, 1, 2, 6);
  for (auto& part : ToProto(batch, sent, 60000)) {
    v1::SyncRequest request;
    *request.mutable_batch() = std::move(part);
    AppendMessage(request.SerializeAsString(), &input);
  }
  for (const bool is_whole : {true, false}) {
    const std::string jpeg = testing::MakeGreyJpeg(320, 96, 40);
    v1::SyncRequest request;
    ToProto(KeyframePicture{batch.full_keyframes[is_whole ? 0 : 1].payload->id,
                            is_whole ? jpeg : jpeg.substr(0, 20), 4},
            request.mutable_picture());
    AppendMessage(request.SerializeAsString(), &input);
  }
  Write("sync_fuzzer", "pictures", input);
}

void WriteShared() {
  std::mt19937 random(2);
  CameraBook sent;
  std::string input;
  for (int i = 0; i < 2; ++i) {
    for (auto& part : ToProto(test_data::MakeSharedUpdate(random), sent, 1000)) {
      v1::SyncResponse response;
      *response.mutable_shared() = std::move(part);
      AppendMessage(response.SerializeAsString(), &input);
    }
  }
  Write("shared_update_fuzzer", "two_updates", input);
}

template <typename Message, typename Work>
void WriteWorkSeed(const std::string& name, char kind, const Work& work) {
  std::string input(1, static_cast<char>(kind | 0x80));
  WriteWork<Message>(work, std::function<bool(Message)>([&](const Message& message) {
                       AppendMessage(message.SerializeAsString(), &input);
                       return true;
                     }));
  Write("work_fuzzer", name, input);
}

void WriteWorkers() {
  std::mt19937 random(3);
  VerifyOverlapRequest verify;
  verify.query_view = std::make_shared<const Map>(test_data::MakeMap(random, kMap, 2));
  verify.query = {kMap, 0};
  verify.candidate_view = test_data::MakeMap(random, kOtherMap, 2);
  verify.candidates = {{{kOtherMap, 1}, 12}};
  WriteWorkSeed<v1::VerifyOverlapRequest>("verify", 0, verify);
  FuseMapsRequest fuse;
  fuse.target = test_data::MakeMap(random, kMap, 2);
  fuse.source = test_data::MakeMap(random, kOtherMap, 2);
  fuse.overlaps = {test_data::MakeOverlap(random, {kMap, 1}, {kOtherMap, 0})};
  fuse.new_overlaps = {0};
  WriteWorkSeed<v1::FuseMapsRequest>("fuse", 1, fuse);
  AdjustBundleRequest adjust;
  adjust.view = test_data::MakeMap(random, kMap, 2);
  adjust.fixed = {{kMap, 0}};
  WriteWorkSeed<v1::AdjustBundleRequest>("adjust", 2, adjust);
  VerifyOverlapResult verified;
  verified.overlaps = {test_data::MakeOverlap(random, {kMap, 1}, {kOtherMap, 0})};
  WriteWorkSeed<v1::VerifyOverlapResponse>("verified", 3, verified);
  FuseMapsResult fused;
  fused.accepted = true;
  fused.poses = {{{kMap, 1}, test_data::MakeSimilarity(random)}};
  fused.positions = {{{kMap, 2}, {1, 2, 3}}};
  WriteWorkSeed<v1::FuseMapsResponse>("fused", 4, fused);
  AdjustBundleResult adjusted;
  adjusted.poses = fused.poses;
  WriteWorkSeed<v1::AdjustBundleResponse>("adjusted", 5, adjusted);
}

void WriteSpool() {
  std::mt19937 random(4);
  std::string segment = EncodeSegmentHeader("me");
  for (uint64_t number = 1; number <= 2; ++number) {
    SpoolRecord record;
    record.local_map = kMap;
    record.number = number;
    segment +=
        EncodeSpoolRecord(record, EncodeBatch(test_data::MakeBatch(random, kMap, number, 1, 4)));
  }
  const std::string torn = segment.substr(0, segment.size() - 20);
  Write("spool_fuzzer", "whole", std::string("\0\0", 2) + Messages({segment}));
  Write("spool_fuzzer", "torn", std::string("\1\0", 2) + Messages({torn, segment}));
  const std::string payload = EncodeBatch(test_data::MakeBatch(random, {1}, 1, 1, 4));
  Write("spool_fuzzer", "coded",
        std::string("\0\1", 2) +
            Messages({std::string("\0\0", 2) + EncodeBatch(MakeCodableBatch(random, {1}))}));
  Write("spool_fuzzer", "checksums_made_right",
        std::string("\0\1", 2) + Messages({std::string("\0\0", 2) + payload}));
}

void WriteDatasets() {
  Write("dataset_fuzzer", "kitti",
        std::string("\0", 1) + Messages({"P0: 50 0 30 0 0 50 20 0 0 0 1 0\n"
                                         "P1: 50 0 30 -25 0 50 20 0 0 0 1 0\n",
                                         "0.000000e+00\n1.036224e-01\n"}));
  const std::string yaml =
      "%YAML:1.0\nsensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, 0.11,\n"
      "         0, 1, 0, 0,\n         0, 0, 1, 0,\n         0.0, 0.0, 0.0, 1.0]\n"
      "resolution: [64, 64]\ncamera_model: pinhole\nintrinsics: [50.5, 50, 20, 15] #fu\n"
      "distortion_model: radial-tangential\n"
      "distortion_coefficients: [-0.28, 0.07, 0.0002, 1.7e-05]\n";
  const std::string csv = "#timestamp [ns],filename\r\n1,1.png\r\n2,2.png\r\n";
  Write("dataset_fuzzer", "euroc", std::string("\1", 1) + Messages({yaml, csv, yaml, csv}));
  Write("dataset_fuzzer", "tum",
        std::string("\2", 1) +
            Messages({"1.5 rgb/a.png 1.51 depth/a.png\n", "# rgb\n1.5 rgb/a.png\n",
                      "1.51 depth/a.png\n", "fx: 525\nfy: 525\ncx: 32\ncy: 32\nk1: 0.1\n"}));
  Write("dataset_fuzzer", "tum_lists",
        std::string("\2", 1) + Messages({"", "1.5 rgb/a.png\n", "1.51 depth/a.png\n", ""}));
  Write("dataset_fuzzer", "trajectories",
        std::string("\3", 1) + Messages({"1305031102.175304 1 2 3 0 0 0 1\n", "0.1\n"}));
  Write("dataset_fuzzer", "kitti_trajectory",
        std::string("\3", 1) + Messages({"1 0 0 1 0 1 0 2 0 0 1 3\n", "0.1\n"}));
  Write("dataset_fuzzer", "euroc_trajectory",
        std::string("\3", 1) + Messages({"#time\n1403636579763555584,1,2,3,1,0,0,0,0,0,0\n", ""}));
}

void WriteSpecs() {
  const std::map<std::string, std::string> specs = {
      {"kitti", "kitti:DIR?frames=0:120&stride=2&offset=1&gamma=0.8&noise=4"},
      {"euroc", "euroc:DIR?robot=1/2&overlap=20&reverse"},
      {"tum", "tum:DIR?truth_frame=A&frames=3:"},
      {"sim", "sim:city?seed=7&robot=2/3&phase=0.5&blackout=10:2"},
      {"floor", "sim:floor?depth=1&seed=3"},
      {"option", "seed=7"},
      {"blackout", "blackout=10:2"}};
  for (const auto& [name, spec] : specs) Write("spec_fuzzer", name, spec);
}

void WriteVocabularies() {
  VocabularyTree tree;
  tree.branching = 2;
  tree.levels = 1;
  tree.descriptors.resize(3);
  tree.descriptors[2].words = {1, 2, 3, 4};
  tree.first_child = {1, 3, 3, 3};
  tree.weights = {0, 1, 0.5f};
  const std::string path = root + "/vocabulary.tmp";
  if (WriteVocabulary(tree, path).ok()) {
    Write("vocabulary_fuzzer", "binary", std::string("\0", 1) + ReadBack(path));
  }
  if (WriteTextVocabulary(tree, path).ok()) {
    Write("vocabulary_fuzzer", "text", std::string("\1", 1) + ReadBack(path));
  }
  std::filesystem::remove(path);
}

void WriteJournals() {
  auto bytes = std::make_shared<testing::JournalBytes>();
  testing::ByteJournal journal(bytes);
  for (const auto& record : testing::MakeSmallMission()) {
    journal.Append(bytes->mission, record).IgnoreError();
  }
  KeyframePayload payload;
  payload.features = testing::MakeSmallFeatures();
  const std::string features = map_store::EncodeFeatures(payload);
  std::string records = Messages({features});
  for (const std::string& record : bytes->records) AppendMessage(record, &records);
  Write("journal_fuzzer", "records", std::string("\0", 1) + records);
  const std::string coded = map_store::EncodeFeatures(*MakeCodablePayload({kMap, 1}));
  Write("journal_fuzzer", "coded", std::string("\0", 1) + Messages({coded}));

  bytes->wants_snapshot = true;
  MapStore store({.deterministic = true}, nullptr, std::make_unique<testing::ByteJournal>(bytes),
                 nullptr);
  store.Recover().IgnoreError();
  store.RunFusionUntilIdle(bytes->mission).IgnoreError();
  Write("journal_fuzzer", "snapshot", "\1" + Messages({features, bytes->snapshot}));
}

void WriteConfigurations() {
  Write("config_fuzzer", "limits",
        "# limits\nmax-missions=3\n[Limits]\nmax-parked-seconds = 1.5\nmax-features=\"10\"\n");
  Write("config_fuzzer", "program",
        "listen=\"127.0.0.1:0\"\ninsecure=true\nworker=[\"a:1\", \"b:2\"]\nopen-timeout=2\n");
}

void WriteNames() {
  const std::map<std::string, std::string> names = {
      {"mission", "missions/lab"},
      {"agent", "missions/lab/agents/alpha"},
      {"all_agents", "missions/-/agents/-"},
      {"operator", "missions/lab/operators/olga"},
      {"store", "stores/main"},
      {"local_map", "missions/lab/localMaps/00c0ffee00c0ffee"},
      {"all_local_maps", "missions/lab/localMaps/-"},
      {"keyframe", "missions/lab/localMaps/00c0ffee00c0ffee/keyframes/12"},
      {"page", "1"}};
  for (const auto& [name, text] : names) Write("name_fuzzer", name, text);
}

void WriteTokens() {
  const SigningKey key;
  const std::string claims =
      R"({"expires":1900000000,"grants":["missions/lab/agents/alpha","stores/main"]})";
  Write("token_fuzzer", "token", std::string("\0", 1) + key.Sign(claims));
  Write("token_fuzzer", "claims", "\1" + claims);
  Write("token_fuzzer", "public_key", "\2" + key.public_pem());
  Write("token_fuzzer", "private_key", "\2" + key.private_pem());
  Write("token_fuzzer", "files", "\3" + Messages({key.public_pem(), key.private_pem()}));
}

void WriteChoices() {
  std::mt19937 random(5);
  std::string choices;
  for (int i = 0; i < 600; ++i) choices.push_back(static_cast<char>(random()));
  Write("store_fuzzer", "dice", choices);
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "make_corpus FOLDER\n");
    return 2;
  }
  corbslam::tests::root = argv[1];
  corbslam::tests::WriteSync();
  corbslam::tests::WritePictures();
  corbslam::tests::WriteCodedSync();
  corbslam::tests::WriteCodedShared();
  corbslam::tests::WriteFeatureCoding();
  corbslam::tests::WriteShared();
  corbslam::tests::WriteWorkers();
  corbslam::tests::WriteSpool();
  corbslam::tests::WriteDatasets();
  corbslam::tests::WriteSpecs();
  corbslam::tests::WriteVocabularies();
  corbslam::tests::WriteJournals();
  corbslam::tests::WriteConfigurations();
  corbslam::tests::WriteNames();
  corbslam::tests::WriteTokens();
  corbslam::tests::WriteChoices();
  return 0;
}
