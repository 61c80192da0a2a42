#include "client_agent/far/far_maps.h"

#include <glog/logging.h>

#include <algorithm>
#include <span>
#include <utility>

#include "client_agent/map/map_bytes.h"
#include "slam/util/named_thread.h"
#include "slam/vocabulary/vocabulary.h"

namespace corbslam::client_agent {
namespace {

// A bag takes about so many bytes with its postings.
constexpr uint64_t kBagBytes = 16 << 10;
// Keyframes in an update: the map is written, and tracking waits, for some milliseconds each.
constexpr size_t kKeyframesAnUpdate = 4;
// A place is recognised where it looks like a frame by this share of what the frame before does
// (Galvez-Lopez and Tardos, T-RO 2012, V.B).
constexpr double kLeastLikeness = 0.3;
// A place that was recognised is kept for so many comparisons, in which a loop closes there or not.
constexpr int kComparisonsKept = 20;

FarReach MakeReach(const FarMapsOptions& options) {
  FarReach reach;
  reach.radius = options.radius;
  return reach;
}

}  // namespace

FarMaps::FarMaps(const FarMapsOptions& options, ReadLocalMap read, Share share,
                 ComputeWords compute_words)
    : options_(options),
      read_(std::move(read)),
      share_(std::move(share)),
      compute_words_(std::move(compute_words)),
      index_(std::max<size_t>(options.max_bag_bytes / kBagBytes, 16)),
      chooser_(MakeReach(options)) {}

FarMaps::~FarMaps() { Stop(); }

void FarMaps::Stop() {
  {
    absl::MutexLock lock(&mutex_);
    stop_ = true;
  }
  if (thread_.joinable()) thread_.join();
}

void FarMaps::BeginLocalMap(LocalMapId local_map, bool goes_on) {
  absl::MutexLock lock(&mutex_);
  if (!goes_on) {
    in_frame_.clear();
    news_.ended.clear();
    news_.forget = true;
  }
  in_frame_.insert(local_map);
  news_.begun = local_map;
  news_.frame.reset();
  has_news_ = true;
}

void FarMaps::Keep(LocalMapId local_map, const Map& map) {
  Ended ended;
  ended.local_map = local_map;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (id.local_map != local_map) continue;
    ended.places.push_back({id, CameraCentre(keyframe.camera_from_map), keyframe.words});
  }
  if (ended.places.empty()) return;
  ended.bytes = EstimateBytes(map) / map.keyframes().size();
  absl::MutexLock lock(&mutex_);
  if (!in_frame_.contains(local_map)) return;
  news_.ended.push_back(std::move(ended));
  has_news_ = true;
}

void FarMaps::Note(const FarFrame& frame) {
  absl::MutexLock lock(&mutex_);
  news_.frame = frame;
  has_news_ = true;
}

void FarMaps::Start() {
  if (!thread_.joinable()) thread_ = StartThread("far maps", [this] { Run(); });
}

void FarMaps::Run() {
  while (true) {
    {
      absl::MutexLock lock(&mutex_);
      const auto has_work = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
        return has_news_ || stop_;
      };
      mutex_.Await(absl::Condition(&has_work));
      if (stop_) return;
    }
    Work();
  }
}

void FarMaps::Step() {
  while (Work() || !to_send_.empty()) {
  }
}

bool FarMaps::Work() {
  News news;
  bool is_news = false;
  {
    absl::MutexLock lock(&mutex_);
    is_news = std::exchange(has_news_, false);
    news = std::exchange(news_, News());
  }
  Take(news);
  // What was chosen comes bit by bit, with the frames, before anything else is chosen.
  if (to_send_.empty() && news.frame.has_value()) Choose(*news.frame);
  SendNext();
  absl::MutexLock lock(&mutex_);
  status_.keyframes = index_.keyframes();
  return is_news;
}

void FarMaps::Take(News& news) {
  if (news.forget) {
    index_.Clear();
    centre_.reset();
    recognised_.reset();
    absl::MutexLock lock(&mutex_);
    status_.local_maps = 0;
  }
  if (news.begun.has_value()) {
    in_use_ = *news.begun;
    told_.Restart();
    chooser_.Restart();
    to_send_.clear();
  }
  for (const Ended& ended : news.ended) {
    index_.Add(ended.places);
    chooser_.SetMaxKeyframes(std::max<size_t>(options_.max_bytes / ended.bytes, 1));
    choose_anew_ = true;
    absl::MutexLock lock(&mutex_);
    ++status_.local_maps;
  }
}

