#include "tests/strangers/newcomer_mistakes.h"

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "services/tool/doctor/local_checks.h"
#include "tests/strangers/strange_recordings.h"

namespace corbslam::tests {

using client_agent::SourceLayout;
using services::CheckSource;
using services::Finding;
using services::Level;

namespace {

namespace fs = std::filesystem;

using Change = std::function<void(const std::string&)>;
using Make = std::function<std::string(const std::string&)>;

Change RemoveFile(const std::string& name) {
  return [name](const std::string& folder) { fs::remove_all(absl::StrCat(folder, "/", name)); };
}

Change WriteFile(const std::string& name, const std::vector<std::string>& lines) {
  return [=](const std::string& folder) { WriteAllLines(absl::StrCat(folder, "/", name), lines); };
}

Change Replace(const std::string& name, const std::string& from, const std::string& to) {
  return
      [=](const std::string& folder) { ReplaceInFile(absl::StrCat(folder, "/", name), from, to); };
}

Change Rename(const std::string& from, const std::string& to) {
  return [=](const std::string& folder) {
    fs::rename(absl::StrCat(folder, "/", from), absl::StrCat(folder, "/", to));
  };
}

Change Resize(const std::vector<std::string>& folders, double factor) {
  return [=](const std::string& folder) {
    for (const std::string& each : folders) {
      ChangePictures(folder, each, cv::IMREAD_UNCHANGED, [factor](const cv::Mat& image) {
        cv::Mat resized;
        cv::resize(image, resized, {}, factor, factor, cv::INTER_NEAREST);
        return resized;
      });
    }
  };
}

Change KeepLines(const std::string& name, size_t count) {
  return [=](const std::string& folder) {
    std::vector<std::string> lines = ReadAllLines(absl::StrCat(folder, "/", name));
    lines.resize(count);
    WriteAllLines(absl::StrCat(folder, "/", name), lines);
  };
}

// Detaches the folder: its files become local, and no link leads away from it.
void Detach(const std::string& folder) {
  for (const char* kind : {"rgb", "depth"}) {
    ChangeBytes(folder, kind, [](const std::string& bytes) { return bytes; });
  }
}

Make Stereo(SourceLayout layout, const std::string& prefix, const Change& change,
            const std::string& suffix = "") {
  return [=](const std::string& name) {
    const std::string folder = CopyStereo(layout, name);
    change(folder);
    return absl::StrCat(prefix, folder, suffix);
  };
}
Make Kitti(const Change& change, const std::string& suffix = "") {
  return Stereo(SourceLayout::kKitti, "kitti:", change, suffix);
}
Make Euroc(const Change& change, const std::string& suffix = "") {
  return Stereo(SourceLayout::kEuroc, "euroc:", change, suffix);
}

class Recordings {
 public:
  explicit Recordings(std::string recording) : recording_(std::move(recording)) {}

  Make Tum(const Change& change, const std::string& suffix = "") const {
    return [=, recording = recording_](const std::string& name) {
      const std::string folder = CopyRgbd(recording, name);
      change(folder);
      return absl::StrCat("tum:", folder, suffix);
    };
  }

  // Makes ETH3D's layout: calibration.txt with four numbers, associated.txt.
  Make Eth3d(const Change& change, const std::string& suffix = "") const {
    return Tum(
        [=](const std::string& folder) {
          Detach(folder);
          fs::remove(folder + "/calibration.yaml");
          WriteAllLines(folder + "/calibration.txt",
                        {"517.306408 516.469215 318.643040 255.313989"});
          change(folder);
        },
        suffix);
  }

  // Makes ICL-NUIM's layout: associations.txt with numbers for times and the depth image first; no
  // calibration.
  Make Icl(const Change& change, const std::string& suffix = "?camera=icl-nuim") const {
    return Tum(
        [=](const std::string& folder) {
          Detach(folder);
          fs::remove(folder + "/calibration.yaml");
          std::vector<std::string> lines = ReadAllLines(folder + "/associated.txt");
          for (size_t i = 0; i < lines.size(); ++i) {
            const std::vector<std::string> f = absl::StrSplit(lines[i], ' ');
            lines[i] = absl::StrCat(i, " ", f[3], " ", i, " ", f[1]);
          }
          fs::remove(folder + "/associated.txt");
          WriteAllLines(folder + "/associations.txt", lines);
          change(folder);
        },
        suffix);
  }

