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
#include "services/programs/kept_settings.h"
#include "services/security/pem_files.h"
#include "slam/util/named_thread.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr absl::Duration kAskFor = absl::Seconds(10);
// The statistics name so many refusals.
constexpr size_t kMostRefusals = 20;

absl::StatusOr<v1::RobotSettingsList> AskStore(v1::MapStore::Stub& store,
                                               const std::string& agent_name) {
  grpc::ClientContext context;
  context.set_deadline(absl::ToChronoTime(absl::Now() + kAskFor));
  v1::GetRobotSettingsRequest request;
  request.set_name(agent_name);
  v1::RobotSettingsList list;
  const grpc::Status status = store.GetRobotSettings(&context, request, &list);
  // The mission begins with its first robot: nobody has set anything.
  if (status.error_code() == grpc::StatusCode::NOT_FOUND) return v1::RobotSettingsList();
  RETURN_IF_ERROR(ToStatus(status, "GetRobotSettings"));
  return list;
}

}  // namespace

std::future<absl::StatusOr<v1::RobotSettingsList>> AskForSettings(std::shared_ptr<StoreRoute> route,
                                                                  const SettingsFlags& files,
                                                                  const std::string& mission,
                                                                  const std::string& agent) {
  const bool asks = route != nullptr && !files.key.empty();
  return StartAsync("first settings", [=]() -> absl::StatusOr<v1::RobotSettingsList> {
    if (!asks) return v1::RobotSettingsList();
    absl::StatusOr<v1::RobotSettingsList> list;
    RETURN_IF_ERROR(route->Ask([&](v1::MapStore::Stub& store) {
      list = AskStore(store, AgentName(mission, agent));
      return list.status();
    }));
    return list;
  });
}

LiveSettings::LiveSettings(LiveSettingsOptions options)
    : options_(std::move(options)), flags_(options_.flags), begun_(options_.flags) {}

void LiveSettings::ReadKeys() {
  if (book_.has_value() || options_.files.key.empty()) return;
  const auto read = [this]() -> absl::StatusOr<std::vector<Ed25519Key>> {
    ASSIGN_OR_RETURN(const std::string pem, ReadSecurityFile("--settings-key", options_.files.key));
    return ReadEd25519PublicKeys("settings key", pem);
  };
  absl::StatusOr<std::vector<Ed25519Key>> keys = read();
  if (keys.ok()) {
    book_.emplace(*std::move(keys), options_.mission, options_.agent);
    return;
  }
  Refuse(absl::Status(
      keys.status().code(),
      absl::StrCat("--settings-key ", options_.files.key,
                   ": no settings are taken until it can be read: ", keys.status().message())));
}

SettableFlags LiveSettings::Begin(const absl::StatusOr<v1::RobotSettingsList>& told) {
  absl::MutexLock lock(&mutex_);
  ReadKeys();
  if (!options_.files.kept.empty() && book_.has_value()) {
    const absl::StatusOr<v1::RobotSettingsList> kept = ReadKeptSettings(options_.files.kept);
    if (!kept.ok()) Refuse(kept.status());
    if (kept.ok()) Take(*kept, /*keep=*/false);
  }
  if (told.ok()) {
    Take(*told, /*keep=*/true);
  } else {
    LOG(WARNING) << "the map store does not say which settings it has for this robot, which begins "
                 << (lines_.empty() ? "with its flags alone: " : "with those that it kept: ")
                 << told.status();
  }
  options_.rate->Set(flags_.max_rate_hz);
  return begun_ = flags_;
}

absl::Status LiveSettings::Fits(const v1::RobotSettings& of_all,
                                const v1::RobotSettings& own) const {
  SettableFlags flags = options_.flags;
  UseSettings(of_all, own, options_.given, flags);
  RETURN_IF_ERROR(options_.check(flags));
  ASSIGN_OR_RETURN(const PictureMask mask, DecodeMask(flags.mask_png));
  return options_.orders->CheckMask(mask);
}

bool LiveSettings::Take(const v1::RobotSettingsList& list, bool keep) {
  if (list.settings().empty()) return false;
  ReadKeys();
  if (!book_.has_value()) {
    if (options_.files.key.empty() && !std::exchange(said_ignored_, true)) {
      LOG(WARNING) << "the map store has settings for this robot, which are left out: "
                      "--settings-key names no key that they may be signed with";
    }
    return false;
  }
  const SettingsBook::Taken taken =
      book_->Take(list, [this](const v1::RobotSettings& of_all, const v1::RobotSettings& own) {
        return Fits(of_all, own);
      });
  for (const absl::Status& why : taken.refused) Refuse(why);
  if (taken.learned && keep) Keep();
  if (!taken.changed) return false;
  flags_ = options_.flags;
  lines_ = UseSettings(book_->of_all(), book_->own(), options_.given, flags_);
  for (const std::string& line : lines_) LOG(INFO) << "settings of the map store: " << line;
  return true;
}

void LiveSettings::Keep() {
  if (options_.files.kept.empty()) return;
  const absl::Status kept = WriteKeptSettings(book_->list(), options_.files.kept);
  LOG_IF(ERROR, !kept.ok()) << kept;
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
  if (!Take(list, /*keep=*/true)) return;
  options_.rate->Set(flags_.max_rate_hz);
  options_.orders->SetLimits(options_.limits(begun_, flags_));
  if (flags_.mask_png != mask) SetMask();
  SayWhatNeedsARestart();
}

nlohmann::ordered_json LiveSettings::Report() const {
  absl::MutexLock lock(&mutex_);
  if (options_.files.key.empty()) return nullptr;
  return {{"version_of_all", book_.has_value() ? book_->of_all().version() : 0},
          {"version_of_robot", book_.has_value() ? book_->own().version() : 0},
          {"taken", lines_},
          {"refused", refused_}};
}

}  // namespace corbslam::services