void FarMaps::Choose(const FarFrame& frame) {
  if (frame.centre.has_value()) centre_ = frame.centre;
  if (index_.keyframes() == 0) return;
  const std::optional<Eigen::Vector3d> recognised = Recognise(frame);
  if (recognised.has_value()) recognised_ = recognised;
  if (!centre_.has_value()) return;
  const bool anew = std::exchange(choose_anew_, false) || recognised.has_value();
  const FarChoice choice = chooser_.Choose(index_, told_.told(), *centre_, recognised_, anew);
  for (size_t i = 0; i < choice.take_out.size(); i += kKeyframesAnUpdate) {
    const size_t count = std::min(kKeyframesAnUpdate, choice.take_out.size() - i);
    to_send_.push_back(told_.TakeOut(std::span(choice.take_out).subspan(i, count)));
  }
  for (const auto& [local_map, ids] : choice.bring) Bring(local_map, ids);
}

std::optional<Eigen::Vector3d> FarMaps::Recognise(const FarFrame& frame) {
  if (frame.payload == nullptr) return std::nullopt;
  if (compared_ns_.has_value() && frame.timestamp_ns >= *compared_ns_ &&
      frame.timestamp_ns - *compared_ns_ < options_.recognise_every_ns) {
    return std::nullopt;
  }
  compared_ns_ = frame.timestamp_ns;
  const auto words = compute_words_(frame.payload->features.descriptors);
  const auto before = std::exchange(compared_, words);
  if (recognised_.has_value() && --recognised_for_ <= 0) recognised_.reset();
  const double usual = before == nullptr ? 0 : Similarity(before->bag, words->bag);
  if (!(usual > 0)) return std::nullopt;
  const std::optional<Eigen::Vector3d> place = index_.Recognise(words->bag, kLeastLikeness * usual);
  if (!place.has_value()) return std::nullopt;
  // What is near comes without that, and what was recognised is on its way.
  const double known_within = chooser_.reach().radius / 2;
  const auto is_known = [&](const std::optional<Eigen::Vector3d>& at) {
    return at.has_value() && (*place - *at).norm() < known_within;
  };
  if (is_known(centre_)) return std::nullopt;
  recognised_for_ = kComparisonsKept;
  if (is_known(recognised_)) return std::nullopt;
  absl::MutexLock lock(&mutex_);
  ++status_.recognised;
  return place;
}

void FarMaps::Bring(LocalMapId local_map, const std::vector<KeyframeId>& ids) {
  const absl::StatusOr<SpooledMap> spooled_map = read_(local_map);
  if (!spooled_map.ok()) return NoteUnreadable(local_map, spooled_map.status());
  Map map;
  // Who takes the updates computes the words of those that come.
  spooled_map->Fill([](const std::vector<Descriptor>&) { return std::shared_ptr<const Words>(); },
                    map);
  uint64_t brought = 0;
  for (size_t i = 0; i < ids.size(); i += kKeyframesAnUpdate) {
    const size_t count = std::min(kKeyframesAnUpdate, ids.size() - i);
    SharedUpdate update = told_.Bring(map, std::span(ids).subspan(i, count));
    brought += update.keyframes.size();
    to_send_.push_back(std::move(update));
  }
  absl::MutexLock lock(&mutex_);
  ++status_.reads;
  status_.brought_back += brought;
}

void FarMaps::NoteUnreadable(LocalMapId local_map, const absl::Status& why) {
  LOG(ERROR) << "local map " << ToString(local_map)
             << ", which has left memory, does not come back where the robot is near it: "
             << why.message()
             << ". The robot goes on without that part of its map; look after the disk of --spool";
  index_.Remove(local_map);
  absl::MutexLock lock(&mutex_);
  ++status_.unreadable;
  --status_.local_maps;
}

void FarMaps::SendNext() {
  if (to_send_.empty()) return;
  SharedUpdate update = std::move(to_send_.front());
  to_send_.pop_front();
  share_(in_use_, std::move(update));
}

FarMapsStatus FarMaps::status() const {
  absl::MutexLock lock(&mutex_);
  return status_;
}

}  // namespace corbslam::client_agent
