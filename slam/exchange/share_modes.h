// What people call the modes of sharing, in flags and in settings.
#ifndef CORBSLAM_SLAM_EXCHANGE_SHARE_MODES_H_
#define CORBSLAM_SLAM_EXCHANGE_SHARE_MODES_H_

#include "slam/exchange/uplink.h"
#include "slam/util/named_values.h"

namespace corbslam {

inline constexpr NamedValues<ShareMode, 4> kShareModes = {{{"none", ShareMode::kNone},
                                                           {"corrections", ShareMode::kCorrections},
                                                           {"nearby", ShareMode::kNearby},
                                                           {"everything", ShareMode::kEverything}}};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EXCHANGE_SHARE_MODES_H_