  // Makes 7-Scenes' layout: numbered pictures, depth in millimetres.
  Make SevenScenes(const Change& change,
                   const std::string& suffix = "?fps=30&camera=7-scenes") const {
    return [=, recording = recording_](const std::string& name) {
      const std::string folder = MakeStrangerFolder(name);
      const std::vector<std::string> lines = ReadAllLines(recording + "/associated.txt");
      for (size_t i = 0; i < 20; ++i) {
        const std::vector<std::string> f = absl::StrSplit(lines[i], ' ');
        fs::create_symlink(absl::StrCat(recording, "/", f[1]),
                           absl::StrFormat("%s/frame-%06d.color.png", folder, i));
        cv::Mat depth = cv::imread(absl::StrCat(recording, "/", f[3]), cv::IMREAD_UNCHANGED);
        depth.convertTo(depth, CV_16UC1, 0.2);
        depth.setTo(65535, depth == 0);
        cv::imwrite(absl::StrFormat("%s/frame-%06d.depth.png", folder, i), depth);
      }
      change(folder);
      return absl::StrCat("7scenes:", folder, suffix);
    };
  }

 private:
  const std::string recording_;
};

void AddKitti(std::vector<NewcomerMistake>& list) {
  const std::string d = "KITTI";
  const Change none = [](const std::string&) {};
  list.push_back({d, "the folder above, with the sequences in it",
                  [](const std::string& name) {
                    return "kitti:" +
                           fs::path(CopyStereo(SourceLayout::kKitti, name)).parent_path().string();
                  },
                  Level::kFail, "KITTI raw has image_00/data and image_01/data. Is kitti:"});
  list.push_back({d, "a folder that is not there",
                  [](const std::string&) { return "kitti:/data/kitti/00"; }, Level::kFail,
                  "/data/kitti/00: there is no such folder"});
  list.push_back(
      {d, "calib.txt forgotten", Kitti(RemoveFile("calib.txt")), Level::kFail, "calib.txt"});
  list.push_back(
      {d, "times.txt forgotten", Kitti(RemoveFile("times.txt")), Level::kFail, "say ?fps=RATE"});
  list.push_back({d, "times.txt of a shorter sequence", Kitti(KeepLines("times.txt", 7)),
                  Level::kFail, "7 times, but pictures are numbered up to"});
  list.push_back({d, "only the left camera's pictures", Kitti(RemoveFile("image_1")), Level::kFail,
                  "no pictures of a stereo pair"});
  list.push_back({d, "pictures at half size, calib.txt as it was",
                  Kitti(Resize({"image_0", "image_1"}, 0.5)), Level::kFail,
                  "of pictures of another size"});
  list.push_back({d, "left and right folders exchanged", Kitti([](const std::string& folder) {
                    Rename("image_0", "aside")(folder);
                    Rename("image_1", "image_0")(folder);
                    Rename("aside", "image_1")(folder);
                  }),
                  Level::kFail, "left and right are exchanged"});
  list.push_back({d, "the left folder copied as the right one",
                  Kitti([](const std::string& folder) {
                    fs::remove_all(folder + "/image_1");
                    fs::copy(folder + "/image_0", folder + "/image_1",
                             fs::copy_options::recursive | fs::copy_options::copy_symlinks);
                  }),
                  Level::kFail, "same"});
  list.push_back({d, "another layout's name", Kitti(none, "?camera=freiburg1"), Level::kFail,
                  "unknown source option 'camera'"});
}

void AddEuroc(std::vector<NewcomerMistake>& list) {
  const std::string d = "EuRoC";
  list.push_back({d, "the zip's folder above mav0's parent",
                  [](const std::string& name) {
                    return "euroc:" +
                           fs::path(CopyStereo(SourceLayout::kEuroc, name)).parent_path().string();
                  },
                  Level::kFail, "cam0/sensor.yaml. Is euroc:"});
  list.push_back(
      {d, "only cam0 unpacked", Euroc(RemoveFile("mav0/cam1")), Level::kFail, "cam1/sensor.yaml"});
  list.push_back({d, "sensor.yaml of a lens that is not known",
                  Euroc(Replace("mav0/cam0/sensor.yaml", "radial-tangential", "fov")), Level::kFail,
                  "distortion_model is 'fov'"});
  list.push_back({d, "a Kalibr word in sensor.yaml",
                  Euroc(Replace("mav0/cam0/sensor.yaml", "radial-tangential", "radtan")),
                  Level::kOk, ""});
  list.push_back({d, "resolution left at another camera's", Euroc([](const std::string& folder) {
                    for (const char* camera : {"cam0", "cam1"}) {
                      const std::string path =
                          absl::StrCat(folder, "/mav0/", camera, "/sensor.yaml");
                      std::vector<std::string> lines = ReadAllLines(path);
                      for (std::string& line : lines) {
                        if (line.rfind("resolution", 0) == 0) line = "resolution: [752, 480]";
                      }
                      WriteAllLines(path, lines);
                    }
                  }),
                  Level::kFail, ""});
  list.push_back({d, "T_BS in millimetres", Euroc([](const std::string& folder) {
                    const std::string path = folder + "/mav0/cam1/sensor.yaml";
                    std::vector<std::string> lines = ReadAllLines(path);
                    for (std::string& line : lines) {
                      if (line.find("  data: [1, 0, 0, ") == 0) {
                        line =
                            "  data: [1.0, 0.0, 0.0, 537.2, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, "
                            "0.0, 0.0, 0.0, 0.0, 1.0]";
                      }
                    }
                    WriteAllLines(path, lines);
                  }),
                  Level::kFail, "is it in metres?"});
  list.push_back({d, "data.csv in seconds", Euroc([](const std::string& folder) {
                    const std::string path = folder + "/mav0/cam0/data.csv";
                    std::vector<std::string> lines = ReadAllLines(path);
                    for (size_t i = 1; i < lines.size(); ++i) lines[i] = "1." + lines[i];
                    WriteAllLines(path, lines);
                  }),
                  Level::kFail, "no time in whole nanoseconds"});
  list.push_back({d, "cam0 and cam1 exchanged", Euroc([](const std::string& folder) {
                    Rename("mav0/cam0", "mav0/aside")(folder);
                    Rename("mav0/cam1", "mav0/cam0")(folder);
                    Rename("mav0/aside", "mav0/cam1")(folder);
                  }),
                  Level::kFail, "mostly along +x"});
  list.push_back({d, "pictures moved out of data/", Euroc([](const std::string& folder) {
                    for (const std::string& path : FilesOf(folder + "/mav0/cam0/data")) {
                      fs::rename(path, absl::StrCat(folder, "/mav0/cam0/",
                                                    fs::path(path).filename().string()));
                    }
                  }),
                  Level::kFail, "a picture is not there"});
  list.push_back(
      {d, "a KITTI folder called euroc:",
       [](const std::string& name) { return "euroc:" + CopyStereo(SourceLayout::kKitti, name); },
       Level::kFail, "cam0/sensor.yaml. It looks like a folder for kitti:"});
}

void AddTum(const Recordings& r, std::vector<NewcomerMistake>& list) {
  const std::string d = "TUM RGB-D";
  list.push_back({d, "own camera, no calibration", r.Tum([](const std::string& folder) {
                    Detach(folder);
                    fs::remove(folder + "/calibration.yaml");
                  }),
                  Level::kFail, "no calibration. Put calibration.yaml there"});
  list.push_back({d, "no associated.txt and no rgb.txt", r.Tum(RemoveFile("associated.txt")),
                  Level::kFail, "neither associated.txt nor"});
  list.push_back({d, "the list of pairs called rgb.txt", r.Tum(Rename("associated.txt", "rgb.txt")),
                  Level::kFail, "a list of pairs is called associated.txt"});
  list.push_back({d, "calibration.yaml in ORB-SLAM's words",
                  r.Tum(WriteFile("calibration.yaml", {"Camera.fx: 517.3", "Camera.fy: 516.5"})),
                  Level::kFail, "unknown field Camera.fx: known are fx, fy, cx, cy"});
  list.push_back(
      {d, "fx, cx, fy, cy in the wrong order",
       r.Tum(WriteFile("calibration.yaml", {"fx: 517.3", "fy: 318.6", "cx: 516.5", "cy: 255.3"})),
       Level::kFail, "can't be"});
  list.push_back({d, "pictures at half size", r.Tum(Resize({"rgb", "depth"}, 0.5)), Level::kFail,
                  "of pictures of another size"});
  list.push_back({d, "depth images as 8-bit pictures for the eye",
                  r.Tum([](const std::string& folder) {
                    ChangePictures(folder, "depth", cv::IMREAD_UNCHANGED, [](const cv::Mat& image) {
                      cv::Mat grey;
                      image.convertTo(grey, CV_8UC1, 0.005);
                      return grey;
                    });
                  }),
                  Level::kFail, "one channel of 16 bits"});
  list.push_back({d, "the columns of associate.py the other way round",
                  r.Tum([](const std::string& folder) {
                    std::vector<std::string> lines = ReadAllLines(folder + "/associated.txt");
                    for (std::string& line : lines) {
                      const std::vector<std::string> f = absl::StrSplit(line, ' ');
                      line = absl::StrCat(f[2], " ", f[3], " ", f[0], " ", f[1]);
                    }
                    WriteAllLines(folder + "/associated.txt", lines);
                  }),
                  Level::kOk, ""});
  list.push_back({d, "another camera's name in ?camera=",
                  r.Tum([](const std::string&) {}, "?camera=realsense"), Level::kFail,
                  "wants one of freiburg1"});
  list.push_back({d, "a picture deleted by mistake", r.Tum([](const std::string& folder) {
                    fs::remove(FilesOf(folder + "/rgb")[11]);
                  }),
                  Level::kWarn, "a picture is not there"});
}

void AddEth3d(const Recordings& r, std::vector<NewcomerMistake>& list) {
  const std::string d = "ETH3D";
  const Change none = [](const std::string&) {};
  list.push_back({d, "as it is unpacked", r.Eth3d(none), Level::kOk, ""});
  list.push_back({d, "calibration.txt forgotten", r.Eth3d(RemoveFile("calibration.txt")),
                  Level::kFail, "no calibration"});
  list.push_back({d, "calibration.txt of another sequence (739x458), which says no size",
                  r.Eth3d(WriteFile("calibration.txt", {"726.287 726.287 354.650 186.466"})),
                  Level::kOk, ""});
  list.push_back({d, "calibration.txt with a fifth number",
                  r.Eth3d(WriteFile("calibration.txt", {"517.3 516.5 318.6 255.3 0.1"})),
                  Level::kFail, "5 numbers instead of fx fy cx cy"});
  list.push_back(
      {d, "a matrix in calibration.txt",
       r.Eth3d(WriteFile("calibration.txt", {"517.3 0 318.6", "0 516.5 255.3", "0 0 1"})),
       Level::kFail, "3 numbers instead of fx fy cx cy"});
  list.push_back({d, "commas for points",
                  r.Eth3d(WriteFile("calibration.txt", {"517,3 516,5 318,6 255,3"})), Level::kFail,
                  "is no number"});
  list.push_back({d, "the raw stereo of the same scene called kitti:",
                  [make = r.Eth3d(none)](const std::string& name) {
                    return absl::StrCat("kitti:", make(name).substr(4));
                  },
                  Level::kFail,
                  "image_00/data and image_01/data. It looks like a folder for tum:"});
  list.push_back({d, "depth/ not unpacked", r.Eth3d(RemoveFile("depth")), Level::kFail,
                  "a picture is not there"});
  list.push_back({d, "associated.txt cut in a line", r.Eth3d([](const std::string& folder) {
                    std::vector<std::string> lines = ReadAllLines(folder + "/associated.txt");
                    lines.back().resize(30);
                    WriteAllLines(folder + "/associated.txt", lines);
                  }),
                  Level::kFail, "fields instead of 4"});
  list.push_back({d, "pictures scaled to three quarters", r.Eth3d(Resize({"rgb", "depth"}, 0.75)),
                  Level::kFail, "can't be"});
}

void AddIcl(const Recordings& r, std::vector<NewcomerMistake>& list) {
  const std::string d = "ICL-NUIM";
  const Change none = [](const std::string&) {};
  list.push_back({d, "no option: nothing says which camera", r.Icl(none, ""), Level::kFail,
                  "?camera=NAME for one of freiburg1, freiburg2, freiburg3, icl-nuim"});
  list.push_back({d, "the option in another spelling", r.Icl(none, "?camera=ICL"), Level::kFail,
                  "wants one of freiburg1"});
  list.push_back({d, "with the option", r.Icl(none), Level::kOk, ""});
  list.push_back(
      {d, "fy: -480, as published",
       r.Icl(WriteFile("calibration.yaml", {"fx: 481.2", "fy: -480", "cx: 319.5", "cy: 239.5"}),
             ""),
       Level::kFail,
       "fy_px is -480, must be in [1, 100000] (rows are counted downwards here: without the sign"});
  list.push_back({d, "the .depth files of text instead of depth/*.png",
                  r.Icl([](const std::string& folder) {
                    ChangeBytes(folder, "depth", [](const std::string&) { return "1.0 2.0\n"; });
                  }),
                  Level::kFail, ""});
  list.push_back({d, "associations.txt not made", r.Icl(RemoveFile("associations.txt")),
                  Level::kFail, "neither associated.txt nor associations.txt"});
  list.push_back({d, "picture numbers that start over", r.Icl([](const std::string& folder) {
                    std::vector<std::string> lines = ReadAllLines(folder + "/associations.txt");
                    for (size_t i = 15; i < 30; ++i) {
                      const std::vector<std::string> f = absl::StrSplit(lines[i], ' ');
                      lines[i] = absl::StrCat(i - 15, " ", f[1], " ", i - 15, " ", f[3]);
                    }
                    WriteAllLines(folder + "/associations.txt", lines);
                  }),
                  Level::kWarn, "the time jumps back"});
  list.push_back({d, "both columns of pictures", r.Icl([](const std::string& folder) {
                    std::vector<std::string> lines = ReadAllLines(folder + "/associations.txt");
                    for (std::string& line : lines) {
                      const std::vector<std::string> f = absl::StrSplit(line, ' ');
                      line = absl::StrCat(f[0], " ", f[3], " ", f[2], " ", f[3]);
                    }
                    WriteAllLines(folder + "/associations.txt", lines);
                  }),
                  Level::kFail, "which is the depth image"});
  list.push_back({d, "depth in millimetres (?calibration with 1000)",
                  [make = r.Icl(none, "")](const std::string& name) {
                    const std::string spec = make(name);
                    const std::string file = spec.substr(4) + "/mine.yaml";
                    WriteAllLines(file, {"fx: 481.2", "fy: 480", "cx: 319.5", "cy: 239.5",
                                         "depth_units_per_m: 100"});
                    return absl::StrCat(spec, "?calibration=", file);
                  },
                  Level::kWarn, "depth"});
  list.push_back({d, "the folder of rgb instead of its parent",
                  [make = r.Icl(none, "")](const std::string& name) {
                    return make(name) + "/rgb?camera=icl-nuim";
                  },
                  Level::kFail, "neither associated.txt nor"});
}

void AddSevenScenes(const Recordings& r, std::vector<NewcomerMistake>& list) {
  const std::string d = "7-Scenes";
  const Change none = [](const std::string&) {};
  list.push_back({d, "no options", r.SevenScenes(none, ""), Level::kFail, "say ?fps=RATE"});
  list.push_back(
      {d, "a rate and no camera", r.SevenScenes(none, "?fps=30"), Level::kFail, "no calibration"});
  list.push_back({d, "as docs/sources.md says", r.SevenScenes(none), Level::kOk, ""});
  list.push_back({d, "the scene's folder instead of seq-01's",
                  [](const std::string& name) {
                    return absl::StrCat("7scenes:", MakeStrangerFolder(name),
                                        "?fps=30&camera=7-scenes");
                  },
                  Level::kFail, "in the folders seq-01, seq-02"});
  list.push_back({d, "called tum:",
                  [make = r.SevenScenes(none, "")](const std::string& name) {
                    return absl::StrCat("tum:", make(name).substr(8), "?camera=7-scenes");
                  },
                  Level::kFail,
                  "goes with which depth image. It looks like a folder for 7scenes:"});
  list.push_back({d, "a rate of 0", r.SevenScenes(none, "?fps=0&camera=7-scenes"), Level::kFail,
                  "fps=0: wants a number from 0.1 to 1000"});
  list.push_back({d, "Freiburg's camera", r.SevenScenes(none, "?fps=30&camera=freiburg1"),
                  Level::kWarn, "depth"});
  list.push_back({d, "depth images without some", r.SevenScenes([](const std::string& folder) {
                    fs::remove(folder + "/frame-000004.depth.png");
                  }),
                  Level::kWarn, "a picture is not there"});
  list.push_back({d, "colour pictures as the depth", r.SevenScenes([](const std::string& folder) {
                    for (const std::string& path : FilesOf(folder)) {
                      const size_t at = path.find(".depth.png");
                      if (at == std::string::npos) continue;
                      fs::remove(path);
                      fs::copy_file(path.substr(0, at) + ".color.png", path);
                    }
                  }),
                  Level::kFail, "one channel of 16 bits"});
  list.push_back({d, "pictures at half size", r.SevenScenes(Resize({"."}, 0.5)), Level::kFail,
                  "these intrinsics are of 640x480 pictures"});
}

}  // namespace

std::vector<NewcomerMistake> NewcomerMistakes(const std::string& recording) {
  std::vector<NewcomerMistake> list;
  const Recordings recordings(recording);
  AddKitti(list);
  AddTum(recordings, list);
  AddEuroc(list);
  AddEth3d(recordings, list);
  AddIcl(recordings, list);
  AddSevenScenes(recordings, list);
  return list;
}

Said WhatDoctorSays(const std::string& source) {
  Said said;
  for (const Finding& finding : CheckSource(source, false)) {
    if (!said.text.empty() && finding.level <= said.level) continue;
    said = {finding.level, finding.text};
  }
  return said;
}

}  // namespace corbslam::tests
