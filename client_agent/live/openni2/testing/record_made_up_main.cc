// Records 0.7 s of the made-up device's colour and depth, mirrored, into the .oni file that its
// argument names.
#include <OpenNI.h>

#include <chrono>
#include <cstdio>
#include <thread>

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s FILE.oni\n", argv[0]);
    return 2;
  }
  openni::Device device;
  openni::VideoStream colour, depth;
  openni::Recorder recorder;
  const auto ok = [](openni::Status status) { return status == openni::STATUS_OK; };
  if (!ok(openni::OpenNI::initialize()) || !ok(device.open(openni::ANY_DEVICE)) ||
      !ok(colour.create(device, openni::SENSOR_COLOR)) ||
      !ok(depth.create(device, openni::SENSOR_DEPTH)) || !ok(recorder.create(argv[1])) ||
      !ok(recorder.attach(colour, /*allowLossyCompression=*/false)) ||
      !ok(recorder.attach(depth, false)) || !ok(colour.start()) || !ok(depth.start()) ||
      !ok(recorder.start())) {
    std::fprintf(stderr, "%s: %s\n", argv[1], openni::OpenNI::getExtendedError());
    return 1;
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  recorder.stop();
  recorder.destroy();
  return 0;
}
