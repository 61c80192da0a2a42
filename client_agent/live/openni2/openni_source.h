// Registers the kind of sources that OpenNI 2 plays: openni2:.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_OPENNI2_OPENNI_SOURCE_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_OPENNI2_OPENNI_SOURCE_H_

namespace corbslam::client_agent {

// Registers "openni2:any", "openni2:URI" and "openni2:FILE.oni" (docs/live.md) with this program.
void RegisterOpenNiSources();

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_OPENNI2_OPENNI_SOURCE_H_
