// Knows kinds of sources beside the recorded layouts: a program registers those that it can play,
// for example a simulator's "sim:WORLD?OPTIONS".
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_SOURCE_KINDS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_SOURCE_KINDS_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/notification.h"

namespace corbslam::client_agent {

class FrameReader;
class FrameStream;
class KindSettings;
using SharedKindSettings = std::shared_ptr<const KindSettings>;

// The settings of a source of a registered kind, apart from which of its frames are played and how
// they are disturbed. Immutable, so that copies of a spec may share them.
class KindSettings {
 public:
  virtual ~KindSettings() = default;

  // Returns the name before the colon of a spec.
  virtual absl::string_view kind() const = 0;
  // Returns the names of the options, spelled with '_'.
  virtual std::vector<absl::string_view> OptionNames() const = 0;
  // Returns the same settings with one of the options changed. Returns INVALID_ARGUMENT, naming the
  // option, its value and what it wants.
  virtual absl::StatusOr<SharedKindSettings> With(absl::string_view key,
                                                  absl::string_view value) const = 0;
  // Checks all options together: returns INVALID_ARGUMENT, naming the option and its value.
  virtual absl::Status Validate() const = 0;
  // Returns name and value of the options that differ from their defaults; applying With for each
  // of them to the defaults gives the same settings.
  virtual std::vector<std::pair<std::string, std::string>> FormatOptions() const = 0;
  // Returns what Perturbation::seed becomes.
  virtual uint64_t noise_seed() const = 0;
  // True: a selection of frames counts them from the last one on, because the way is driven the
  // other way round.
  virtual bool turned() const = 0;
  virtual absl::StatusOr<std::unique_ptr<FrameReader>> Open() const = 0;
  // True: the source is a camera, which OpenLive opens, and Open says so.
  virtual bool is_live() const { return false; }
  // True: also an improbable calibration is to be taken (?trust-calibration).
  virtual bool trusts_calibration() const { return false; }
  // Returns what OpenLive would refuse before it starts the camera or waits for anybody.
  virtual absl::Status CheckLive() const { return Validate(); }
  // Opens the camera and starts it. Errors say what to do. One that waits for its camera ends with
  // CANCELLED once it is told to `stop`.
  virtual absl::StatusOr<std::unique_ptr<FrameStream>> OpenLive(
      const absl::Notification& stop) const;
};

struct SourceKind {
  std::string name;   // The name before the colon: "sim".
  std::string usage;  // For help texts: "sim:WORLD".
  // Makes default settings for what stands between the colon and the '?'. Returns INVALID_ARGUMENT,
  // naming what is known.
  std::function<absl::StatusOr<SharedKindSettings>(absl::string_view place)> make;
};

// Registers a kind. Thread-safe, as are the functions below. A kind that is registered already
// stays as it is; the names of the recorded layouts are taken.
void RegisterSourceKind(SourceKind kind);
std::optional<SourceKind> FindSourceKind(absl::string_view name);
// Returns "kitti", "euroc" and so on: the recorded layouts and the registered kinds.
std::vector<std::string> KnownSourceKinds();
// Returns "kitti:DIR, euroc:DIR, tum:DIR, 7scenes:DIR or sim:WORLD".
std::string SourceUsage();

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_SOURCE_KINDS_H_
