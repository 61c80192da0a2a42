// Converts keyframes' pictures to and from the wire.
#ifndef CORBSLAM_SERVICES_CONVERT_KEYFRAME_PICTURE_H_
#define CORBSLAM_SERVICES_CONVERT_KEYFRAME_PICTURE_H_

#include "corbslam/v1/map_update.pb.h"
#include "slam/exchange/uplink.h"

namespace corbslam::services {

void ToProto(const KeyframePicture& picture, v1::KeyframePicture* proto);
// Checks nothing: the map store validates what it keeps.
KeyframePicture FromProto(const v1::KeyframePicture& proto);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_KEYFRAME_PICTURE_H_
