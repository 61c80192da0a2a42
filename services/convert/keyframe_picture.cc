#include "services/convert/keyframe_picture.h"

namespace corbslam::services {

void ToProto(const KeyframePicture& picture, v1::KeyframePicture* proto) {
  proto->set_local_map(picture.keyframe.local_map.value);
  proto->set_index(picture.keyframe.index);
  proto->set_jpeg(picture.jpeg);
  proto->set_scale(picture.scale);
}

KeyframePicture FromProto(const v1::KeyframePicture& proto) {
  return {{{proto.local_map()}, proto.index()}, proto.jpeg(), proto.scale()};
}

}  // namespace corbslam::services
