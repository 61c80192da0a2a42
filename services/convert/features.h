// Converts keyframes' payloads, and the cameras that they name, to and from the wire.
#ifndef CORBSLAM_SERVICES_CONVERT_FEATURES_H_
#define CORBSLAM_SERVICES_CONVERT_FEATURES_H_

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "corbslam/v1/items.pb.h"
#include "slam/camera/camera.h"
#include "slam/features/keypoint.h"
#include "slam/map/keyframe.h"
#include "slam/util/ids.h"

namespace corbslam::services {

// Knows the cameras that one side of a stream has named so far. Not thread-safe.
class CameraBook {
 public:
  // Adds a camera. INVALID_ARGUMENT: the index is too high, or names another camera already.
  // RESOURCE_EXHAUSTED: kMaxCamerasOfStream are named.
  absl::Status Add(LocalMapId local_map, uint32_t index, std::shared_ptr<const Camera> camera);
  // Returns null when the camera was never named.
  std::shared_ptr<const Camera> Find(LocalMapId local_map, uint32_t index) const;

 private:
  std::map<std::pair<LocalMapId, uint32_t>, std::shared_ptr<const Camera>> cameras_;
};

// Features travel as columns, which everybody reads, or coded, which takes few bytes and is for
// readers that have said so (Capabilities::coded_features). Both say the same to the bit.
enum class FeatureForm { kPlain, kCoded };

// The wire keeps positions to 1/64 px, disparities to 1/128 px and angles to 2^-14 turns; features
// that were once on it pass unchanged.
void ToProto(const Features& features, v1::Features* proto);
// Codes the features where that is shorter and `form` allows it; the payload's code is used if it
// is at hand.
void ToProto(const KeyframePayload& payload, v1::KeyframePayload* proto,
             FeatureForm form = FeatureForm::kPlain);

// Returns about what the features take as columns, and at least what they take as they are: limits
// of bytes are of this, so that a short code can't stand for more than a long message could.
size_t UncodedBytes(const v1::Features& proto);

// Reads either form. INVALID_ARGUMENT names the field. Descriptors may be absent if
// `descriptors_optional`.
absl::StatusOr<Features> FromProto(const v1::Features& proto, const Camera& camera,
                                   bool descriptors_optional = false);
// Reads a payload, whose camera must be in the book. `code` is that of proto's features, for the
// payload.
absl::StatusOr<std::shared_ptr<const KeyframePayload>> FromProto(
    const v1::KeyframePayload& proto, KeyframeId id, const CameraBook& cameras,
    bool descriptors_optional = false, std::weak_ptr<const std::string> code = {});

// A descriptor has 32 bytes, the least significant byte first.
std::string DescriptorsToBytes(const std::vector<Descriptor>& descriptors);
void AppendDescriptor(const Descriptor& descriptor, std::string* bytes);
// Returns a descriptor; `bytes` must hold at least 32 * (index + 1) bytes.
Descriptor DescriptorFromBytes(const std::string& bytes, size_t index);

// Returns an error unless the time is from 0 to kMaxTimestamp_ns.
absl::Status CheckTimestamp(int64_t timestamp_ns);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_FEATURES_H_
