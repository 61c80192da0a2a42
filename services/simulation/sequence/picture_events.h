// Says what happens to a picture: exposure that jumps, a lens out of focus, a hand before it.
#ifndef CORBSLAM_SERVICES_SIMULATION_SEQUENCE_PICTURE_EVENTS_H_
#define CORBSLAM_SERVICES_SIMULATION_SEQUENCE_PICTURE_EVENTS_H_

#include "services/simulation/sequence/simulation_spec.h"

namespace corbslam {

// What Shot's fields of the same names are.
struct PictureEvents {
  double exposure = 1;
  double defocus_px = 0;
  double covered = 0;
};

// `elapsed_s` is the sequence's own time.
PictureEvents EventsAt(const SimulationSpec& spec, double elapsed_s);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_SEQUENCE_PICTURE_EVENTS_H_
