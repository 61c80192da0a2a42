#include "services/tool/commands/render_past.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "services/tool/evaluation/past_picture.h"
#include "services/tool/output/result.h"
#include "slam/rendering/map_snapshots.h"
#include "slam/rendering/webp_animation.h"
#include "slam/util/status_macros.h"
#include "slam/util/whole_file.h"

namespace corbslam::services {
namespace {

using Messages = std::vector<v1::WatchMapResponse>;

// Named revisions want to be among the told moments; frames want to be few.
constexpr uint32_t kMomentsForPictures = 1000;
constexpr uint32_t kMomentsForFrames = 200;

uint32_t MomentsToAsk(const PastOptions& options) {
  if (options.moments != 0) return options.moments;
  return options.at.empty() ? kMomentsForFrames : kMomentsForPictures;
}

// Says which revisions are drawn: of those that were not told an earlier one is.
void SayMoments(const std::string& at, const std::vector<size_t>& moments,
                const std::vector<uint64_t>& told) {
  const std::string drawn = absl::StrJoin(moments, ", ", [&](std::string* text, size_t moment) {
    absl::StrAppend(text, told[moment]);
  });
  Say(absl::StrCat("--at ", at, ": revisions ", drawn, " of ", told.front(), " to ", told.back(),
                   "\n"));
}

absl::Status DrawMoments(const Messages& past, const std::string& own,
                         const FusedAccuracy& accuracy, const PastOptions& options,
                         const std::string& out) {
  const std::vector<uint64_t> told = RevisionsOf(past);
  ASSIGN_OR_RETURN(const std::vector<size_t> moments, ParseMoments(options.at, told));
  SayMoments(options.at, moments, told);
  const std::set<size_t> wanted(moments.begin(), moments.end());
  std::map<size_t, MapSnapshot> drawn;
  RETURN_IF_ERROR(ForEachMoment(past, [&](size_t number, const ToldMap& map) {
    if (wanted.contains(number)) drawn[number] = ComposeSnapshot(map, own, accuracy);
    return absl::OkStatus();
  }));
  std::vector<MapSnapshot> snapshots;
  for (const size_t moment : moments) snapshots.push_back(drawn.at(moment));
  if (IsSvg(out)) {
    ASSIGN_OR_RETURN(const std::string svg, RenderSnapshotsSvg(snapshots, {options.width_px}));
    return WriteWhole(out, svg);
  }
  ASSIGN_OR_RETURN(const cv::Mat image, RenderSnapshots(snapshots, {options.width_px}));
  return WriteImage(image, out);
}

// Goes through the past twice: what is largest decides the view of all frames.
absl::Status Animate(const Messages& past, const std::string& own, const FusedAccuracy& accuracy,
                     const PastOptions& options) {
  SnapshotStage stage;
  RETURN_IF_ERROR(ForEachMoment(past, [&](size_t, const ToldMap& map) {
    stage.Observe(ComposeSnapshot(map, own, accuracy));
    return absl::OkStatus();
  }));
  ASSIGN_OR_RETURN(WebpAnimation animation, WebpAnimation::Create(options.frames_per_second));
  RETURN_IF_ERROR(ForEachMoment(past, [&](size_t, const ToldMap& map) -> absl::Status {
    ASSIGN_OR_RETURN(const cv::Mat frame,
                     RenderFrame(stage, ComposeSnapshot(map, own, accuracy), {options.width_px}));
    return animation.Add(frame);
  }));
  ASSIGN_OR_RETURN(const std::string bytes, animation.Finish());
  return WriteWhole(options.animate, bytes);
}

}  // namespace

bool IsSvg(const std::string& path) { return absl::EndsWithIgnoreCase(path, ".svg"); }

absl::Status CheckPictureOptions(const std::string& out, int width_px) {
  if (width_px < 200 || width_px > 10'000) {
    return absl::InvalidArgumentError(absl::StrCat("--width ", width_px, " must be 200 to 10000"));
  }
  for (const char* ending : {".svg", ".png", ".jpg", ".jpeg", ".webp"}) {
    if (absl::EndsWithIgnoreCase(out, ending)) return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "--out ", out, ": the file must end with .svg or .png (.jpg and .webp work, too)"));
}

absl::Status CheckPastOptions(const PastOptions& options, const std::string& out) {
  if (options.moments == 1 || options.moments > WebpAnimation::kMostFrames) {
    return absl::InvalidArgumentError(
        absl::StrCat("--moments ", options.moments, " must be 2 to ", WebpAnimation::kMostFrames));
  }
  if (options.animate.empty()) return absl::OkStatus();
  if (options.animate == out) {
    return absl::InvalidArgumentError(absl::StrCat("--animate and --out are both ", out));
  }
  RETURN_IF_ERROR(WebpAnimation::Create(options.frames_per_second).status());
  if (absl::EndsWithIgnoreCase(options.animate, ".webp")) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "--animate ", options.animate,
      ": the file must end with .webp, which browsers play; ffmpeg makes other films of it"));
}

absl::Status RenderPast(StoreReader& store, const std::string& own, const FusedAccuracy& accuracy,
                        const PastOptions& options, const std::string& out) {
  const absl::StatusOr<Messages> past = store.ReadPast(MomentsToAsk(options));
  if (absl::IsUnimplemented(past.status())) {
    return absl::UnimplementedError(
        "the map store is older than this program and doesn't tell "
        "its missions' past (ReplayMap)");
  }
  if (absl::IsResourceExhausted(past.status())) {
    return absl::ResourceExhaustedError(absl::StrCat(
        past.status().message(), "; --moments asks for fewer than ", MomentsToAsk(options)));
  }
  RETURN_IF_ERROR(past.status());
  if (!options.at.empty()) RETURN_IF_ERROR(DrawMoments(*past, own, accuracy, options, out));
  if (options.animate.empty()) return absl::OkStatus();
  return Animate(*past, own, accuracy, options);
}

}  // namespace corbslam::services
