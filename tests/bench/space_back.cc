// Measures what a store takes of disk and memory before and after missions and keyframes are
// deleted. A run with --missions 1 and without --remove says what a fresh store takes for the same.
#include <glog/logging.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/store/map_store.h"
#include "slam/util/resident_memory.h"
#include "slam/util/status_macros.h"

namespace corbslam::tests {
namespace {

using map_store::MapStore;
using map_store::RocksJournal;

struct Flags {
  std::string data_dir;
  int missions = 6;
  uint32_t keyframes = 668;
  size_t features = 1500;
  // How many of the last mission's keyframes are removed in the end.
  uint32_t remove = 0;
  int seconds = 60;
  uint64_t min_free_mb = 64;
};

constexpr LocalMapId kLocalMap{1};
constexpr uint32_t kKeyframesOfABatch = 4;

// Uploads one local map: keyframes in a chain, with features that no coding makes shorter.
class Uploader {
 public:
  Uploader(const Flags& flags, MapStore& store, std::string mission)
      : flags_(flags), store_(store), mission_(std::move(mission)) {}

  absl::Status Open() {
    SessionRequest request;
    request.mission = mission_;
    request.agent = "robot";
    ASSIGN_OR_RETURN(const MapStore::OpenedSession opened, store_.OpenSession(request));
    session_ = opened.session_id;
    return absl::OkStatus();
  }
  absl::Status Upload() {
    for (uint32_t i = 0; i < flags_.keyframes; i += kKeyframesOfABatch) {
      MapUpdateBatch batch = NextBatch();
      if (i == 0) batch.cameras = {camera_};
      const uint32_t end = std::min(i + kKeyframesOfABatch, flags_.keyframes);
      for (uint32_t index = i; index < end; ++index) {
        batch.full_keyframes.push_back({MakePayload(index), Rigid3d::Identity(), ParentOf(index)});
      }
      RETURN_IF_ERROR(store_.Apply(session_, batch).status());
    }
    return absl::OkStatus();
  }
  // Removes the newest keyframes.
  absl::Status Remove(uint32_t count) {
    for (uint32_t removed = 0; removed < count; ++removed) {
      const uint32_t index = flags_.keyframes - 1 - removed;
      MapUpdateBatch batch = NextBatch();
      batch.removed_keyframes.push_back({{kLocalMap, index}, ParentOf(index), Rigid3d::Identity()});
      RETURN_IF_ERROR(store_.Apply(session_, batch).status());
    }
    return absl::OkStatus();
  }
  void Close() { store_.CloseSession(session_); }

 private:
  static KeyframeId ParentOf(uint32_t index) {
    return index == 0 ? KeyframeId() : KeyframeId{kLocalMap, index - 1};
  }
  MapUpdateBatch NextBatch() {
    MapUpdateBatch batch;
    batch.local_map = kLocalMap;
    batch.number = ++number_;
    return batch;
  }
  std::shared_ptr<const KeyframePayload> MakePayload(uint32_t index) {
    Features features;
    features.keypoints.resize(flags_.features);
    features.descriptors.resize(flags_.features);
    for (Keypoint& keypoint : features.keypoints) {
      keypoint.x_px = static_cast<float>(random_() % 640000) / 1000;
      keypoint.y_px = static_cast<float>(random_() % 480000) / 1000;
    }
    for (Descriptor& descriptor : features.descriptors) {
      for (uint64_t& word : descriptor.words) word = (uint64_t{random_()} << 32) | random_();
    }
    return MakeKeyframePayload({kLocalMap, index}, int64_t{index} * 100'000'000, 0, camera_,
                               std::move(features));
  }

  const Flags& flags_;
  MapStore& store_;
  const std::string mission_;
  const std::shared_ptr<const Camera> camera_ = std::make_shared<const Camera>(Camera{
      .fx_px = 500, .fy_px = 500, .cx_px = 320, .cy_px = 240, .width_px = 640, .height_px = 480});
  std::mt19937 random_{1};
  uint64_t session_ = 0;
  uint64_t number_ = 0;
};

absl::StatusOr<std::unique_ptr<MapStore>> OpenStore(const Flags& flags) {
  ASSIGN_OR_RETURN(
      std::unique_ptr<RocksJournal> journal,
      RocksJournal::Open({.directory = flags.data_dir, .min_free_bytes = flags.min_free_mb << 20}));
  auto store = std::make_unique<MapStore>(map_store::MapStoreOptions(), nullptr, std::move(journal),
                                          nullptr);
  RETURN_IF_ERROR(store->Recover());
  return store;
}

void Print(const Flags& flags, const std::string& what) {
  std::printf("| %s | %.1f | %.1f |\n", what.c_str(),
              static_cast<double>(map_store::BytesIn(flags.data_dir)) / (1 << 20),
              static_cast<double>(ResidentBytes()) / (1 << 20));
  std::fflush(stdout);
}

// Prints what is taken now, after a few seconds, and when the time is over.
void PrintOverTime(const Flags& flags, const std::string& what) {
  const absl::Time begin = absl::Now();
  Print(flags, what);
  for (const int seconds : {5, 15, flags.seconds}) {
    if (seconds > flags.seconds) continue;
    absl::SleepFor(begin + absl::Seconds(seconds) - absl::Now());
    Print(flags, absl::StrCat("after ", seconds, " s"));
  }
}

absl::Status Measure(const Flags& flags) {
  ASSIGN_OR_RETURN(std::unique_ptr<MapStore> store, OpenStore(flags));
  std::printf("| what | disk, MiB | resident, MiB |\n| --- | --- | --- |\n");
  Print(flags, "an empty store");
  std::unique_ptr<Uploader> last;
  for (int i = 0; i < flags.missions; ++i) {
    last = std::make_unique<Uploader>(flags, *store, absl::StrCat("m", i));
    RETURN_IF_ERROR(last->Open());
    RETURN_IF_ERROR(last->Upload());
    if (i + 1 < flags.missions) last->Close();
    if (i == 0) Print(flags, "1 mission");
  }
  PrintOverTime(flags, absl::StrCat(flags.missions, " missions"));
  for (int i = 0; i + 1 < flags.missions; ++i) {
    RETURN_IF_ERROR(store->DeleteMission(absl::StrCat("m", i)));
  }
  if (flags.missions > 1) PrintOverTime(flags, "all but one deleted");
  if (flags.remove > 0) {
    RETURN_IF_ERROR(last->Remove(flags.remove));
    PrintOverTime(flags, absl::StrCat(flags.remove, " of ", flags.keyframes, " keyframes removed"));
  }
  last->Close();
  store.reset();
  ASSIGN_OR_RETURN(store, OpenStore(flags));
  PrintOverTime(flags, "opened again");
  return absl::OkStatus();
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  using corbslam::tests::Flags;
  Flags flags;
  CLI::App app("Measures what comes back of disk and memory when things are deleted");
  app.add_option("--data-dir", flags.data_dir, "Folder of the journal, empty")->required();
  app.add_option("--missions", flags.missions, "Missions; all but one are deleted");
  app.add_option("--keyframes", flags.keyframes, "Keyframes of each mission");
  app.add_option("--features", flags.features, "Features of each keyframe");
  app.add_option("--remove", flags.remove, "Keyframes of the last mission that are removed");
  app.add_option("--seconds", flags.seconds, "How long it is watched after each step");
  app.add_option("--min-free-mb", flags.min_free_mb, "As map_store's");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = corbslam::tests::Measure(flags);
  LOG_IF(ERROR, !status.ok()) << status;
  return status.ok() ? 0 : 1;
}
