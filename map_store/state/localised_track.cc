#include "map_store/state/localised_track.h"

#include <algorithm>
#include <utility>

namespace corbslam::map_store {
namespace {

// Adds a time without a pose. Of a stretch the two ends are enough to say that there is a gap, and
// how long it is. However times fall back and forth, there are no more than two for each frame and
// two besides.
void AddLost(int64_t time_ns, LocalisedRun& run) {
  std::vector<int64_t>& lost = run.lost_frames_ns;
  const auto is_of_stretch = [&run](int64_t other_ns) {
    return run.frames.empty() || other_ns > run.frames.back().timestamp_ns;
  };
  const size_t count = lost.size();
  const bool is_full = count >= 2 * (run.frames.size() + 1);
  if (is_full || (count >= 2 && is_of_stretch(lost[count - 2]) && lost[count - 1] <= time_ns)) {
    lost.back() = time_ns;
  } else {
    lost.push_back(time_ns);
  }
}

// Adds both in the order of their times.
void AddByTime(const std::vector<TrackedFrame>& frames, const std::vector<int64_t>& lost_frames_ns,
               LocalisedRun& run) {
  auto lost = lost_frames_ns.begin();
  for (const TrackedFrame& frame : frames) {
    for (; lost != lost_frames_ns.end() && *lost < frame.timestamp_ns; ++lost) AddLost(*lost, run);
    run.frames.push_back(frame);
  }
  for (; lost != lost_frames_ns.end(); ++lost) AddLost(*lost, run);
}

// Drops each second frame; returns how many.
size_t Thin(LocalisedRun& run) {
  std::vector<TrackedFrame> kept;
  kept.reserve(run.frames.size() / 2 + 1);
  for (size_t i = 0; i < run.frames.size(); i += 2) kept.push_back(run.frames[i]);
  const size_t dropped = run.frames.size() - kept.size();
  const std::vector<int64_t> lost = std::exchange(run.lost_frames_ns, {});
  run.frames.clear();
  AddByTime(kept, lost, run);
  return dropped;
}

LocalisedRun& BeginRun(const LocalisedFrames& part, LocalisedTrack& track) {
  std::erase_if(track.runs, [](const LocalisedRun& run) { return run.frames.empty(); });
  if (track.runs.size() >= kMaxLocalisedRuns) {
    track.dropped += track.runs.front().frames.size();
    track.runs.erase(track.runs.begin());
  }
  LocalisedRun& run = track.runs.emplace_back();
  run.id = part.run;
  run.recorded_camera = part.recorded_camera;
  return run;
}

}  // namespace

const LocalisedRun* FindRun(const LocalisedTrack& track, uint64_t id) {
  const auto run = std::ranges::find(track.runs, id, &LocalisedRun::id);
  return run == track.runs.end() ? nullptr : &*run;
}

size_t CountFrames(const LocalisedTrack& track) {
  size_t count = 0;
  for (const LocalisedRun& run : track.runs) count += run.frames.size();
  return count;
}

void AddPart(const LocalisedFrames& part, size_t max_frames, LocalisedTrack& track) {
  auto run = std::ranges::find(track.runs, part.run, &LocalisedRun::id);
  LocalisedRun& goes_on = run == track.runs.end() ? BeginRun(part, track) : *run;
  goes_on.last_number = part.number;
  AddByTime(part.tracked_frames, part.lost_frames_ns, goes_on);
  for (size_t frames = CountFrames(track); frames > max_frames;) {
    size_t dropped = 0;
    for (LocalisedRun& each : track.runs) dropped += Thin(each);
    // Of a run the first frame stays.
    if (dropped == 0) break;
    track.dropped += dropped;
    frames -= dropped;
  }
}

}  // namespace corbslam::map_store
