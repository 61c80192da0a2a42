#include "services/tool/rig/live_sample.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/clock.h"
#include "slam/util/median.h"

namespace corbslam::services {

using client_agent::CameraCounts;
using client_agent::FindingLevel;
using client_agent::FrameStream;
using client_agent::NextFrame;
using client_agent::Sample;
using client_agent::SampleOptions;
using client_agent::SourceFindings;
using client_agent::SourceFrame;
using client_agent::StreamEnd;
using client_agent::StreamFrame;

namespace {

constexpr absl::Duration kWait = absl::Milliseconds(200);
constexpr double kGap_intervals = 1.5;
constexpr double kMostGaps = 0.05;
constexpr double kMostUnpaired = 0.1;
constexpr double kSlow = 0.7;  // Of the rate that the rig says.

// Keeps the first frames of each of `places` parts of the time.
class Keeper {
 public:
  Keeper(absl::Duration duration, size_t places, size_t row)
      : begin_(absl::Now()),
        part_(duration / static_cast<int64_t>(std::max<size_t>(places, 1))),
        row_(row) {}

  void Offer(StreamFrame frame, Sample& sample) {
    const int64_t part = absl::IDivDuration(absl::Now() - begin_, part_, &rest_);
    if (part != at_) kept_ = 0;
    at_ = part;
    if (kept_++ < row_) sample.push_back({frame.frame.number, std::move(frame.images)});
  }

 private:
  const absl::Time begin_;
  const absl::Duration part_;
  const size_t row_;
  absl::Duration rest_;
  int64_t at_ = -1;
  size_t kept_ = 0;
};

// Measures rate and gaps. A frame that a newer one replaced counts: nobody but this program missed
// it.
void MeasureTimes(const std::vector<SourceFrame>& frames, LiveSample& sample) {
  sample.taken = frames.size();
  if (frames.size() < 2) return;
  const auto seconds = [](const SourceFrame& a, const SourceFrame& b) {
    return 1e-9 * static_cast<double>(b.timestamp_ns - a.timestamp_ns);
  };
  sample.seconds = seconds(frames.front(), frames.back());
  const auto came = static_cast<double>(frames.back().number - frames.front().number);
  if (sample.seconds > 0) sample.rate_hz = came / sample.seconds;
  std::vector<double> steps_s;
  for (size_t i = 1; i < frames.size(); ++i) {
    if (frames[i].number != frames[i - 1].number + 1) continue;
    steps_s.push_back(seconds(frames[i - 1], frames[i]));
  }
  if (steps_s.empty()) return;
  const double usual_s = Median(steps_s);
  sample.longest_s = *std::max_element(steps_s.begin(), steps_s.end());
  sample.gaps = static_cast<size_t>(std::count_if(
      steps_s.begin(), steps_s.end(), [&](double s) { return s > kGap_intervals * usual_s; }));
}

double Share(uint64_t part, uint64_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

absl::StatusOr<LiveSample> TakeLiveSample(FrameStream& stream, absl::Duration duration,
                                          const SampleOptions& options) {
  const bool rgbd = KindOf(stream.calibration()) == SensorKind::kRgbd;
  LiveSample sample;
  std::vector<SourceFrame> frames;
  Keeper keeper(duration, options.places, rgbd ? options.rgbd_row : options.stereo_row);
  const absl::Time end = absl::Now() + duration;
  while (absl::Now() < end) {
    absl::StatusOr<NextFrame> next = stream.Next(std::min(end, absl::Now() + kWait));
    if (!next.ok()) sample.ended = next.status();
    if (!next.ok() || std::holds_alternative<StreamEnd>(*next)) break;
    auto* const frame = std::get_if<StreamFrame>(&*next);
    if (frame == nullptr) continue;
    if (!frames.empty() && frames.back().drive != frame->frame.drive) {
      frames.clear();
      ++sample.clocks;
    }
    frames.push_back(frame->frame);
    keeper.Offer(std::move(*frame), sample.frames);
  }
  sample.counts = stream.camera_counts();
  sample.left_out = stream.left_out();
  MeasureTimes(frames, sample);
  if (!frames.empty()) return sample;
  if (!sample.ended.ok()) return sample.ended;
  return absl::UnavailableError(
      absl::StrCat("the camera gave no frame in ", absl::FormatDuration(duration),
                   sample.left_out.last.empty() ? "" : absl::StrCat("; ", sample.left_out.last)));
}

std::vector<std::pair<std::string, std::string>> DescribeInLines(const LiveSample& sample) {
  std::vector<std::pair<std::string, std::string>> lines;
  lines.emplace_back("frames", absl::StrFormat("%d taken in %.1f s, %.2f frames/s came",
                                               sample.taken, sample.seconds, sample.rate_hz));
  lines.emplace_back("gaps", absl::StrFormat("%d; the longest between two frames %.0f ms",
                                             sample.gaps, 1000 * sample.longest_s));
  if (!sample.counts.has_value()) return lines;
  const CameraCounts& counts = *sample.counts;
  lines.emplace_back("missed", absl::StrFormat("%d frames that a newer one replaced; %d pictures "
                                               "without a counterpart, %d behind a newer one",
                                               counts.overtaken, counts.unpaired, counts.late));
  lines.emplace_back("apart", absl::StrFormat("the second picture of a frame is %+.2f ms later "
                                              "than the first (mean), at most %.2f ms either way",
                                              1e-6 * static_cast<double>(counts.mean_apart_ns),
                                              1e-6 * static_cast<double>(counts.most_apart_ns)));
  return lines;
}

SourceFindings CheckLiveSample(const LiveSample& sample, std::optional<double> expected_hz) {
  SourceFindings findings;
  const auto warn = [&](const char* code, std::string text) {
    findings.push_back({FindingLevel::kWarning, code, std::move(text)});
  };
  if (!sample.ended.ok()) {
    warn("camera-failed",
         absl::StrCat("the camera stopped before the time was over: ", sample.ended.message()));
  }
  if (expected_hz.has_value() && sample.rate_hz > 0 && sample.rate_hz < kSlow * *expected_hz) {
    warn("camera-slow", absl::StrFormat("%.1f frames/s came where the rig says %.1f: is the "
                                        "exposure long, the cable or the bus too slow?",
                                        sample.rate_hz, *expected_hz));
  }
  if (Share(sample.gaps, sample.taken) > kMostGaps) {
    warn("camera-gaps", absl::StrFormat("%d of %d frames came late by more than half an interval, "
                                        "one by %.0f ms: the camera or its link drops frames",
                                        sample.gaps, sample.taken, 1000 * sample.longest_s));
  }
  if (!sample.counts.has_value()) return findings;
  if (sample.clocks > 1 || sample.counts->ahead > 0) {
    warn("camera-clock",
         absl::StrFormat("its times went by %d clocks one after the other, and %d pictures were "
                         "stamped more than a minute ahead of the one before: a robot begins a new "
                         "local map with each. Stamp all pictures by CLOCK_MONOTONIC",
                         sample.clocks, sample.counts->ahead));
  }
  const uint64_t unpaired = sample.counts->unpaired;
  if (Share(unpaired, unpaired + 2 * sample.counts->frames) > kMostUnpaired) {
    warn("pair-unpaired",
         absl::StrFormat("%d pictures had no counterpart in time, %d frames had two: trigger both "
                         "cameras together, or say by how much their stamps differ "
                         "(time_offset_s in the rig; ?pair-within-ms)",
                         unpaired, sample.counts->frames));
  }
  return findings;
}

}  // namespace corbslam::services
