#include "client_agent/live/gstreamer/gst_sides.h"

#include <glog/logging.h>

#include "absl/strings/str_cat.h"
#include "client_agent/live/gstreamer/gst_pipeline.h"

namespace corbslam::client_agent {
namespace {

constexpr int64_t kGoesOn_ns = 1'000'000'000;
constexpr absl::Duration kSilent = absl::Seconds(5);
// The pictures' own times pass so much faster than ours.
constexpr double kFast = 2;
constexpr double kFastAfter_s = 1;

}  // namespace

std::optional<absl::Status> SideWatch::OneSideEnded(absl::Time now) {
  if (options_.layout != GstLayout::kTwoPipelines || first_.ended == second_.ended) {
    return std::nullopt;
  }
  const bool first_ended = first_.ended;
  const GstSide& ended = first_ended ? first_ : second_;
  const GstSide& other = first_ended ? second_ : first_;
  const uint64_t pictures = other.pictures;
  if (changed_ == absl::InfiniteFuture() || pictures != pictures_) {
    pictures_ = pictures;
    changed_ = now;
  }
  const int64_t last_ns = ended.pictures > 0 ? ended.newest_ns : other.first_ns;
  const bool goes_on = pictures > 0 && other.newest_ns > last_ns + kGoesOn_ns;
  if (!goes_on && now < changed_ + kSilent) return std::nullopt;
  const LiveSide side = first_ended ? LiveSide::kFirst : LiveSide::kSecond;
  const LiveSide other_side = first_ended ? LiveSide::kSecond : LiveSide::kFirst;
  return absl::DataLossError(absl::StrCat(
      NameOfSide(options_, side), " ended after ", ended.pictures.load(), " pictures, and ",
      NameOfSide(options_, other_side), goes_on ? " goes on" : " did not end",
      ": a frame has both. Is the next picture of it missing, or cut short?"));
}

void SideWatch::TellCounts() const {
  if (options_.layout != GstLayout::kTwoPipelines || first_.pictures == second_.pictures) return;
  LOG(WARNING) << NameOfSide(options_, LiveSide::kFirst) << " ended after "
               << first_.pictures.load() << " pictures, " << NameOfSide(options_, LiveSide::kSecond)
               << " after " << second_.pictures.load()
               << ": is a picture of one missing, or cut short?";
}

void SideWatch::TellFast(absl::Time now) {
  const double span_s = 1e-9 * static_cast<double>(first_.newest_ns - first_.first_ns);
  const double since_s = absl::ToDoubleSeconds(now - started_);
  if (told_fast_ || span_s < kFast * since_s + kFastAfter_s) return;
  told_fast_ = true;
  LOG(WARNING) << "the pipeline plays faster than its pictures' own times, " << span_s << " s in "
               << since_s
               << " s: newer frames replace those that are not taken yet, and most are lost. A "
                  "recording is played in its own time where its pipelines end in identity "
                  "sync=true";
}

}  // namespace corbslam::client_agent
