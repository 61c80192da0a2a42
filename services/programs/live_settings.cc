#include "services/programs/live_settings.h"

#include <glog/logging.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"
#include "services/agent_service/mask_png.h"
#include "services/client/store/call_status.h"
#include "services/convert/resource_names.h"
#include "services/security/pem_files.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr absl::Duration kAskFor = absl::Seconds(10);
// Of refusals that the statistics name.
constexpr size_t kMostRefusals = 20;

absl::StatusOr<v1::RobotSettingsList> AskStore(const std::shared_ptr<grpc::Channel>& channel,
                                               const std::string& agent_name) {
  grpc::ClientContext context;
  context.set_deadline(absl::ToChronoTime(absl::Now() + kAskFor));
  v1::GetRobotSettingsRequest request;
  request.set_name(agent_name);
  v1::RobotSettingsList list;
  const grpc::Status status =
      v1::MapStore::NewStub(channel)->GetRobotSettings(&context, request, &list);
  // The mission begins with its first robot: nobody has set anything.
  if (status.error_code() == grpc::StatusCode::NOT_FOUND) return v1::RobotSettingsList();
  RETURN_IF_ERROR(ToStatus(status, "GetRobotSettings"));
  return list;
}

}  // namespace

absl::StatusOr<std::unique_ptr<LiveSettings>> LiveSettings::Make(LiveSettingsOptions options) {
  std::optional<SettingsBook> book;
  if (!options.files.key.empty()) {
    ASSIGN_OR_RETURN(const std::string pem, ReadSecurityFile("--settings-key", options.files.key));
    ASSIGN_OR_RETURN(std::vector<Ed25519Key> keys, ReadEd25519PublicKeys("settings key", pem));
    book.emplace(std::move(keys), options.mission, options.agent);
  }
  // The constructor is private.
  return std::unique_ptr<LiveSettings>(new LiveSettings(std::move(options), std::move(book)));
}

LiveSettings::LiveSettings(LiveSettingsOptions options, std::optional<SettingsBook> book)
    : options_(std::move(options)),
      book_(std::move(book)),
      flags_(options_.flags),
      begun_(options_.flags) {}

SettableFlags LiveSettings::Begin(const std::shared_ptr<grpc::Channel>& channel) {
  const bool asks = channel != nullptr && !options_.files.key.empty();
  absl::StatusOr<v1::RobotSettingsList> told = v1::RobotSettingsList();
  if (asks) told = AskStore(channel, AgentName(options_.mission, options_.agent));
  absl::MutexLock lock(&mutex_);
  if (!options_.files.kept.empty()) {
    const absl::StatusOr<v1::RobotSettingsList> kept = ReadKept(options_.files.kept);
    if (!kept.ok()) Refuse(kept.status());
    if (kept.ok()) Take(*kept);
  }
  if (told.ok()) {
    Take(*told);
  } else {
    LOG(WARNING) << "the map store does not say which settings it has for this robot, which begins "
                 << (lines_.empty() ? "with its flags alone: " : "with those that it kept: ")
                 << told.status();
  }
  options_.rate->Set(flags_.max_rate_hz);
  return begun_ = flags_;
}

bool LiveSettings::Take(const v1::RobotSettingsList& list) {
  if (list.settings().empty()) return false;
  if (!book_.has_value()) {
    if (!std::exchange(said_ignored_, true)) {
      LOG(WARNING) << "the map store has settings for this robot, which are left out: "
                      "--settings-key names no key that they may be signed with";
    }
    return false;
  }
  const SettingsBook::Taken taken = book_->Take(list);
  for (const absl::Status& why : taken.refused) Refuse(why);
  if (!taken.changed) return false;
  SettableFlags flags = options_.flags;
  const std::vector<std::string> lines =
      UseSettings(book_->of_all(), book_->own(), options_.given, flags);
  if (const absl::Status fits = options_.check(flags); !fits.ok()) {
    Refuse(absl::Status(fits.code(), absl::StrCat("the map store's settings don't fit this robot, "
                                                  "which goes on without the new ones: ",
                                                  fits.message())));
    return false;
  }
  flags_ = std::move(flags);
  lines_ = lines;
  for (const std::string& line : lines_) LOG(INFO) << "settings of the map store: " << line;
  if (options_.files.kept.empty()) return true;
  const absl::Status kept = WriteKept(book_->list(), options_.files.kept);
  LOG_IF(ERROR, !kept.ok()) << kept;
  return true;
}

void LiveSettings::Refuse(const absl::Status& why) {
  // A store that goes on telling them does not fill the log.
  if (refused_.size() < kMostRefusals && refused_.insert(std::string(why.message())).second) {
    LOG(ERROR) << why;
  }
}

void LiveSettings::SetMask() {
  const absl::StatusOr<PictureMask> mask = DecodeMask(flags_.mask_png);
  const absl::Status set = mask.ok() ? options_.orders->SetMask(*mask) : mask.status();
  if (!set.ok()) {
    Refuse(absl::Status(set.code(), absl::StrCat("the mask of the map store's settings is left "
                                                 "out: ",
                                                 set.message())));
  }
}

void LiveSettings::GiveMask() {
  absl::MutexLock lock(&mutex_);
  if (!flags_.mask_png.empty()) SetMask();
}

void LiveSettings::SayWhatNeedsARestart() const {
  if (flags_.features != begun_.features) {
    LOG(WARNING) << "features = " << flags_.features << " needs a restart of the robot, which has "
                 << begun_.features;
  }
  if (flags_.upload != begun_.upload) {
    LOG(WARNING) << "upload = " << flags_.upload << " needs a restart of the robot, which has "
                 << begun_.upload;
  }
}

void LiveSettings::OnSettings(const v1::RobotSettingsList& list) {
  absl::MutexLock lock(&mutex_);
  const std::string mask = flags_.mask_png;
  if (!Take(list)) return;
  options_.rate->Set(flags_.max_rate_hz);
  options_.orders->SetLimits(options_.limits(flags_));
  if (flags_.mask_png != mask) SetMask();
  SayWhatNeedsARestart();
}

nlohmann::ordered_json LiveSettings::Report() const {
  absl::MutexLock lock(&mutex_);
  if (!book_.has_value()) return nullptr;
  return {{"version_of_all", book_->of_all().version()},
          {"version_of_robot", book_->own().version()},
          {"taken", lines_},
          {"refused", refused_}};
}

}  // namespace corbslam::services
